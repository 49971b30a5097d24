// Half of a block, 0 <= y, above a ball that touches it at the origin: fine where it touches, growing outwards.
//   gmsh -3 mindlin.geo -bin -o mindlin.msh
inner = 0.125;   // half width of the fine part, 1.25 contact radii
outer = 1;       // half width of the block
fine = 10;       // cells along `inner`
coarse = 7;      // cells from `inner` to `outer`
growth = 1.5;    // from one to the next

Point(1) = {-outer, 0, 0}; Point(2) = {-inner, 0, 0}; Point(3) = {inner, 0, 0}; Point(4) = {outer, 0, 0};
Point(5) = {-outer, inner, 0}; Point(6) = {-inner, inner, 0}; Point(7) = {inner, inner, 0}; Point(8) = {outer, inner, 0};
Point(9) = {-outer, outer, 0}; Point(10) = {-inner, outer, 0}; Point(11) = {inner, outer, 0}; Point(12) = {outer, outer, 0};
For row In {0:2}
  For column In {0:2}
    Line(1 + 3*row + column) = {1 + 4*row + column, 2 + 4*row + column};
  EndFor
EndFor
For column In {0:3}
  Line(10 + column) = {1 + column, 5 + column};
  Line(14 + column) = {5 + column, 9 + column};
EndFor
For row In {0:2}
  Transfinite Curve {1 + 3*row} = coarse + 1 Using Progression 1/growth;
  Transfinite Curve {2 + 3*row} = 2*fine + 1;
  Transfinite Curve {3 + 3*row} = coarse + 1 Using Progression growth;
EndFor
For column In {0:3}
  Transfinite Curve {10 + column} = fine + 1;
  Transfinite Curve {14 + column} = coarse + 1 Using Progression growth;
EndFor
For row In {0:1}
  For column In {0:2}
    k = 1 + 3*row + column;
    Curve Loop(k) = {1 + 3*row + column, 11 + 4*row + column, -(4 + 3*row + column), -(10 + 4*row + column)};
    Plane Surface(k) = {k};
    Transfinite Surface {k};
    Recombine Surface {k};
  EndFor
EndFor
// Layers upwards, each 1.35 times as high as the one below.
n = 12;
ratio = 1.35;
heights[] = {};
ones[] = {};
For k In {1:n}
  heights[] += {(ratio^k - 1)/(ratio^n - 1)};
  ones[] += {1};
EndFor
Extrude {0, 0, 1} { Surface{1:6}; Layers{ ones[], heights[] }; Recombine; }
Mesh.MshFileVersion = 4.1;
e = 1e-6;
Physical Surface("foot") = {2};
top() = Surface In BoundingBox {-1 - e, -e, 1 - e, 1 + e, 1 + e, 1 + e};
Physical Surface("top") = {top()};
middle() = Surface In BoundingBox {-1 - e, -e, -e, 1 + e, e, 1 + e};
Physical Surface("middle") = {middle()};
Physical Volume("body") = {1:6};

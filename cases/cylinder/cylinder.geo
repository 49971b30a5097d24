// Quarter of a cylinder of radius 50 mm, a slice of 1 mm: fine at the lowest line, coarse away from it.
//   gmsh -3 cylinder.geo -o cylinder.msh -setnumber fine 0.5
DefineConstant[ fine = 0.5 ];
radius = 50;

Point(1) = {0, 0, radius};
Point(2) = {0, 0, 0};
Point(3) = {radius, 0, radius};
Line(1) = {1, 2};
Circle(2) = {2, 1, 3};
Line(3) = {3, 1};
Curve Loop(1) = {1, 2, 3};
Plane Surface(1) = {1};
Recombine Surface{1};

Field[1] = Distance;
Field[1].PointsList = {2};
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = fine;
Field[2].SizeMax = 16 * fine;
Field[2].DistMin = 7;
Field[2].DistMax = 60;
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 8;

slice[] = Extrude {0, 1, 0} { Surface{1}; Layers{1}; Recombine; };
Physical Surface("front") = {1};
Physical Surface("back") = {slice[0]};
Physical Surface("symmetry") = {slice[2]};
Physical Surface("arc") = {slice[3]};
Physical Surface("top") = {slice[4]};
Physical Volume("body") = {slice[1]};

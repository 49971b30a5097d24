// Quarter of a ring: radii r to R, height h; n cells along the arc, m through the wall, k along the axis.
//   gmsh -3 ring.geo -o inner.msh -setnumber r 40 -setnumber R 60 -setnumber n 20 -setnumber m 5 -setnumber k 2
//   gmsh -3 ring.geo -o outer.msh -setnumber r 60 -setnumber R 90 -setnumber n 17 -setnumber m 6 -setnumber k 3
DefineConstant[ r = 40, R = 60, h = 12, n = 20, m = 5, k = 2 ];

Point(1) = {r, 0, 0};
Point(2) = {R, 0, 0};
Line(1) = {1, 2};
Transfinite Curve{1} = m + 1;
wall[] = Extrude {{0, 0, 1}, {0, 0, 0}, Pi/2} { Curve{1}; Layers{n}; Recombine; };
ring[] = Extrude {0, 0, h} { Surface{wall[1]}; Layers{k}; Recombine; };

Physical Surface("bottom") = {wall[1]};
Physical Surface("top") = {ring[0]};
Physical Surface("side-y") = {ring[2]};
Physical Surface("outside") = {ring[3]};
Physical Surface("side-x") = {ring[4]};
Physical Surface("inside") = {ring[5]};
Physical Volume("body") = {ring[1]};

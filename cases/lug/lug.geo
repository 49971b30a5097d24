// Half of a lug: an eye with a bore, a neck and a flange with fillets; z = 0 is its plane of symmetry. Millimetres.
//   gmsh -3 lug.geo -o lug.msh
SetFactory("OpenCASCADE");
bore = 10.05;   // radius
eye = 22;       // radius
neck = 15;      // half width
flange = 32;    // half width
fillet = 8;
half = 6;       // half of the thickness

Disk(1) = {0, 0, 0, eye};
Rectangle(2) = {-neck, -60, 0, 2*neck, 60};
Rectangle(3) = {-flange, -60, 0, 2*flange, 10};
Rectangle(4) = {-neck - fillet, -50, 0, 2*(neck + fillet), fillet};
body() = BooleanUnion{ Surface{1}; Delete; }{ Surface{2, 3, 4}; Delete; };
Disk(11) = {0, 0, 0, bore};
Disk(12) = {neck + fillet, -50 + fillet, 0, fillet};
Disk(13) = {-neck - fillet, -50 + fillet, 0, fillet};
plate() = BooleanDifference{ Surface{body()}; Delete; }{ Surface{11, 12, 13}; Delete; };
solid() = Extrude {0, 0, half} { Surface{plate()}; };

e = 1e-3;
Physical Volume("lug") = Volume{:};
Physical Surface("symmetry") = Surface In BoundingBox {-100, -100, -e, 100, 100, e};
Physical Surface("bore") = Surface In BoundingBox {-bore - e, -bore - e, -e, bore + e, bore + e, half + e};
Physical Surface("base") = Surface In BoundingBox {-100, -60 - e, -e, 100, -60 + e, half + e};
Physical Surface("flank") = Surface In BoundingBox {neck - e, -50, -e, neck + e, 0, half + e};

// Small tetrahedra at the bore, where the pin bears, growing away from it.
Field[1] = MathEval;
Field[1].F = "0.7 + 0.15*Max(0, Sqrt(x*x + y*y) - 10.05)";
Background Field = 1;
Mesh.MeshSizeMax = 3;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 6;
Mesh.Optimize = 1;
Mesh.OptimizeNetgen = 1;
Mesh.RandomSeed = 1;
Mesh.MshFileVersion = 4.1;
Mesh.Binary = 1;

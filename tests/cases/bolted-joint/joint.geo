// One half of a bolted joint above its plane z = 0, in mm: part = 1: a plate with a hole; part = 2: half of a bolt with its head.
SetFactory("OpenCASCADE");
If (!Exists(part)) part = 1; EndIf
If (!Exists(size)) size = 4; EndIf
e = 1e-3;
If (part == 1)
  Box(1) = {-20, -12, 0, 40, 24, 10};
  Cylinder(2) = {0, 0, 0, 0, 0, 10, 5.5};
  BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
  Physical Volume("plate") = {3};
  Physical Surface("inside") = Surface In BoundingBox {-20 - e, -12 - e, -e, 20 + e, 12 + e, e};
  Physical Surface("top") = Surface In BoundingBox {-20 - e, -12 - e, 10 - e, 20 + e, 12 + e, 10 + e};
  Physical Surface("ends") = {Surface In BoundingBox {-20 - e, -12 - e, -e, -20 + e, 12 + e, 10 + e},
                              Surface In BoundingBox {20 - e, -12 - e, -e, 20 + e, 12 + e, 10 + e}};
Else
  Cylinder(1) = {0, 0, 0, 0, 0, 16, 5};
  Cylinder(2) = {0, 0, 10, 0, 0, 6, 9};
  BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
  Physical Volume("bolt") = {3};
  Physical Surface("cut") = Surface In BoundingBox {-5 - e, -5 - e, -e, 5 + e, 5 + e, e};
  Physical Surface("seat") = Surface In BoundingBox {-9 - e, -9 - e, 10 - e, 9 + e, 9 + e, 10 + e};
EndIf
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;

// SPDX-License-Identifier: GPL-3.0-or-later
// An ordinary part without fine features, of tetrahedra: a foot plate with an upright column and a
// rib between them. Needs gmsh with OpenCASCADE (Debian's has it).
//
//   gmsh -3 pedestal.geo -o pedestal.msh                      tet10, 8937 nodes, 787 of them on the foot
//   gmsh -3 pedestal.geo -setnumber size 9e-3 -o coarse.msh
//
// The foot's underside is z = 0; metres. Physical groups: volume `pedestal`; surfaces `foot` (the
// underside), `top` (the column's end), `surface` (all of it).
DefineConstant[ size = 5.4e-3, order = 2 ];
DefineConstant[ lx = 72e-3, ly = 55e-3, thick = 16e-3 ];      // of the foot plate
DefineConstant[ side = 32e-3, height = 80e-3 ];               // of the square column, with the plate
DefineConstant[ rib = 14e-3, reach = 22e-3 ];                 // thickness of the rib, its way along x

SetFactory("OpenCASCADE");
e = 1e-6;                                                     // slack of bounding boxes
Box(1) = {-lx/2, -ly/2, 0, lx, ly, thick};
Box(2) = {-lx/2 + 8e-3, -side/2, 0, side, side, height};
x0 = -lx/2 + 8e-3 + side;
Point(101) = {x0 - 1e-3, -rib/2, thick - 1e-3};
Point(102) = {x0 + reach, -rib/2, thick - 1e-3};
Point(103) = {x0 - 1e-3, -rib/2, height - 12e-3};
Line(101) = {101, 102};
Line(102) = {102, 103};
Line(103) = {103, 101};
Curve Loop(101) = {101, 102, 103};
Plane Surface(101) = {101};
wedge() = Extrude {0, rib, 0} { Surface{101}; };
part() = BooleanUnion{ Volume{1}; Delete; }{ Volume{2, wedge(1)}; Delete; };

all() = Boundary{ Volume{part(0)}; };
under() = Surface In BoundingBox {-lx, -ly, -e, lx, ly, e};
end() = Surface In BoundingBox {-lx, -ly, height - e, lx, ly, height + e};
Physical Volume("pedestal") = {part(0)};
Physical Surface("foot") = {under()};
Physical Surface("top") = {end()};
Physical Surface("surface") = {all()};

Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
Mesh.ElementOrder = order;
Mesh.SecondOrderLinear = 1;
Mesh.Algorithm3D = 1;
Mesh.MshFileVersion = 4.1;

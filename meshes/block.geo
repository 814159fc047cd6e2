// SPDX-License-Identifier: GPL-3.0-or-later
// A block of hexes, centred on the origin: T1 of the paper by default (20 x 10 x 15 = 3000 hexes, 3696 nodes).
//
//   gmsh -3 block.geo -o block.msh
//   gmsh -3 block.geo -setnumber nx 10 -setnumber ny 10 -setnumber nz 10 -setnumber lx 0.0254 -setnumber ly 0.0254 -setnumber lz 0.0254 -o cube.msh
//
// Physical groups: volume `block`; surfaces `x_min` ... `z_max`, `contact` (the same face as `x_max`) and `surface` (all six).
DefineConstant[ nx = 20, ny = 10, nz = 15 ];                   // hexes along x, y, z
DefineConstant[ lx = 0.0508, ly = 0.0254, lz = 0.0381 ];       // edge lengths
DefineConstant[ order = 1, incomplete = 1 ];                   // order 2: hex20, or hex27 with incomplete 0

SetFactory("Built-in");
Point(1) = {-lx/2, -ly/2, -lz/2};
x[] = Extrude {lx, 0, 0} { Point{1}; Layers{nx}; };
xy[] = Extrude {0, ly, 0} { Curve{x[1]}; Layers{ny}; Recombine; };
xyz[] = Extrude {0, 0, lz} { Surface{xy[1]}; Layers{nz}; Recombine; };
// The sides of an extruded surface come in the order of its boundary: y_min, x_max, y_max, x_min.
Physical Volume("block") = {xyz[1]};
Physical Surface("z_min") = {xy[1]};
Physical Surface("z_max") = {xyz[0]};
Physical Surface("y_min") = {xyz[2]};
Physical Surface("x_max") = {xyz[3]};
Physical Surface("y_max") = {xyz[4]};
Physical Surface("x_min") = {xyz[5]};
Physical Surface("contact") = {xyz[3]};
Physical Surface("surface") = {xy[1], xyz[0], xyz[2], xyz[3], xyz[4], xyz[5]};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = incomplete;
Mesh.MshFileVersion = 4.1;

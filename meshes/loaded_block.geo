// SPDX-License-Identifier: GPL-3.0-or-later
// T3 of the paper: the block of block.geo with the two centre-most faces of its x_max face in the physical surface `load`.
//
//   gmsh -3 loaded_block.geo -o loaded_block.msh                                                      (20 x 10 x 15, 3000 hexes)
//   gmsh -3 loaded_block.geo -setnumber nx 10 -setnumber ny 5 -setnumber nz 8 -o loaded_block_coarse.msh   (10 x 5 x 8, 400 hexes)
//
// With an even number of hexes in one direction and an odd one in the other the two faces lie on either side of the middle in
// the even direction and on it in the odd one; with two odd numbers, the middle face and the nearest next one; with two even
// ones, the two around the centre line in y, on the upper side of the middle in z.
// The block is cut along x into (up to) nine bars that meet at hex faces, so that the mesh is block.geo's, whatever the cut.
DefineConstant[ nx = 20, ny = 10, nz = 15 ];
DefineConstant[ lx = 0.0508, ly = 0.0254, lz = 0.0381 ];

SetFactory("Built-in");
// First loaded hex and how many, in y and z.
dy = ly/ny;  dz = lz/nz;
along_z = ((nz % 2 == 0 && ny % 2 == 1) || (nz % 2 == 1 && ny % 2 == 1 && dz < dy));
my = along_z ? 1 : 2;  mz = along_z ? 2 : 1;
jy = along_z ? Floor((ny - 1)/2) : Floor((ny - 1)/2);
jz = along_z ? Floor((nz - 1)/2) : Floor(nz/2);
If (jy < 1 || jz < 1 || ny - jy - my < 1 || nz - jz - mz < 1)
  Error("loaded_block.geo: ny and nz must be at least 4 (3 for the odd one of an odd and an even number)");
  Abort;
EndIf

// Extruded row by row: along y in three steps, along z in three steps, along x.
Point(1) = {-lx/2, -ly/2, -lz/2};
y1[] = Extrude {0, jy*dy, 0} { Point{1}; Layers{jy}; };
y2[] = Extrude {0, my*dy, 0} { Point{y1[0]}; Layers{my}; };
y3[] = Extrude {0, (ny - jy - my)*dy, 0} { Point{y2[0]}; Layers{ny - jy - my}; };
rows[] = {y1[1], y2[1], y3[1]};
faces[] = {};
heights[] = {jz, mz, nz - jz - mz};
For k In {0:2}
  next[] = {};
  For j In {0:2}
    e[] = Extrude {0, 0, heights[k]*dz} { Curve{rows[j]}; Layers{heights[k]}; Recombine; };
    next[] += {e[0]};
    faces[] += {e[1]};
  EndFor
  rows[] = next[];
EndFor
volumes[] = {};  ends[] = {};  sides[] = {};
For f In {0:8}
  e[] = Extrude {lx, 0, 0} { Surface{faces[f]}; Layers{nx}; Recombine; };
  ends[] += {e[0]};
  volumes[] += {e[1]};
EndFor
eps = 1e-3*dy;
yn[] = Surface In BoundingBox {-lx/2 - eps, -ly/2 - eps, -lz/2 - eps, lx/2 + eps, -ly/2 + eps, lz/2 + eps};
yx[] = Surface In BoundingBox {-lx/2 - eps, ly/2 - eps, -lz/2 - eps, lx/2 + eps, ly/2 + eps, lz/2 + eps};
zn[] = Surface In BoundingBox {-lx/2 - eps, -ly/2 - eps, -lz/2 - eps, lx/2 + eps, ly/2 + eps, -lz/2 + eps};
zx[] = Surface In BoundingBox {-lx/2 - eps, -ly/2 - eps, lz/2 - eps, lx/2 + eps, ly/2 + eps, lz/2 + eps};

Physical Volume("block") = volumes[];
Physical Surface("x_min") = faces[];
Physical Surface("x_max") = ends[];
Physical Surface("y_min") = yn[];
Physical Surface("y_max") = yx[];
Physical Surface("z_min") = zn[];
Physical Surface("z_max") = zx[];
Physical Surface("contact") = ends[];
Physical Surface("load") = {ends[4]};
Physical Surface("surface") = {faces[], ends[], yn[], yx[], zn[], zx[]};
Mesh.MshFileVersion = 4.1;

// SPDX-License-Identifier: GPL-3.0-or-later
// T2's sphere, centred on the origin: a core of n x n x n hexes and `layers` radial layers on each of its six faces
// (6 x 6 x 6 + 6 x 3 x 36 = 864 hexes, 218 surface nodes).
//
//   gmsh -3 sphere.geo -o sphere.msh
//
// Physical groups: volume `sphere`; surfaces `surface` and `contact` (both the whole surface), `x_min` ... `z_max` (a sixth each).
DefineConstant[ diameter = 0.0254, n = 6, layers = 3 ];
DefineConstant[ core = 0.6 ];     // distance of the core's corners from the centre, over the radius
DefineConstant[ bulge = 0.5 ];   // 0: the core is a cube; 1: it is a sphere. Between, its edges are arcs of a larger circle.

SetFactory("Built-in");
R = diameter/2;
a = core*R/Sqrt(3);               // half the edge of the core
s = R/Sqrt(3);
// The core's edges are arcs about centres moved away from the origin, on the far side of each edge.
c = a*(1 - 1/bulge);
Point(100) = {0, 0, 0};
For k In {0:1}
  For j In {0:1}
    For i In {0:1}
      p = 1 + i + 2*j + 4*k;
      Point(p) = {(2*i - 1)*a, (2*j - 1)*a, (2*k - 1)*a};
      Point(p + 10) = {(2*i - 1)*s, (2*j - 1)*s, (2*k - 1)*s};
      Line(p + 60) = {p, p + 10};
    EndFor
  EndFor
EndFor
// Edges along x: 1-4, along y: 5-8, along z: 9-12; the outer ones plus 20.
For q In {0:1}
  For r In {0:1}
    m = 1 + r + 2*q;
    u = (2*r - 1)*c;  v = (2*q - 1)*c;
    Point(200 + m) = {0, u, v};
    Point(210 + m) = {u, 0, v};
    Point(220 + m) = {u, v, 0};
    x1 = 1 + 2*r + 4*q;  y1 = 1 + r + 4*q;  z1 = 1 + r + 2*q;
    Circle(m) = {x1, 200 + m, x1 + 1};
    Circle(m + 4) = {y1, 210 + m, y1 + 2};
    Circle(m + 8) = {z1, 220 + m, z1 + 4};
    Circle(m + 20) = {x1 + 10, 100, x1 + 11};
    Circle(m + 24) = {y1 + 10, 100, y1 + 12};
    Circle(m + 28) = {z1 + 10, 100, z1 + 14};
  EndFor
EndFor
Transfinite Curve{1:12, 21:32} = n + 1;
Transfinite Curve{61:68} = layers + 1;

// Faces of the core and of the sphere: z_min, z_max, y_min, y_max, x_min, x_max.
For o In {0:20:20}
  Curve Loop(1 + o) = {1 + o, 6 + o, -(2 + o), -(5 + o)};       Curve Loop(2 + o) = {3 + o, 8 + o, -(4 + o), -(7 + o)};
  Curve Loop(3 + o) = {1 + o, 10 + o, -(3 + o), -(9 + o)};      Curve Loop(4 + o) = {2 + o, 12 + o, -(4 + o), -(11 + o)};
  Curve Loop(5 + o) = {5 + o, 11 + o, -(7 + o), -(9 + o)};      Curve Loop(6 + o) = {6 + o, 12 + o, -(8 + o), -(10 + o)};
EndFor
For f In {1:6}
  Surface(f) = {f};                          // bulged by the transfinite interpolation of its edges
  Surface(f + 20) = {f + 20} In Sphere {100};
EndFor
// Between core and sphere, one for each edge.
For q In {0:1}
  For r In {0:1}
    m = 1 + r + 2*q;
    x1 = 1 + 2*r + 4*q;  y1 = 1 + r + 4*q;  z1 = 1 + r + 2*q;
    Curve Loop(40 + m) = {m, 60 + x1 + 1, -(m + 20), -(60 + x1)};
    Curve Loop(44 + m) = {m + 4, 60 + y1 + 2, -(m + 24), -(60 + y1)};
    Curve Loop(48 + m) = {m + 8, 60 + z1 + 4, -(m + 28), -(60 + z1)};
  EndFor
EndFor
For f In {41:52}
  Surface(f) = {f};
EndFor
Transfinite Surface{1:6, 21:26, 41:52};
Recombine Surface{1:6, 21:26, 41:52};

Surface Loop(1) = {1:6};
Volume(1) = {1};
// z_min, z_max, y_min, y_max, x_min, x_max: inner face, outer face, the four between.
Surface Loop(2) = {1, 21, 41, 46, 42, 45};  Volume(2) = {2};
Surface Loop(3) = {2, 22, 43, 48, 44, 47};  Volume(3) = {3};
Surface Loop(4) = {3, 23, 41, 50, 43, 49};  Volume(4) = {4};
Surface Loop(5) = {4, 24, 42, 52, 44, 51};  Volume(5) = {5};
Surface Loop(6) = {5, 25, 45, 51, 47, 49};  Volume(6) = {6};
Surface Loop(7) = {6, 26, 46, 52, 48, 50};  Volume(7) = {7};
Transfinite Volume{1:7};

Physical Volume("sphere") = {1:7};
Physical Surface("z_min") = {21};
Physical Surface("z_max") = {22};
Physical Surface("y_min") = {23};
Physical Surface("y_max") = {24};
Physical Surface("x_min") = {25};
Physical Surface("x_max") = {26};
Physical Surface("contact") = {21:26};
Physical Surface("surface") = {21:26};
Mesh.MshFileVersion = 4.1;

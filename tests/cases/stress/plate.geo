// SPDX-License-Identifier: GPL-3.0-or-later
// A quarter of a plate, 1 m x 1 m x 10 mm, with a hole of 50 mm radius: hexahedra that get smaller towards the hole.
radius = 0.05; half = 0.5; thickness = 0.01;
n = 12; // along each half of the quarter circle
m = 18; // from the hole outwards
c = radius / Sqrt(2);
Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {c, c, 0};
Point(4) = {0, radius, 0};
Point(5) = {half, 0, 0};
Point(6) = {half, half, 0};
Point(7) = {0, half, 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Line(3) = {5, 6};
Line(4) = {6, 7};
Line(5) = {2, 5};
Line(6) = {3, 6};
Line(7) = {4, 7};
Transfinite Curve {1, 2, 3, 4} = n + 1;
Transfinite Curve {5, 6, 7} = m + 1 Using Progression 1.2;
Curve Loop(1) = {5, 3, -6, -1};
Curve Loop(2) = {6, 4, -7, -2};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Transfinite Surface {1, 2};
Recombine Surface {1, 2};
one[] = Extrude {0, 0, thickness} { Surface{1}; Layers{1}; Recombine; };
two[] = Extrude {0, 0, thickness} { Surface{2}; Layers{1}; Recombine; };
Physical Volume("plate") = {one[1], two[1]};
Physical Surface("symmetry_y") = {one[2]};
Physical Surface("pulled") = {one[3]};
Physical Surface("hole") = {one[5], two[5]};
Physical Surface("symmetry_x") = {two[4]};
Physical Surface("back") = {1, 2};

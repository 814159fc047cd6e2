// SPDX-License-Identifier: GPL-3.0-or-later
// A quarter of a slice in x, y >= 0, of hexahedra. part = 1: a shaft of radius `outer`; part = 2: a hub from `inner` to `outer`.
// n: elements on half of the quarter circle; m: from the inside outwards.
If (!Exists(part)) part = 1; EndIf
If (!Exists(inner)) inner = 10; EndIf
If (!Exists(outer)) outer = 20; EndIf
If (!Exists(thickness)) thickness = 1; EndIf
If (!Exists(n)) n = 6; EndIf
If (!Exists(m)) m = 6; EndIf
If (part == 1) inner = outer / 2; EndIf
// The inside of the shaft is a square of four-sided faces, with sides between a line and an arc
bulge = part == 1 ? 1.15 : 1;
c = Cos(Pi / 4);
Point(1) = {0, 0, 0};
Point(2) = {inner, 0, 0};
Point(3) = {inner * c * bulge, inner * c * bulge, 0};
Point(4) = {0, inner, 0};
Point(5) = {outer, 0, 0};
Point(6) = {outer * c, outer * c, 0};
Point(7) = {0, outer, 0};
If (part == 1)
  Line(1) = {2, 3};
  Line(2) = {3, 4};
Else
  Circle(1) = {2, 1, 3};
  Circle(2) = {3, 1, 4};
EndIf
Circle(3) = {5, 1, 6};
Circle(4) = {6, 1, 7};
Line(5) = {2, 5};
Line(6) = {3, 6};
Line(7) = {4, 7};
Transfinite Curve {1, 2, 3, 4} = n + 1;
Transfinite Curve {5, 6, 7} = m + 1;
Curve Loop(1) = {5, 3, -6, -1};
Curve Loop(2) = {6, 4, -7, -2};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
faces[] = {1, 2};
If (part == 1)
  Line(8) = {1, 2};
  Line(9) = {4, 1};
  Transfinite Curve {8, 9} = n + 1;
  Curve Loop(3) = {8, 1, 2, 9};
  Plane Surface(3) = {3};
  Transfinite Surface {3} = {1, 2, 3, 4};
  faces[] += 3;
EndIf
Transfinite Surface {1} = {2, 5, 6, 3};
Transfinite Surface {2} = {3, 6, 7, 4};
Recombine Surface {faces[]};
one[] = Extrude {0, 0, thickness} { Surface{1}; Layers{1}; Recombine; };
two[] = Extrude {0, 0, thickness} { Surface{2}; Layers{1}; Recombine; };
If (part == 1)
  Extrude {0, 0, thickness} { Surface{3}; Layers{1}; Recombine; }
EndIf
e = 1e-3;
Physical Volume("part") = Volume{:};
Physical Surface("x0") = Surface In BoundingBox {-e, -e, -e, e, outer + e, thickness + e};
Physical Surface("y0") = Surface In BoundingBox {-e, -e, -e, outer + e, e, thickness + e};
Physical Surface("z0") = Surface In BoundingBox {-e, -e, -e, outer + e, outer + e, e};
Physical Surface("outside") = {one[3], two[3]};
If (part == 2)
  Physical Surface("inside") = {one[5], two[5]};
EndIf

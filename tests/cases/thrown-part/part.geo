// SPDX-License-Identifier: GPL-3.0-or-later
// L-shaped part of hexes: legs of 60 mm, 20 mm thick and wide, elements of 10 mm. Set "skin": its whole surface.
n = 2;  // elements over 20 mm
Point(1) = {0, 0, 0};      Point(2) = {0.02, 0, 0};     Point(3) = {0.06, 0, 0};
Point(4) = {0, 0.02, 0};   Point(5) = {0.02, 0.02, 0};  Point(6) = {0.06, 0.02, 0};
Point(7) = {0, 0.06, 0};   Point(8) = {0.02, 0.06, 0};
Line(1) = {1, 2};  Line(2) = {2, 3};  Line(3) = {3, 6};  Line(4) = {6, 5};  Line(5) = {5, 2};
Line(6) = {5, 4};  Line(7) = {4, 1};  Line(8) = {5, 8};  Line(9) = {8, 7};  Line(10) = {7, 4};
Curve Loop(1) = {1, -5, 6, 7};
Curve Loop(2) = {2, 3, 4, 5};
Curve Loop(3) = {-6, 8, 9, 10};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Plane Surface(3) = {3};
Transfinite Curve {1, 3, 5, 6, 7, 9} = n + 1;
Transfinite Curve {2, 4, 8, 10} = 2 * n + 1;
Transfinite Surface {1, 2, 3};
Recombine Surface {1, 2, 3};
body() = {};
For s In {1:3}
  made() = Extrude {0, 0, 0.02} { Surface{s}; Layers{n}; Recombine; };
  body() += made(1);
EndFor
Physical Volume("part") = body();
skin() = CombinedBoundary{ Volume{body()}; };
Physical Surface("skin") = skin();

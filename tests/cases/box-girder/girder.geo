// SPDX-License-Identifier: GPL-3.0-or-later
// A square tube of shells along x with a lid. Its other end is pushed over a plug of solids.
side = 0.1; length = 1; plug = 0.05;
n = 6;    // along a side of the tube
m = 40;   // along the tube
Point(1) = {0, -side / 2, -side / 2};
Point(2) = {0, side / 2, -side / 2};
Point(3) = {0, side / 2, side / 2};
Point(4) = {0, -side / 2, side / 2};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 2, 3, 4} = n + 1;
Transfinite Surface {1};
Recombine Surface {1};
solid[] = Extrude {plug, 0, 0} { Surface{1}; Layers{3}; Recombine; };
ring[] = Boundary { Surface{solid[0]}; };
walls[] = {};
middle[] = {};
ends[] = {};
For i In {0 : 3}
  half[] = Extrude {length / 2, 0, 0} { Curve{Abs(ring[i])}; Layers{m / 2}; Recombine; };
  rest[] = Extrude {length / 2, 0, 0} { Curve{half[0]}; Layers{m / 2}; Recombine; };
  walls[] += {half[1], rest[1]};
  middle[] += half[0];
  ends[] += rest[0];
EndFor
Coherence;
Curve Loop(100) = {ends[]};
Plane Surface(100) = {100};
Transfinite Surface {100};
Recombine Surface {100};
Physical Volume("plug") = {solid[1]};
Physical Surface("bolted") = {1};
Physical Surface("skin.sleeve") = {solid[2], solid[3], solid[4], solid[5]};   // on the plug: shells by the name
Physical Surface("tube") = {walls[], 100};   // lies on no solid: a block of shells
Physical Curve("middle") = {middle[]};
Physical Curve("tip") = {ends[]};

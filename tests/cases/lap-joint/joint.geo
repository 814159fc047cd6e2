// Parts of a bolted lap joint, in mm, of hexahedra; the plane between the plates is z = 0, the bolt's axis is z.
//   part = 1: a plate 80 x 30 x 4, its hole of 9 mm 15 mm from one end; part = 2: a washer 16 x 8.4 x 1.6;
//   part = 3: half of an M8 bolt, cut at z = 0, that stands on a washer.
// n: elements on a quarter of a circle and on a side of the plate. layers: through the plate.
If (!Exists(part)) part = 1; EndIf
If (!Exists(n)) n = 4; EndIf
If (!Exists(layers)) layers = 2; EndIf
e = 1e-3;
Mesh.RecombineAll = 1;

// Four points on a circle about the axis, and their number
Macro Ring
  p0 = newp;
  For k In {0:3}
    Point(p0 + k) = {r * Cos(Pi / 4 + k * Pi / 2), r * Sin(Pi / 4 + k * Pi / 2), z, 1};
  EndFor
Return

// Sides of a ring whose points are p0 .. p0 + 3: arcs about the point `axis`, or straight
Macro Sides
  For k In {0:3}
    side~{k} = newl;
    If (round)
      Circle(side~{k}) = {p0 + k, axis, p0 + (k + 1) % 4};
    Else
      Line(side~{k}) = {p0 + k, p0 + (k + 1) % 4};
    EndIf
    Transfinite Curve{side~{k}} = n + 1;
  EndFor
Return

// Four faces between the ring `in~{k}` of points i0 .. and that of sides side~{k} and points p0 .., m elements wide
Macro Between
  For k In {0:3}
    spoke~{k} = newl;
    Line(spoke~{k}) = {i0 + k, p0 + k};
    Transfinite Curve{spoke~{k}} = m + 1;
  EndFor
  faces[] = {};
  For k In {0:3}
    loop = newll;
    Curve Loop(loop) = {in~{k}, spoke~{(k + 1) % 4}, -side~{k}, -spoke~{k}};
    face = news;
    Plane Surface(face) = {loop};
    Transfinite Surface{face};
    faces[] += face;
  EndFor
Return

Macro Inwards
  i0 = p0;
  For k In {0:3}
    in~{k} = side~{k};
  EndFor
Return

z = 0;
If (part == 2) z = 4; EndIf
If (part == 3) z = 5.6; EndIf
axis = newp;
Point(axis) = {0, 0, z, 1};
round = 1;

If (part == 1)
  r = 4.5;
  Call Ring;
  Call Sides;
  Call Inwards;
  r = 8;
  Call Ring;
  Call Sides;
  m = Ceil(n / 2);
  Call Between;
  all[] = faces[];
  Call Inwards;
  r = 15 * Sqrt(2);
  round = 0;
  Call Ring;
  Call Sides;
  m = Ceil(n / 2);
  Call Between;
  all[] += faces[];
  // The tail begins at the side from p0 + 1 to p0 + 2
  a = newp; Point(a) = {-65, 15, 0, 1};
  b = newp; Point(b) = {-65, -15, 0, 1};
  l1 = newl; Line(l1) = {p0 + 1, a};
  l2 = newl; Line(l2) = {a, b};
  l3 = newl; Line(l3) = {b, p0 + 2};
  Transfinite Curve{l1, l3} = 2 * n + 1;
  Transfinite Curve{l2} = n + 1;
  Curve Loop(1000) = {side~{1}, -l3, -l2, -l1};
  Plane Surface(1000) = {1000};
  Transfinite Surface{1000};
  all[] += 1000;
  out[] = Extrude {0, 0, 4} { Surface{all[]}; Layers{layers}; Recombine; };
  Physical Volume("plate") = Volume{:};
  Physical Surface("inside") = Surface In BoundingBox {-15 - e, -15 - e, -e, 15 + e, 15 + e, e};
  Physical Surface("outside") = Surface In BoundingBox {-15 - e, -15 - e, 4 - e, 15 + e, 15 + e, 4 + e};
  Physical Surface("end") = Surface In BoundingBox {-65 - e, -15 - e, -e, -65 + e, 15 + e, 4 + e};
ElseIf (part == 2)
  r = 4.2;
  Call Ring;
  Call Sides;
  Call Inwards;
  r = 8;
  Call Ring;
  Call Sides;
  m = Ceil(n / 2);
  Call Between;
  out[] = Extrude {0, 0, 1.6} { Surface{faces[]}; Layers{1}; Recombine; };
  Physical Volume("washer") = Volume{:};
  Physical Surface("below") = Surface In BoundingBox {-8 - e, -8 - e, 4 - e, 8 + e, 8 + e, 4 + e};
  Physical Surface("above") = Surface In BoundingBox {-8 - e, -8 - e, 5.6 - e, 8 + e, 8 + e, 5.6 + e};
Else
  r = 2;
  round = 0;
  Call Ring;
  Call Sides;
  Curve Loop(1000) = {side~{0}, side~{1}, side~{2}, side~{3}};
  Plane Surface(1000) = {1000};
  Transfinite Surface{1000};
  Call Inwards;
  round = 1;
  r = 4;
  Call Ring;
  Call Sides;
  m = Ceil(n / 4);
  Call Between;
  shank[] = {1000, faces[]};
  Call Inwards;
  r = 6.5;
  Call Ring;
  Call Sides;
  m = Ceil(n / 4);
  Call Between;
  seat[] = faces[];
  head[] = Extrude {0, 0, 5.3} { Surface{shank[], seat[]}; Layers{2}; Recombine; };
  down[] = Extrude {0, 0, -5.6} { Surface{shank[]}; Layers{2}; Recombine; };
  Physical Volume("bolt") = Volume{:};
  Physical Surface("cut") = Surface In BoundingBox {-4 - e, -4 - e, -e, 4 + e, 4 + e, e};
  Physical Surface("seat") = {seat[]};
EndIf

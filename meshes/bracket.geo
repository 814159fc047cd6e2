// SPDX-License-Identifier: GPL-3.0-or-later
// A bracket with small features, of tetrahedra: a plate with two bolt holes and a filleted boss that is drilled across. Element sizes from
// `size` at the cross bore to 20 times as much in the plate (about 11 800 nodes). Needs gmsh with OpenCASCADE (Debian's has it).
//
//   gmsh -3 bracket.geo -o bracket.msh
//   gmsh -3 bracket.geo -setnumber size 1.2e-3 -setnumber ratio 5 -o bracket_coarse.msh
//
// `order` 2: tet10. `pad`: element size on the pad. The boss stands on the plate's upper face, z = 0 ... `height`; metres.
// Physical groups: volume `bracket`; surfaces `contact` (the boss's flat top), `mount` (the plate's underside), `holes` (two bolt holes), `bore`,
// `fillet` (round the boss's foot), `surface` (all of it).
DefineConstant[ size = 0.3e-3, ratio = 20, pad = 1.5e-3, grade = 0.2 ];
DefineConstant[ order = 1, straight = 1 ];                    // straight 0: edges of tet10 follow the surface; a coarse fillet then turns elements inside out
DefineConstant[ lx = 60e-3, ly = 36e-3, thick = 8e-3, height = 20e-3, diameter = 20e-3 ];
DefineConstant[ round = 1.0e-3, edge = 4e-3 ];               // radii: of the boss's foot, of the plate's upright edges
DefineConstant[ hole = 6.6e-3, apart = 42e-3, bore = 1.2e-3 ]; // diameters of the bolt holes, their distance; diameter of the cross bore

SetFactory("OpenCASCADE");
e = 1e-6;                                                     // slack of bounding boxes
Box(1) = {-lx/2, -ly/2, -thick, lx, ly, thick};
edges() = {};
For sx In {-1:1:2}
  For sy In {-1:1:2}
    edges() += Curve In BoundingBox {sx*lx/2 - e, sy*ly/2 - e, -thick - e, sx*lx/2 + e, sy*ly/2 + e, e};
  EndFor
EndFor
plate() = Fillet{1}{edges()}{edge};
Cylinder(20) = {0, 0, -thick, 0, 0, thick + height, diameter/2};
part() = BooleanUnion{ Volume{plate()}; Delete; }{ Volume{20}; Delete; };
foot() = Curve In BoundingBox {-diameter/2 - e, -diameter/2 - e, -e, diameter/2 + e, diameter/2 + e, e};
part() = Fillet{part(0)}{foot()}{round};
Cylinder(101) = {-apart/2, 0, -2*thick, 0, 0, 4*thick, hole/2};
Cylinder(102) = {apart/2, 0, -2*thick, 0, 0, 4*thick, hole/2};
Cylinder(103) = {0, -diameter, height*0.4, 0, 2*diameter, 0, bore/2};
part() = BooleanDifference{ Volume{part(0)}; Delete; }{ Volume{101:103}; Delete; };

all() = Boundary{ Volume{part(0)}; };
top() = Surface In BoundingBox {-diameter/2 - e, -diameter/2 - e, height - e, diameter/2 + e, diameter/2 + e, height + e};
under() = Surface In BoundingBox {-lx, -ly, -thick - e, lx, ly, -thick + e};
holes() = Surface In BoundingBox {-(apart + hole)/2 - e, -hole/2 - e, -thick - e, -(apart - hole)/2 + e, hole/2 + e, e};
holes() += Surface In BoundingBox {(apart - hole)/2 - e, -hole/2 - e, -thick - e, (apart + hole)/2 + e, hole/2 + e, e};
bored() = Surface In BoundingBox {-bore/2 - e, -diameter, height*0.4 - bore/2 - e, bore/2 + e, diameter, height*0.4 + bore/2 + e};
f = diameter/2 + round + e;
foot() = Surface In BoundingBox {-f, -f, -e, f, f, round + e};

Physical Volume("bracket") = {part(0)};
Physical Surface("contact") = {top()};
Physical Surface("mount") = {under()};
Physical Surface("holes") = {holes()};
Physical Surface("bore") = {bored()};
Physical Surface("fillet") = {foot()};
Physical Surface("surface") = {all()};

// Sizes: `size` at the bore, 2 `size` at the fillet, 4 `size` at the bolt holes; they grow by `grade` of the distance, to `pad` near the pad and
// ratio * size elsewhere.
Field[1] = Distance;  Field[1].SurfacesList = {bored()};  Field[1].NumPointsPerCurve = 200;
Field[2] = Distance;  Field[2].SurfacesList = {foot()};   Field[2].NumPointsPerCurve = 200;
Field[3] = Distance;  Field[3].SurfacesList = {holes()};  Field[3].NumPointsPerCurve = 100;
Field[4] = MathEval;  Field[4].F = Sprintf("%g + %g*F1", size, grade);
Field[5] = MathEval;  Field[5].F = Sprintf("%g + %g*F2", 2*size, grade);
Field[6] = MathEval;  Field[6].F = Sprintf("%g + %g*F3", 4*size, grade);
Field[7] = MathEval;  Field[7].F = Sprintf("%g + %g*Fabs(z - %g)", pad, grade, height);
Field[8] = MathEval;  Field[8].F = Sprintf("%g", ratio*size);
Field[9] = Min;       Field[9].FieldsList = {4, 5, 6, 7, 8};
Background Field = 9;
Mesh.CharacteristicLengthExtendFromBoundary = 0;
Mesh.CharacteristicLengthFromPoints = 0;
Mesh.CharacteristicLengthFromCurvature = 0;
Mesh.Optimize = 1;
Mesh.ElementOrder = order;
Mesh.SecondOrderLinear = straight;
Mesh.MshFileVersion = 4.1;

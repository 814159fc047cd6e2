// SPDX-License-Identifier: GPL-3.0-or-later
// Incompatible modes and hourglass control of the 8-node hex. For element.cpp; others call
// element_stiffness().
#pragma once

#include <array>

#include "common/fem/elements/element.hpp"
#include "common/fem/elements/isoparametric.hpp"

namespace cbr {

inline bool has_one_point(HexFormulation hex) {
  return hex == HexFormulation::hourglass || hex == HexFormulation::reduced;
}

// Hourglass stiffness over V (b : b) and Young's modulus. At a Poisson's ratio of 0.3 it is the
// customary 0.05 of the modulus of pressure waves, lambda + 2 mu. Of `reduced`: that of C3D8R in
// CalculiX, 0.0005 for shapes without the sqrt 8 (docs/theory.md, "1. Finite elements").
inline double hourglass_coefficient(HexFormulation hex) {
  return hex == HexFormulation::reduced ? 8 * 0.0005 : 0.05 * 0.7 / (1.3 * 0.4);
}

using Hex8Nodes = isoparametric::Nodes<8>;
using Hex8Matrix = isoparametric::DofMatrix<8>;

// Nine internal displacements, (1 - xi_k^2) times each direction, condensed: K = K_uu - K_ua
// K_aa^-1 K_au. Their gradients are mapped with J_0 = J(0) and scaled by det J_0 / det J (Taylor,
// Beresford, Wilson 1976, doi 10.1002/nme.1620100602), so they integrate to zero and the patch test
// holds on distorted elements.
Hex8Matrix hex8_incompatible_stiffness(const Hex8Nodes& X,
                                       const std::vector<isoparametric::Elasticity>& material);
// Gradients du_a/dx_b at the 2 x 2 x 2 points of nodal displacements u, with the internal ones a =
// -K_aa^-1 K_au u that go along.
std::array<Matrix3, 8> hex8_incompatible_gradients(
    const Hex8Nodes& X, const std::vector<isoparametric::Elasticity>& material, const Hex8Nodes& u);

// Mean gradients b_a = (1/V) integral dN/dx_a (8 x 3) and four hourglass shapes gamma = (h - sum_a
// (h . x_a) b_a) / sqrt 8 orthogonal to every linear field (Flanagan, Belytschko 1981,
// doi 10.1002/nme.1620170504), in stiffness form:
//   K = V B^T D B + kappa E V (b : b) sum_alpha gamma_alpha gamma_alpha^T (x) I_3
// kappa is hourglass_coefficient(); E is Young's modulus, the largest of an orthotropic material.
// Hourglass modes are those of bending, whose stiffness is E times a shape at any Poisson's ratio
// (Belytschko, Bindeman 1993, doi 10.1016/0045-7825(93)90124-G), where lambda + 2 mu grows without
// bound towards 0.5 and would lock them. Rank 6 + 12.
Hex8Matrix hex8_hourglass_stiffness(const Hex8Nodes& X, const Material& material, double kappa);

// b (8 x 3) and V.
struct MeanGradient {
  Hex8Nodes b;
  double volume = 0;
};
MeanGradient hex8_mean_gradient(const Hex8Nodes& X);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// What a reduction knows of its conditioning: /conditioning of a superelement file, told by
// cbr-reduce that finds it and by cbr-dyn that relies on it, with one set of thresholds.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "common/app/report.hpp"
#include "common/base/types.hpp"

namespace cbr {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

// Of a symmetric positive definite matrix, in the 1-norm. `scaled`: of D A D with D = diag(A)^-1/2,
// which does not depend on units. Within a factor of the size no diagonal scaling has a smaller one
// (van der Sluis 1969, doi 10.1007/BF02165096). Its product with 1e-16 is the relative error of
// Cholesky's solutions.
struct ConditionNumbers {
  double plain = not_known, scaled = not_known;
};

// Modes against Phi^T M_II Phi = I and K_II Phi = M_II Phi Lambda.
struct ModeCheck {
  double orthogonality = not_known;  // largest entry of Phi^T M_II Phi z - z, z of random signs
  Index worst = -1;                  // its mode, from 0; not in a file
  double residual = not_known;       // |K_II w - M_II Phi z| / |M_II Phi z|, w = Phi Lambda^-1 z
};

// Conditioning of one reduction, or of its domains joined. NaN: not known.
struct Conditioning {
  // stiffness of the interior, reduced mass (infinite: not positive definite)
  ConditionNumbers K_II, mass;
  double smallest_pivot = not_known;  // SparseCholesky's
  ModeCheck modes;
  std::string counts;  // of the inertia, "79 below 1.2e+06 Hz"; empty: none was made
  // Forces of rigid motions, of the full stiffness and of the reduced one, as shares of its rows:
  // RigidResidual
  double rigid = not_known, reduced_rigid = not_known;
  // softest_motion(), where the frequencies are not known
  double softest = not_known;
  // rad/s, of the reduced component: highest, lowest not rigid
  double largest_omega = not_known, lowest_omega = not_known;
  // frequencies 0, and how many there have to be; with largest_omega
  Index n_zero = 0, n_rigid = 0;
  // nodes, as messages name them; empty: not known
  std::string weakest, rigid_node, loose_node;
  // docs/theory.md, (9); of domains together or a second reduction: others have it in /accuracy
  std::optional<Vector3> rho_res;

  bool knows_modes() const { return !std::isnan(modes.residual); }
  bool knows_frequencies() const { return !std::isnan(largest_omega); }
};

bool is_without_stiffness(double softest);  // to round-off: a mechanism
bool is_dependent(double orthogonality);    // one mode is nearly there twice

// Figures for --verbose; `of_domain`: without those of a whole component. Warnings with a cure.
void report_conditioning(const Conditioning& conditioning, Report& report, bool of_domain = false);
void warn_of_conditioning(const Conditioning& conditioning, Report& report);

}  // namespace cbr

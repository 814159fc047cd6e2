// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/judgement: errors and conditioning of a reduction; how many modes a
// tolerance needs.
//
// Errors of a reduction that are known before any run (docs/theory.md, "Errors known before the
// run").
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/linalg/dense.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/judgement/missing_modes.hpp"
#include "reducer/modes/component_parts.hpp"
#include "reducer/partition/interior.hpp"

namespace cbr {

// Motions of the interface for error measures. First six rigid ones: translations along x, y, z and
// rotations about them through the centre of mass. Then for each of `surfaces` the response of the
// free component to a uniform pressure.
struct InterfaceMotions {
  std::vector<std::string> surfaces;  // the superelement's that are nearly flat
  Matrix W;                           // c x m, m = 6 + surfaces.size()
  // n_I x m, (M_IC + M_II Psi) W: minus the interior's inertia forces under accelerations W
  Matrix Y;
  // m x m, Y^T K_II^-1 Y: of the interior's strain energy under them, twice
  Matrix E;

  static constexpr Index n_rigid = 6;
  Index size() const { return W.cols(); }
};

// s: its interface and, in the first process, K_cc and M_cc. `part`: per interface node, the
// connected part of the component. 2 m solves. Without of_faces rigid ones alone. Only the first
// process has `surfaces`.
InterfaceMotions interface_motions(const Interior& interior, const Superelement& s,
                                   const std::vector<Index>& part, bool of_faces = true);

// Strain energy outside the modes, relative to E. D (m x m): of left_of_answer().
struct StrainLeftOut {
  Vector of_motion;    // m, shares
  double largest = 0;  // of all rigid motions
  Vector worst;        // n_rigid, the rigid motion that has it, in the first columns of W
};
StrainLeftOut strain_left_out(const InterfaceMotions& motions, const Matrix& D);

// Relative loss of kinetic energy of a free component in translation r along the mean normal of a
// surface. All its nodes stop in the direction of its normals at once, without friction. (G r)^T (G
// M_res^-1 G^T)^-1 G r / r^T M_cc r with the normals' rows G.
double impact_share(const Superelement& s, const Cholesky& M_res, const Surface& surface);

// Fixed-interface modes that a superelement does not have.
struct ModesNotKept {
  Vector lambda;  // d, of those that were computed and dropped
  Matrix Phi;     // n_I x d, the rows of this process
  // no other has a lower eigenvalue; 0: there are no others, or that is not known
  double beyond = 0;
  std::vector<double> beyond_of_part;  // the same of each part, where it is known better
};

// Merges dropped modes with the others where there are residual vectors, which have a component
// along every mode. Lanczos finds `beyond` where it is unknown.
ModesNotKept settled(ModesNotKept m, const Interior& interior, const Superelement& s);

// Elastic eigenvalues of the free component, of the lowest modes of each of its parts.
struct FreeEigenvalues {
  // ascending each; `full`: no eigenvalue of that number of the full model is lower, by the
  // estimate
  Vector with_basis, full;
  double worst_of_ten = 0;  // the largest error, of the ten lowest of each part
  // estimates of modes above are not trusted: a little below the first held mode that is missing
  double end_hz = HUGE_VAL;
  bool known() const { return with_basis.size() > 0; }
};
// modes that are estimated, and more that these may mix with
constexpr Index n_estimated = 32, n_beside = 16;

// All of the above. Phi (n_I x k): the kept modes and residual vectors. `parts`: of the component,
// when there are several; each then has its own strain energy and free modes. n_rigid: columns of V
// that are rigid motions. of_faces: also figures of each face, by M_res: residual_mass_factor() of
// s, or null: computed here. Free modes are judged when s has its diagonal form, or its lowest
// n_estimated + n_beside columns. Missing modes would lower the reduced stiffness and so their
// eigenvalues (full_eigenvalues()). Judges the lowest 32, none after the first whose error may
// exceed 0.1. None above 0.95 of the frequency of the first missing fixed-interface mode. Two
// solves a mode. Lanczos finds not_kept.beyond where it is unknown.
// The first process gets the result and the estimates.
Superelement::Accuracy accuracy_of(const Interior& interior, const InterfaceMotions& motions,
                                   const Superelement& s, const Matrix& Phi, Index n_rigid,
                                   const ModesNotKept& not_kept,
                                   const std::vector<ComponentPart>& parts, bool of_faces,
                                   FreeEigenvalues* estimates, const Cholesky* M_res = nullptr);

// Only the strain energy outside fixed-interface modes; without rho_res. s: eigenvalues and its
// interface; `others`: settled().
Superelement::Accuracy accuracy_of_fixed_modes(const Interior& interior,
                                               const InterfaceMotions& motions,
                                               const Superelement& s, const Matrix& Phi,
                                               const ModesNotKept& others);

// Of a basis made from Craig-Bampton's form with figures `a` and `estimates`. Its elastic
// eigenvalues lambda, ascending, have errors of 1 - full / lambda at most. From below their error
// is at most Craig-Bampton's excess over them.
void judge_eigenvalues(const Vector& lambda, const FreeEigenvalues& estimates,
                       Superelement::Accuracy& a);

// Of exact free modes: elastic eigenvalues, ascending, and that of the next mode (0: not known).
// share: fraction of each mode's compliance at the interface that moves with it; empty: all.
Superelement::Accuracy accuracy_of_free_modes(const Vector& lambda, double next,
                                              const Vector& share);

// For the summary.
void say_accuracy(const Superelement& s, Report& report);

// Lines about a superelement in the summary of a reduction and of --info.
struct SummaryLine {
  std::string text;
  bool detail = false;  // for --verbose only
};

// Error estimates of the reduction, each with a good value; none without Superelement::accuracy.
std::vector<SummaryLine> accuracy_lines(const Superelement& superelement);

// The first six fixed-interface and free frequencies in Hz, as far as the superelement has them.
std::vector<SummaryLine> frequency_lines(const Superelement& superelement);

// At how many nodes the static compliance is in full, and in which directions. nodes: one of each
// entry (StaticShare::node); none without statics.
std::vector<SummaryLine> statics_lines(const std::vector<Index>& nodes, bool in_levels);

// "x_max (150 faces), corner (1 nodes)"; "none".
std::string sets_text(const Superelement& superelement);

// Where another basis usually steps faster in contact; "" where none does.
std::string advice_on_basis(const Superelement& superelement);

}  // namespace cbr

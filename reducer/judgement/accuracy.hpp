// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of reducer/judgement: errors and conditioning of a reduction; how many modes a
// tolerance needs.
//
// Errors of a reduction that are known before any run (docs/theory.md, "Errors known before the
// run").
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/judgement/missing_modes.hpp"
#include "reducer/modes/component_parts.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// Motions of the interface that errors are measured on: six rigid ones (translations along x, y, z
// and rotations about them through the centre of mass), then for each of `surfaces` what a uniform
// pressure on it does to the free component.
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

// s: K_cc, M_cc and what describes its interface. `part`: per node of it, the connected part of the
// component. 2 m solves. Without of_faces rigid ones alone.
InterfaceMotions interface_motions(const Partition& p, const SparseCholesky& factor,
                                   const Superelement& s, const std::vector<Index>& part,
                                   bool of_faces = true);

// Of these surfaces and W alone, which the superelement itself tells.
InterfaceMotions motions_of_interface(const Superelement& s, const std::vector<Index>& part,
                                      bool of_faces = true);

// What modes leave of E: D (m x m) of left_of_answer().
struct StrainLeftOut {
  Vector of_motion;    // m, shares
  double largest = 0;  // of all rigid motions
  Vector worst;        // n_rigid, the rigid motion that has it, in the first columns of W
};
StrainLeftOut strain_left_out(const InterfaceMotions& motions, const Matrix& D);

// Share of the energy of a free component that flies along the mean normal of a surface that it
// loses when all nodes of the surface are stopped in the direction of its normals at once,
// frictionless: (G r)^T (G M_res^-1 G^T)^-1 G r / r^T M_cc r with the normals' rows G and the rigid
// translation r.
double impact_share(const Superelement& s, const Cholesky& M_res, const Surface& surface);

// Fixed-interface modes that a superelement does not have.
struct ModesNotKept {
  Vector lambda;  // d, of those that were computed and dropped
  Matrix Phi;     // n_I x d
  // no other has a lower eigenvalue; 0: there are no others, or that is not known
  double beyond = 0;
  std::vector<double> beyond_of_part;  // the same of each part, where it is known better
};

// With residual vectors, which have a part of every mode, the modes that were dropped are not apart
// from the others any more; and `beyond`, where it is not known, by Lanczos.
ModesNotKept settled(ModesNotKept m, const Partition& p, const SparseCholesky& factor,
                     const Superelement& s);

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
// when there are several: strain left out and free modes then are each part's own. n_rigid: columns
// of V that are rigid motions; free modes are looked at when s has its diagonal form: their
// eigenvalues are too high by what the modes that are not kept take from the reduced stiffness
// (full_eigenvalues()); the lowest 32, none after the first that may be off by more than 0.1, and
// none above 0.95 of the first held mode that is missing. Two solves a mode. not_kept.beyond, where
// it is not known, is found by Lanczos. The lowest n_estimated + n_beside columns of the diagonal
// form do. of_faces: also what is told of each face, by M_res: residual_mass_factor() of s, or
// null: to be made.
Superelement::Accuracy accuracy_of(const Partition& p, const SparseCholesky& factor,
                                   const InterfaceMotions& motions, const Superelement& s,
                                   const Matrix& Phi, Index n_rigid, const ModesNotKept& not_kept,
                                   const std::vector<ComponentPart>& parts, bool of_faces,
                                   FreeEigenvalues* estimates, const Cholesky* M_res = nullptr);

// The same of a component of one part whose interior has been asked already: what accuracy_of()
// takes from it.
struct InteriorAnswers {
  std::optional<Vector3> rho_floor;  // of the mass that is lumped at the interface
  Matrix D;                          // left_of_answer() of motions.Y
  MissingModes missing;              // of free_motions(); D without rows: not asked
};
// of the interface in the lowest free modes   (c x m)
Matrix free_motions(const Superelement& s, Index n_rigid);
Superelement::Accuracy accuracy_of(const InteriorAnswers& answers, const InterfaceMotions& motions,
                                   const Superelement& s, Index n_rigid, const ModesNotKept& others,
                                   bool of_faces = true, FreeEigenvalues* free = nullptr,
                                   const Cholesky* M_res = nullptr);

// Of these only what fixed-interface modes leave out; without rho_res. s: eigenvalues and what
// describes its interface; `others`: settled().
Superelement::Accuracy accuracy_of_fixed_modes(const Partition& p, const SparseCholesky& factor,
                                               const InterfaceMotions& motions,
                                               const Superelement& s, const Matrix& Phi,
                                               const ModesNotKept& others);

// Of a basis that was made of Craig-Bampton's form, whose figures are `a` and `estimates`: its own
// elastic eigenvalues, ascending, are off by 1 - full / lambda at most, or from below by what
// Craig-Bampton's are above them.
void judge_eigenvalues(const Vector& lambda, const FreeEigenvalues& estimates,
                       Superelement::Accuracy& a);

// Of free modes, which are exact: elastic eigenvalues, ascending, and that of the next mode (0: not
// known). share: of each mode's compliance at the interface, what moves with it; empty: all.
Superelement::Accuracy accuracy_of_free_modes(const Vector& lambda, double next,
                                              const Vector& share);

// For the summary.
void say_accuracy(const Superelement& s, Report& report);

}  // namespace cbr

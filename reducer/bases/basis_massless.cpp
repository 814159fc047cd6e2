// SPDX-License-Identifier: GPL-3.0-or-later
// Basis massless: modes of the free component carry all inertia. The algebra is in massless.cpp.
#include <cmath>
#include <numbers>
#include <utility>

#include "reducer/bases/massless.hpp"
#include "reducer/bases/reduction_steps.hpp"
#include "reducer/condensation/superelement_algebra.hpp"

namespace cbr {
namespace {

void keep_figures(Reduction& r, const Superelement& s, MasslessFigures&& m) {
  r.figures.highest_frequency = std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi);
  r.figures.massless = std::move(m);
}

void refuse_mechanism(Reduction& r, const Superelement& s) {
  const Matrix R = rigid_motions_of_parts(s, parts_of_interface(r)).bottomRows(s.c());
  const SoftestMotion softest = softest_motion(s.K_cc, R);
  r.figures.condition.softest = softest.stiffness;
  if (s.c() == R.cols()) return;
  refuse_mechanism(softest, softest.dof >= 0 ? node_of_interface_dof(r, softest.dof)
                                             : r.figures.condition.weakest);
}

// Of the rows of the model   (N x r)
Matrix rigid_motions_left(const Reduction& r, const Superelement& s) {
  std::vector<Index> free;
  for (std::size_t dof = 0; dof < r.model.row_of_dof.size(); ++dof)
    if (r.model.row_of_dof[dof] >= 0) free.push_back(static_cast<Index>(dof));
  return Matrix(rigid_modes(r.x, s.rigid_body.center)(free, Eigen::all)) * free_combinations(s);
}

}  // namespace

void make_basis_massless(Reduction& r, Superelement& s) {
  const auto phase = r.report.phase("free modes");
  refuse_mechanism(r, s);
  FreeModel model{r.model.K, r.model.M, r.x, r.part, r.model.n_rotations};
  if (s.fixed.any()) model.left = rigid_motions_left(r, s);
  MasslessFigures m = make_massless(model, r.p, *r.factor,
                                    {r.options.modes.value_or(0), r.options.cutoff_hz.value_or(0),
                                     r.options.massless_modes == MasslessModes::tapered},
                                    s, r.report);
  r.figures.n_candidates = s.k();
  r.figures.mode_method = m.free.method;
  r.figures.modes_proven = m.free.proven;
  r.figures.condition.counts = m.free.counts;
  r.figures.condition.modes = m.modes;
  if (r.options.modes) warn_of_cut_pair(s.eigenvalues, m.free.next, r.report);
  s.accuracy = accuracy_of_free_modes(s.eigenvalues.tail(s.k() - m.n_rigid), m.free.next, m.share);
  keep_lowest(r, m.free.Phi.middleCols(m.n_rigid, s.k() - m.n_rigid));
  if (s.fixed.any()) s.fixed.momentum = m.free.Phi.leftCols(s.k()).transpose() * r.momentum;
  m.free.Phi = Matrix();
  keep_figures(r, s, std::move(m));
}

}  // namespace cbr

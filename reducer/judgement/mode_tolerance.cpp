// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/judgement/mode_tolerance.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/condensation/superelement_algebra.hpp"
#include "reducer/judgement/missing_modes.hpp"

namespace cbr {
namespace {

constexpr Index first_candidates = 64, most_candidates = 5000;
constexpr Index most_interface_dofs = 6000;  // interface dofs up to which free modes are looked at
constexpr double one_frequency = 1e-6;       // of eigenvalues: closer ones are taken together
// times a free mode's eigenvalue: held modes below are kept in any case
constexpr double near = 2;
// Of the tolerance. Modes are picked for less than the accepted error, as the free modes are
// inexact until they are computed again.
constexpr double aim = 0.9, accepted = 0.98;
constexpr Index beside = 16;  // free modes above the ten that these may mix with

// M_kc of modes, K_II^-1 M_II Phi being Phi Lambda^-1   (k x c)
Matrix coupling_of_modes(const Partition& p, const FixedInterfaceModes& modes) {
  if (modes.lambda.size() == 0) return Matrix(0, p.n_interface());
  return Matrix(p.M_IC.transpose() * modes.Phi).transpose() -
         modes.lambda.cwiseInverse().asDiagonal() *
             Matrix(p.K_IC.transpose() * modes.Phi).transpose();
}

// Eigenvalues and interface parts of the free component's lowest modes, rigid ones first, with the
// modes at hand.
struct FreeModes {
  // elastic ones whose error counts; those after them may mix with them
  Index n_rigid = 0, n_asked = 0;
  Vector lambda;    // f
  Matrix U;         // c x f
  double less = 0;  // share of M_kc that was left out

  double last_asked() const { return n_asked > 0 ? lambda(n_rigid + n_asked - 1) : 0; }
};

FreeModes free_modes(const Partition& p, const Superelement& s, const std::vector<Index>& part,
                     const FixedInterfaceModes& modes) {
  if (s.c() > most_interface_dofs) return {0, 0, Vector(0), Matrix(s.c(), 0), 0};
  Superelement reduced;
  reduced.node_ids = s.node_ids;
  reduced.coordinates = s.coordinates;
  reduced.rigid_body = s.rigid_body;
  reduced.fixed = s.fixed;
  reduced.dof_node = s.dof_node;
  reduced.dof_component = s.dof_component;
  reduced.eigenvalues = modes.lambda;
  reduced.K_cc = s.K_cc;
  reduced.M_cc = s.M_cc;
  reduced.M_kc = coupling_of_modes(p, modes);
  follow_rigid_motions(p.rigid, p.rigid.G, p.rigid.momentum(modes.Phi), reduced.M_kc);
  const Index n_rigid = rigid_motions_of_parts(reduced, part).cols();
  const Index asked = std::min(reduced.n() - n_rigid, n_free_modes_of_tolerance);
  const Index count = std::min(reduced.n(), n_rigid + asked + beside);
  if (asked <= 0) return {0, 0, Vector(0), Matrix(s.c(), 0), 0};
  Eigenpairs pairs = dense_eigenpairs(reduced_stiffness(reduced), reduced_mass(reduced), count);
  // An ill-conditioned K_II makes M_kc fit M_cc so badly that modes may couple more than there is
  // mass: a little less will do here
  double left = 1;
  for (double less = 1e-6; !pairs.converged && less < 0.1; less *= 30) {
    reduced.M_kc *= 1 - less;
    left *= 1 - less;
    pairs = dense_eigenpairs(reduced_stiffness(reduced), reduced_mass(reduced), count);
  }
  if (!pairs.converged)
    throw LostMass(
        "tolerance: the mass that the modes leave on the interface is lost in round-off, as that "
        "of very thin parts is: use larger or "
        "less flat elements, or say how many modes are to be kept");
  return {n_rigid, asked, pairs.lambda.cwiseMax(0.0), pairs.Phi.bottomRows(s.c()), 1 - left};
}

using Taken = std::vector<char>;  // 1 or 0 per candidate

std::vector<Index> rows(const Taken& taken, char value) {
  std::vector<Index> list;
  for (std::size_t j = 0; j < taken.size(); ++j)
    if (taken[j] == value) list.push_back(static_cast<Index>(j));
  return list;
}

class Picker {
 public:
  Picker(const Interior& interior, const InterfaceMotions& motions, double tolerance)
      : interior_(interior), motions_(motions), tolerance_(tolerance) {}

  void set_free_modes(FreeModes&& free) {
    free_ = std::move(free);
    Y_.resize(interior_.n_rows(), motions_.size() + free_.U.cols());
    Y_ << motions_.Y, inertia_forces(interior_, free_.U);
  }

  // From now on these are the candidates.
  void set_candidates(const FixedInterfaceModes& modes) {
    const Index m = motions_.size(), f = free_.U.cols(), n = interior_.p.n_interior();
    lambda_ = modes.lambda;
    const Matrix all = modes.Phi.transpose() * Y_;
    rigid_ = lambda_.cwiseSqrt().cwiseInverse().asDiagonal() * all.leftCols(m);
    A_ = all.rightCols(f);
    LeftOfAnswer left{Matrix::Zero(m + f, m + f), Matrix::Zero(m + f, m + f)};
    if (lambda_.size() < n)
      left = left_of_answer(interior_, {modes.Phi}, Vector(0), Matrix(n, 0), Y_);
    rigid_beyond_ = left.D.topLeftCorner(m, m);
    beyond_.D = left.D.bottomRightCorner(f, f);
    beyond_.D_2 = left.D_2.bottomRightCorner(f, f);
    beyond_.beyond = lambda_.size() < n ? lambda_.maxCoeff() : 0;
    beyond_.A.resize(0, A_.cols());
  }

  // True if all candidates together reach the target error.
  bool suffices() const {
    if (beyond_.beyond == 0) return true;
    if (strain_left_out(motions_, rigid_beyond_).largest > tolerance_) return false;
    return beyond_.beyond > near * free_.last_asked() &&
           errors(beyond_).maxCoeff() <= aim * tolerance_;
  }

  // Those given, and more as the errors require. Errors are exact if the free modes are those of
  // the given ones.
  Taken pick(Taken given) const {
    given.resize(lambda_.size(), 0);
    Taken taken = given;
    for (Index j = 0; j < lambda_.size(); ++j)
      if (lambda_(j) <= near * free_.last_asked()) take(j, taken);
    pick_for_strain(taken);
    if (free_.n_asked > 0) pick_for_free_modes(taken, taken == given ? accepted : aim);
    return taken;
  }

 private:
  // Of the free modes that are asked for   (n_asked)
  Vector errors(const MissingModes& missing, Matrix* z = nullptr, Vector* sigma = nullptr) const {
    if (free_.n_asked == 0) return Vector::Zero(1);
    const Vector full = full_eigenvalues(free_.lambda, missing, free_.n_rigid, free_.n_asked, z);
    if (sigma != nullptr) *sigma = full;
    const auto own = free_.lambda.segment(free_.n_rigid, free_.n_asked);
    return (own.array() > 0).select(1 - full.array() / own.array(), 0.0);
  }

  // One by one the candidate that has most of the worst rigid acceleration's
  void pick_for_strain(Taken& taken) const {
    for (;;) {
      const std::vector<Index> others = rows(taken, 0);
      const Matrix not_taken = rigid_(others, Eigen::all);
      const StrainLeftOut left =
          strain_left_out(motions_, rigid_beyond_ + not_taken.transpose() * not_taken);
      if (left.largest <= tolerance_) return;
      const Vector part = (rigid_.leftCols(InterfaceMotions::n_rigid) * left.worst).cwiseAbs2();
      if (others.empty()) return;
      take(*std::max_element(others.begin(), others.end(),
                             [&](Index i, Index j) { return part(i) < part(j); }),
           taken);
    }
  }

  // Picks modes with the largest part in a free mode's error, until it is halved or reaches the
  // target. An error by number does not identify the mode. Where a poor mode passes a good one, the
  // good one's number has the same error, but lacks no modes.
  void pick_for_free_modes(Taken& taken, double enough) const {
    for (;; enough = aim) {
      MissingModes missing = beyond_;
      std::vector<Index> others = rows(taken, 0);
      missing.lambda = lambda_(others);
      missing.A = A_(others, Eigen::all);
      Matrix z;
      Vector sigma;
      const double most = errors(missing, &z, &sigma).maxCoeff();
      if (most <= enough * tolerance_ || others.empty()) return;
      // z^T S z = sigma^2 sum (A_j z)^2 / (lambda_j - sigma) + ...   (others x n_asked)
      Matrix part = (missing.A * z).cwiseAbs2();
      for (Index i = 0; i < part.cols(); ++i)
        part.col(i).array() *= sigma(i) / (missing.lambda.array() - sigma(i));
      Index poorest = 0, first = 0;
      const double whole = part.colwise().sum().maxCoeff(&poorest);
      std::vector<Index> order = first_numbers(others.size());
      std::sort(order.begin(), order.end(),
                [&](Index i, Index j) { return part(i, poorest) > part(j, poorest); });
      double excess = std::min(1 - aim * tolerance_ / most, 0.5) * whole;
      do {
        const Index j = order[first++];
        take(others[j], taken);
        excess -= part(j, poorest);
      } while (excess > 0 && first < missing.lambda.size());
    }
  }

  void take(Index row, Taken& taken) const {
    const auto alike = [&](Index i, Index j) {
      return std::abs(lambda_(i) - lambda_(j)) <= one_frequency * lambda_(i);
    };
    taken[row] = 1;
    for (Index j = row + 1; j < lambda_.size() && alike(j - 1, j); ++j) taken[j] = 1;
    for (Index j = row - 1; j >= 0 && alike(j + 1, j); --j) taken[j] = 1;
  }

  const Interior& interior_;
  const InterfaceMotions& motions_;
  const double tolerance_;
  FreeModes free_;
  Matrix Y_;             // n_I x (m + f), of the motions and the free modes
  Vector lambda_;        // k, of the candidates
  Matrix rigid_;         // k x m, Phi^T Y / sqrt(lambda)
  Matrix rigid_beyond_;  // m x m, D of the motions, outside all candidates
  Matrix A_;             // k x f, Phi^T Y of the free modes
  MissingModes beyond_;  // outside all candidates
};

FixedInterfaceModes some_of(const FixedInterfaceModes& all, const Taken& taken, char value) {
  const std::vector<Index> which = rows(taken, value);
  return {all.lambda(which), all.Phi(Eigen::all, which), all.method, all.proven, 0, all.counts};
}

}  // namespace

ModesOfTolerance modes_of_tolerance(const Partition& p, const SparseCholesky& factor,
                                    const InterfaceMotions& motions, const Superelement& s,
                                    const std::vector<Index>& part, double tolerance,
                                    Report& report) {
  ModesOfTolerance result;
  result.modes.Phi.resize(p.n_interior(), 0);
  result.modes.method = "none";
  result.modes.proven = true;
  result.not_kept.Phi.resize(p.n_interior(), 0);
  if (p.n_interior() == 0) return result;
  FixedInterfaceModes candidates = more_modes(p, factor, result.modes, first_candidates, report);
  const LocalInterior interior(p, factor);
  Picker picker(interior, motions, tolerance);
  picker.set_free_modes(free_modes(p, s, part, candidates));
  picker.set_candidates(candidates);
  const auto enough_candidates = [&] {
    while (!picker.suffices()) {
      if (candidates.lambda.size() >= most_candidates)
        throw InputError("tolerance: " + number_text(tolerance) + " needs more than the lowest " +
                         std::to_string(candidates.lambda.size()) +
                         " modes: take a larger one, or say how many modes are to be kept");
      const Index twice = 2 * candidates.lambda.size();
      candidates = more_modes(p, factor, std::move(candidates), twice, report);
      picker.set_candidates(candidates);
    }
  };
  Taken taken;
  double less = 0;
  for (bool first = true;; first = false) {
    enough_candidates();
    taken.resize(candidates.lambda.size(), 0);
    Taken more = picker.pick(taken);
    if (!first && more == taken) break;
    taken = std::move(more);
    result.modes = some_of(candidates, taken, 1);
    FreeModes free = free_modes(p, s, part, result.modes);
    less = free.less;
    picker.set_free_modes(std::move(free));
    picker.set_candidates(candidates);
  }
  if (less > 0)
    report.warning(
        format_text("tolerance: by round-off the modes couple more mass than the interface has: "
                    "the free modes that they were picked for have %.1e of the coupling less; the "
                    "stiffness of the interior is ill-conditioned: use less flat elements, or say "
                    "how many modes are to be kept",
                    less));
  result.n_candidates = candidates.lambda.size();
  FixedInterfaceModes others = some_of(candidates, taken, 0);
  result.not_kept.lambda = std::move(others.lambda);
  result.not_kept.Phi = std::move(others.Phi);
  if (result.n_candidates < p.n_interior())
    result.not_kept.beyond = candidates.lambda(result.n_candidates - 1);
  return result;
}

void judge_tolerance(double tolerance, double left_out, double mode_error, double condition,
                     Report& report) {
  constexpr double slack = 1e-6;
  const double most = (1 + slack) * tolerance;
  if (left_out <= most && mode_error <= most) return;
  std::string what;
  if (!(left_out <= most))
    what = format_text("the modes leave %.2g of the strain energy under a rigid acceleration out",
                       left_out);
  if (!(mode_error <= most))
    what += (what.empty() ? "" : ", and ") +
            format_text("one of the ten lowest eigenvalues is too high by %.2g", mode_error);
  report.warning(format_text("tolerance: %g is not met: ", tolerance) + what +
                 format_text(" (estimated): by round-off of a stiffness that is conditioned %.0e; "
                             "take a larger tolerance, use less flat "
                             "elements, or say how many modes are to be kept",
                             condition));
}

ModesOfTolerance modes_of_tolerance(const Partition& p, const std::vector<ComponentPart>& parts,
                                    const Superelement& s, double tolerance, Report& report) {
  ModesOfTolerance all;
  std::vector<FixedInterfaceModes> kept, others;
  for (const ComponentPart& part : parts) {
    const SparseCholesky factor(part.p.K_II);
    const Superelement own = part_of(s, part);
    const InterfaceMotions motions =
        interface_motions(LocalInterior(part.p, factor), own, part.one());
    ModesOfTolerance found =
        modes_of_tolerance(part.p, factor, motions, own, part.one(), tolerance, report);
    all.n_candidates += found.n_candidates;
    all.not_kept.beyond_of_part.push_back(found.not_kept.beyond);
    if (const double beyond = found.not_kept.beyond; beyond > 0)
      all.not_kept.beyond =
          all.not_kept.beyond > 0 ? std::min(all.not_kept.beyond, beyond) : beyond;
    kept.push_back(std::move(found.modes));
    others.push_back(
        {std::move(found.not_kept.lambda), std::move(found.not_kept.Phi), "none", true});
  }
  all.modes = joined(parts, kept, p.n_interior());
  FixedInterfaceModes dropped = joined(parts, others, p.n_interior());
  all.not_kept.lambda = std::move(dropped.lambda);
  all.not_kept.Phi = std::move(dropped.Phi);
  return all;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/mode_tolerance.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/error.hpp"
#include "common/linalg/eigenpairs.hpp"
#include "common/number_text.hpp"
#include "reducer/diagonal_form.hpp"

namespace cbr {
namespace {

constexpr Index first_candidates = 64, most_candidates = 5000;
constexpr Index largest_dense = 6000;   // interface dofs up to which free modes are looked at
constexpr double one_frequency = 1e-6;  // of eigenvalues: closer ones are taken together
constexpr double near = 2;              // times a free mode's eigenvalue: held modes below are kept in any case
constexpr double margin = 0.9;          // of the tolerance: the free modes that an error is estimated with are a little off
constexpr int most_rounds = 6;

// M_kc of modes, K_II^-1 M_II Phi being Phi Lambda^-1   (k x c)
Matrix coupling_of_modes(const Partition& p, const FixedInterfaceModes& modes) {
  if (modes.lambda.size() == 0) return Matrix(0, p.n_interface());
  return Matrix(p.M_IC.transpose() * modes.Phi).transpose() -
         modes.lambda.cwiseInverse().asDiagonal() * Matrix(p.K_IC.transpose() * modes.Phi).transpose();
}

// Eigenvalue and interface part of the free component's lowest elastic modes, with the modes at hand.
struct FreeModes {
  Vector lambda;  // f
  Matrix U;       // c x f
};

FreeModes free_modes(const Partition& p, const Superelement& s, const std::vector<Index>& part, const FixedInterfaceModes& modes) {
  if (s.c() > largest_dense) return {Vector(0), Matrix(s.c(), 0)};
  Superelement reduced;
  reduced.node_ids = s.node_ids, reduced.coordinates = s.coordinates, reduced.rigid_body = s.rigid_body;
  reduced.dof_node = s.dof_node, reduced.dof_component = s.dof_component;
  reduced.eigenvalues = modes.lambda, reduced.K_cc = s.K_cc, reduced.M_cc = s.M_cc;
  reduced.M_kc = coupling_of_modes(p, modes);
  const Index n_rigid = rigid_motions_of_parts(reduced, part).cols();
  const Index count = std::min(reduced.n(), n_rigid + n_free_modes_of_tolerance) - n_rigid;
  if (count <= 0) return {Vector(0), Matrix(s.c(), 0)};
  const Eigenpairs pairs = dense_eigenpairs(reduced_stiffness(reduced), reduced_mass(reduced), n_rigid + count);
  if (!pairs.converged) throw RunError("the reduced mass is not positive definite");
  return {pairs.lambda.tail(count).cwiseMax(0.0), pairs.Phi.bottomRightCorner(s.c(), count)};
}

class Picker {
 public:
  Picker(const Partition& p, const SparseCholesky& factor, const InterfaceMotions& motions, double tolerance)
      : factor_(factor), motions_(motions), tolerance_(tolerance), p_(p) {}

  void set_free_modes(FreeModes&& free) {
    free_ = std::move(free);
    Y_free_ = inertia_forces(p_, factor_, free_.U);
    Matrix X = Y_free_;
    factor_.solve_in_place(X);
    E_free_ = Y_free_.cwiseProduct(X).colwise().sum().transpose();
  }

  // From now on these are the candidates.
  void set_candidates(const FixedInterfaceModes& modes) {
    lambda_ = modes.lambda;
    const Index k = lambda_.size(), f = free_.lambda.size();
    rigid_.setZero(k, motions_.size()), free_part_.setZero(k, f), tail_.setZero(f);
    if (k == 0) return;
    rigid_ = lambda_.cwiseSqrt().cwiseInverse().asDiagonal() * Matrix(modes.Phi.transpose() * motions_.Y);
    const Matrix A = modes.Phi.transpose() * Y_free_;
    for (Index i = 0; i < f; ++i) {
      // What a missing mode makes of the eigenvalue's error: lambda a^2 / (Lambda - lambda); of those beyond lambda a^2 / Lambda is
      // known in sum, and no more than 1 - lambda / Lambda_last too little
      const double lambda = free_.lambda(i);
      for (Index j = 0; j < k; ++j) free_part_(j, i) = is_near(j, i) ? 0 : lambda * A(j, i) * A(j, i) / (lambda_(j) - lambda);
      const double beyond = std::max(0.0, E_free_(i) - A.col(i).cwiseAbs2().dot(lambda_.cwiseInverse()));
      tail_(i) = lambda * beyond / std::max(1 - lambda / lambda_(k - 1), 1 - 1 / near);
    }
  }

  // The largest error over the tolerance when the rows marked in `taken` are kept; `part`: what each candidate has in it.
  double worst(const std::vector<char>& taken, Vector* part = nullptr) const {
    std::vector<Index> rows;
    for (Index j = 0; j < lambda_.size(); ++j)
      if (taken[j] != 0) rows.push_back(j);
    const StrainLeftOut left = strain_left_out(motions_, rigid_(rows, Eigen::all));
    double most = left.largest / tolerance_;
    Index which = -1;
    for (Index i = 0; i < free_.lambda.size(); ++i) {
      double error = tail_(i) + free_part_.col(i).sum();
      for (const Index j : rows) error -= free_part_(j, i);
      error /= margin * tolerance_;
      if (error > most) most = error, which = i;
    }
    if (part != nullptr && which >= 0) *part = free_part_.col(which);
    if (part != nullptr && which < 0) *part = (rigid_.leftCols(InterfaceMotions::n_rigid) * left.worst).cwiseAbs2();
    return most;
  }

  bool suffices() const {
    const bool reaches =
        free_.lambda.size() == 0 || (lambda_.size() > 0 && lambda_(lambda_.size() - 1) > near * free_.lambda.maxCoeff());
    return reaches && worst(std::vector<char>(lambda_.size(), 1)) <= 1;
  }

  // Rows, ascending; those that are given among them.
  std::vector<Index> pick(const std::vector<Index>& given) const {
    std::vector<char> taken(lambda_.size(), 0);
    for (const Index j : given) taken[j] = 1;
    for (Index j = 0; j < lambda_.size(); ++j)
      for (Index i = 0; i < free_.lambda.size(); ++i)
        if (is_near(j, i)) take(j, taken);
    Vector part;
    while (worst(taken, &part) > 1) {
      Index best = -1;
      for (Index j = 0; j < part.size(); ++j)
        if (taken[j] == 0 && (best < 0 || part(j) > part(best))) best = j;
      if (best < 0) break;
      take(best, taken);
    }
    std::vector<Index> rows;
    for (Index j = 0; j < lambda_.size(); ++j)
      if (taken[j] != 0) rows.push_back(j);
    return rows;
  }

 private:
  bool is_near(Index mode, Index free) const { return lambda_(mode) <= near * free_.lambda(free); }

  void take(Index row, std::vector<char>& taken) const {
    const auto alike = [&](Index i, Index j) { return std::abs(lambda_(i) - lambda_(j)) <= one_frequency * lambda_(i); };
    taken[row] = 1;
    for (Index j = row + 1; j < lambda_.size() && alike(j - 1, j); ++j) taken[j] = 1;
    for (Index j = row - 1; j >= 0 && alike(j + 1, j); --j) taken[j] = 1;
  }

  const SparseCholesky& factor_;
  const InterfaceMotions& motions_;
  const double tolerance_;
  const Partition& p_;
  FreeModes free_;
  Matrix Y_free_;     // n_I x f
  Vector E_free_;     // f, Y^T K_II^-1 Y
  Vector lambda_;     // k, of the candidates
  Matrix rigid_;      // k x m, Phi^T Y / sqrt(lambda)
  Matrix free_part_;  // k x f
  Vector tail_;       // f
};

}  // namespace

ModesOfTolerance modes_of_tolerance(const Partition& p, const SparseCholesky& factor, const InterfaceMotions& motions,
                                    const Superelement& s, const std::vector<Index>& part, double tolerance, Report& report) {
  ModesOfTolerance result;
  result.modes.Phi.resize(p.n_interior(), 0);
  result.modes.method = "none", result.modes.proven = true;
  if (p.n_interior() == 0) return result;
  FixedInterfaceModes candidates = more_modes(p, factor, std::move(result.modes), first_candidates, report);
  Picker picker(p, factor, motions, tolerance);
  picker.set_free_modes(free_modes(p, s, part, candidates));
  picker.set_candidates(candidates);
  std::vector<Index> rows;
  // The free modes of what was picked are a little other ones, and may be in another order: until nothing comes of that any more
  for (int round = 0; round < most_rounds; ++round) {
    while (candidates.lambda.size() < p.n_interior() && !picker.suffices()) {
      if (candidates.lambda.size() >= most_candidates)
        throw InputError("tolerance: " + number_text(tolerance) + " needs more than the lowest " +
                         std::to_string(candidates.lambda.size()) +
                         " modes: take a larger one, or say how many modes are to be kept");
      const Index twice = 2 * candidates.lambda.size();
      candidates = more_modes(p, factor, std::move(candidates), twice, report);
      picker.set_candidates(candidates);
    }
    const std::size_t before = rows.size();
    rows = picker.pick(rows);
    if (round > 0 && rows.size() == before) break;
    result.modes = {candidates.lambda(rows), candidates.Phi(Eigen::all, rows), candidates.method, candidates.proven, 0,
                    candidates.counts};
    picker.set_free_modes(free_modes(p, s, part, result.modes));
    picker.set_candidates(candidates);
  }
  result.n_candidates = candidates.lambda.size();
  result.complete = candidates.lambda(result.n_candidates - 1);
  for (Index j = 0; j < result.n_candidates; ++j) {
    if (std::binary_search(rows.begin(), rows.end(), j)) continue;
    result.complete = candidates.lambda(j);
    break;
  }
  return result;
}

}  // namespace cbr

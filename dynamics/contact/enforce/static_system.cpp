// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/static_system.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cbr {
namespace {

// Times the largest diagonal entry: a row between supported bodies has a diagonal of round-off.
constexpr double no_answer = 1e-20;
// Times a row's diagonal entry: a row with a smaller pivot depends on earlier rows.
constexpr double implied = 1e-11;
// Times the largest singular value of B of the ties: they do not constrain motions below it. Times
// the norm of B: such entries are round-off, as of a rigid point, which deforms in no rigid motion.
constexpr double not_held = 1e-9, no_motion = 1e-12;
// Springs on floating bodies for one solution of contact, relative to the compliance of contact.
// They must be soft so that contact carries the load, and stiff enough for accuracy.
constexpr double softness = 10;
// Fractions of these springs that remain in a Newton step. The least is negligible; more remains if
// the step is too long or does not reduce the imbalance.
constexpr double least_hold = 1e-10, more_hold = 1e-4, most_hold = 1e3, slow = 0.7;
// Relative to the acting forces: largest imbalance; and the one accepted when round-off prevents
// any further reduction.
constexpr double balanced = 1e-12, nearly_balanced = 1e-10;
// Of the largest allowed motion: gap that counts as touching.
constexpr double touching = 1e-9;
// Times the largest diagonal entry of B^T B: closed points do not resist motions below it.
constexpr double no_grip = 1e-10;
constexpr int most_moves = 40;
// Relative to an imbalance: change by a motion that contact does not resist.
constexpr double unresisted = 1e-9;
// Times the mean diagonal entry of W, added to a matrix that may be singular.
constexpr double regular = 1e-12;

// The linearly independent rows of a positive semi-definite A with a unit diagonal, in order.
std::vector<Index> independent_rows(const Matrix& A) {
  constexpr Index panel = 64;
  const Index n = A.rows();
  Matrix L = Matrix::Zero(n, n);  // column r belongs to the r-th independent row
  std::vector<Index> rows;
  for (Index first = 0; first < n; first += panel) {
    const Index count = std::min(panel, n - first), before = static_cast<Index>(rows.size());
    Matrix left = A.block(first, first, n - first, count);
    left.noalias() -=
        L.block(first, 0, n - first, before) * L.block(first, 0, count, before).transpose();
    for (Index j = 0; j < count; ++j) {
      const Index r = static_cast<Index>(rows.size()), below = n - first - j;
      Vector column = left.col(j).tail(below);
      column.noalias() -= L.block(first + j, before, below, r - before) *
                          L.block(first + j, before, 1, r - before).transpose();
      if (!(column[0] > implied)) continue;
      L.col(r).tail(below) = column / std::sqrt(column[0]);
      rows.push_back(first + j);
    }
  }
  return rows;
}

// The factor x that makes x B B^T as large as W; `other` if either is 0.
double floating_share(const Matrix& W, const Matrix& B, double other) {
  const double of_W = W.trace(), of_B = B.squaredNorm();
  return of_W > 0 && of_B > 0 ? of_W / of_B : other;
}

double largest(const Vector& x) { return x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0; }

// The force to which the balance of motions B is relative: contact along a motion that friction
// alone resists may have a force of round-off, but not the pressure behind it.
double acting_force(const Matrix& B, const Vector& p, double force) {
  return p.size() > 0 && B.size() > 0 ? std::max(force, B.cwiseAbs().maxCoeff() * p.lpNorm<1>())
                                      : force;
}

// A x, also for an A without rows, which BLAS rejects.
Vector times(const Matrix& A, const Vector& x) {
  return A.size() > 0 ? Vector(A * x) : Vector::Zero(A.rows());
}

}  // namespace

Vector unheld_moves(const Vector& c, const Matrix& N, double force, double way) {
  if (!(largest(c) > balanced * force)) return Vector::Zero(c.size());
  return c * (way / largest(N * c));
}

StaticSystem::StaticSystem(Matrix W, Matrix B, const std::vector<PointLaw>& laws,
                           double flexibility)
    : W_(std::move(W)), B_(std::move(B)) {
  rho_ = floating_share(W_, B_, flexibility);
  if (B_.cols() > 0) W_.noalias() += rho_ * B_ * B_.transpose();
  split(laws);
  factor_ties();
  reduce(flexibility);
}

void StaticSystem::split(const std::vector<PointLaw>& laws) {
  const Vector diagonal = W_.diagonal();
  const double least = diagonal.size() > 0 ? no_answer * diagonal.maxCoeff() : 0;
  Index row = 0;
  for (const PointLaw& law : laws) {
    const bool tied = law.law == ContactLaw::tied;
    if (!tied) contact_laws_.push_back(law);
    for (Index d = 0; d < n_rows(law.law); ++d, ++row) {
      if (!tied) {
        contact_rows_.push_back(row);
      } else if (diagonal[row] > least) {
        tie_rows_.push_back(row);
      }
    }
  }
}

void StaticSystem::factor_ties() {
  if (tie_rows_.empty()) return split_moves();
  Matrix A = W_(tie_rows_, tie_rows_);
  scale_ = A.diagonal().cwiseSqrt().cwiseInverse();
  A = (scale_.asDiagonal() * A * scale_.asDiagonal()).eval();
  L_.emplace(A);
  if (!L_->ok() || !(L_->diagonal().array().square() > implied).all()) {
    const std::vector<Index> rows = independent_rows(A);
    std::vector<Index> kept;
    for (const Index row : rows) kept.push_back(tie_rows_[row]);
    tie_rows_ = std::move(kept);
    scale_ = Vector(scale_(rows));
    L_.emplace(A(rows, rows));
  }
  split_moves();
  U_.resize(static_cast<Index>(tie_rows_.size()), Q_.cols());
  if (U_.size() > 0) U_ = scale_.asDiagonal() * Matrix(B_(tie_rows_, Eigen::all)) * Q_;
  L_->solve_lower_in_place(U_);
  S_.emplace(U_.transpose() * U_);
}

// Splits motions into those that ties constrain and the others.
void StaticSystem::split_moves() {
  const Index n = B_.cols();
  Q_ = N_ = Matrix::Identity(n, n);
  if (tie_rows_.empty() || n == 0) {
    Q_.resize(n, 0);
    return;
  }
  Matrix B = Matrix::Zero(std::max(n, static_cast<Index>(tie_rows_.size())), n);
  B.topRows(static_cast<Index>(tie_rows_.size())) = B_(tie_rows_, Eigen::all);
  const RightSingular svd =
      right_singular(householder_reflections(B).packed.topRows(n).triangularView<Eigen::Upper>());
  const double least = std::max(not_held * svd.values[0], no_motion * B_.norm());
  const Index held = (svd.values.array() > least).count();
  Q_ = svd.V.leftCols(held);
  N_ = svd.V.rightCols(n - held);
}

// Eliminates ties for forces on contact: W - V^T V + E^T E.
void StaticSystem::reduce(double flexibility) {
  Matrix W = W_(contact_rows_, contact_rows_);
  const Matrix B = B_(contact_rows_, Eigen::all);
  if (!tie_rows_.empty() && !contact_rows_.empty()) {
    Matrix V = scale_.asDiagonal() * Matrix(W_(tie_rows_, contact_rows_));
    L_->solve_lower_in_place(V);
    W.noalias() -= V.transpose() * V;
    if (Q_.cols() > 0) {
      Matrix E = U_.transpose() * V - Q_.transpose() * B.transpose();
      S_->solve_lower_in_place(E);
      W.noalias() += E.transpose() * E;
    }
    W = (0.5 * (W + W.transpose())).eval();
  }
  contact_B_ = N_.cols() > 0 ? Matrix(B * N_) : Matrix(B.rows(), 0);
  if (N_.cols() > 0) spring_ = softness * floating_share(W, contact_B_, flexibility);
  GapResponse response;
  response.dense = std::move(W);
  problem_ = contact_problem(std::move(response), contact_laws_);
  // Rigid bodies have no compliance to scale the laws with
  const double share = rigid_share * spring_;
  for (Index i = 0; i < problem_.n_points(); ++i) {
    for (Index row = problem_.first[i]; row < problem_.first[i + 1]; ++row) {
      problem_.diagonal[row] += share * contact_B_.row(row).squaredNorm();
      problem_.w[i] = std::max(problem_.w[i], problem_.diagonal[row]);
    }
  }
}

// W p + B moves = a of the ties, B^T p = b of the motions that they constrain.
StaticSystem::Held StaticSystem::hold(const Vector& a, const Vector& b) const {
  if (tie_rows_.empty()) return {Vector(), Vector::Zero(b.size())};
  Matrix x = scale_.cwiseProduct(a);
  L_->solve_lower_in_place(x);
  const Vector y = S_->solve(Vector(U_.transpose() * x.col(0) - times(Q_.transpose(), b)));
  x.col(0) -= U_ * y;
  L_->solve_upper_in_place(x);
  return {scale_.cwiseProduct(x.col(0)), times(Q_, y)};
}

StaticSystem::Solution StaticSystem::solve(const Vector& g, const Vector& c, const Vector& guess,
                                           double largest_force, double most_way) {
  Solution solution;
  solution.largest_force = std::max(largest_force, largest(c));
  const Vector g_1 = g + rho_ * (B_ * c);
  const auto held = [&](const Vector& gap, const Vector& force) {
    return hold(-gap(tie_rows_), -force);
  };
  // Tie forces under the loads alone
  const Held without = held(g_1, c);
  solution.p.setZero(g.size());
  solution.p(tie_rows_) = without.p;
  Vector gap = g_1 + W_ * solution.p + B_ * without.moves;
  solution.p(contact_rows_) = guess(contact_rows_);
  const Vector moved = press(gap(contact_rows_), times(N_.transpose(), c), most_way, solution);
  // Adds tie forces under contact; the second pass removes round-off
  solution.p(tie_rows_).setZero();
  solution.moves = times(N_, moved);
  for (int pass = 0; pass < 2; ++pass) {
    gap = g_1 + W_ * solution.p + B_ * solution.moves;
    const Held more = held(gap, c + B_.transpose() * solution.p);
    solution.p(tie_rows_) += more.p;
    solution.moves += more.moves;
  }
  solution.gap = g_1 + W_ * solution.p + B_ * solution.moves;
  solution.left = c + B_.transpose() * solution.p;
  solution.moves += rho_ * solution.left;
  solution.largest_force = acting_force(B_, solution.p, solution.largest_force);
  const Vector of_contact =
      law_violations(problem_, solution.p(contact_rows_), solution.gap(contact_rows_));
  solution.scale = largest(g);
  for (Index i = 0; i < problem_.n_points(); ++i)
    solution.scale = std::max(
        solution.scale, problem_.w[i] * std::abs(solution.p[contact_rows_[problem_.first[i]]]));
  solution.violation = std::max(largest(of_contact), largest(solution.gap(tie_rows_)));
  return solution;
}

// Fills p of contact; returns amplitudes of the motions N.
Vector StaticSystem::press(const Vector& g, const Vector& c, double most_way, Solution& solution) {
  Vector p = solution.p(contact_rows_), moved = Vector::Zero(N_.cols());
  if (p.size() == 0) return unheld_moves(c, N_, solution.largest_force, most_way);
  if (slides_ || !newton(g, c, most_way, solution.largest_force, p, moved) ||
      largest(times(N_, moved)) > most_way) {
    solution.fallback = true;
    p = solution.p(contact_rows_);
    moved = search(g, c, most_way, solution.largest_force, p);
  }
  solution.p(contact_rows_) = p;
  return moved;
}

// One Newton step for an active set: p = C x and the motions. Springs of `hold` act relative to the
// previous motions, so that they vanish at convergence.
StaticSystem::Step StaticSystem::step(const SetBases& bases, const Vector& g, const Vector& c,
                                      const Vector& moved, double hold) const {
  const Index n = bases.size(), nb = c.size();
  const Matrix B = contact_B_(bases.rows, Eigen::all);
  const double small = regular * problem_.diagonal.mean();
  Matrix A = Matrix::Zero(n + nb, n + nb);
  A.topLeftCorner(n, n) =
      bases.R.transpose() * Matrix(problem_.W.dense(bases.rows, bases.rows)) * bases.C;
  A.diagonal().head(n) += bases.alpha;
  A.diagonal().head(n).array() += small;
  A.topRightCorner(n, nb) = bases.R.transpose() * B;
  A.bottomLeftCorner(nb, n) = B.transpose() * bases.C;
  const double stiffness = nb > 0 ? hold / spring_ : 0;
  A.diagonal().tail(nb).array() -= stiffness;
  Vector b(n + nb);
  b << -(bases.R.transpose() * Vector(g(bases.rows))), -c - stiffness * moved;
  const Lu factor(std::move(A));
  Vector x = factor.solve(b);
  b << small * x.head(n), Vector::Zero(nb);
  x += factor.solve(b);
  Step step{Vector::Zero(g.size()), x.tail(nb)};
  step.p(bases.rows) = bases.C * x.head(n);
  return step;
}

// The smallest motions with the same gaps at closed points. With springs, round-off of the forces
// drifts into motions that no closed point resists. Such a drift would rotate faces, and grow with
// each load step.
Vector StaticSystem::without_drift(const SetBases& bases, const Vector& moved) const {
  if (moved.size() == 0 || bases.size() == 0) return moved;
  const Matrix B = bases.R.transpose() * Matrix(contact_B_(bases.rows, Eigen::all));
  if (B.isZero(0)) return Vector::Zero(moved.size());
  const Matrix A = B.transpose() * B;
  Matrix shifted = A;
  shifted.diagonal().array() += no_grip * A.diagonal().maxCoeff();
  const Cholesky factor(std::move(shifted));
  if (!factor.ok()) return moved;
  Vector least = Vector::Zero(moved.size());
  // A comes last: it removes round-off in motions that closed points do not resist
  for (int pass = 0; pass < 3; ++pass) least += A * factor.solve(Vector(moved - least));
  return least;
}

// Newton's method for laws and equilibrium together, from p and no motion. The step length reduces
// the violation of the laws.
bool StaticSystem::newton(const Vector& g, const Vector& c, double most_way, double force,
                          Vector& p, Vector& moved) const {
  constexpr int most = 40, longest_stay = 10;
  constexpr double aim = 1e-12, near = 1e3;
  constexpr double holds[] = {1e-5, 1e-2, 1};
  project(problem_, p);
  Vector gap = g + problem_.W.dense * p;
  // A solution that holds already stays the same, to the bit
  const auto tolerance_of = [&](const Vector& answer) {
    return aim * std::max(largest(g), largest(answer)) + gap_round_off(problem_, p);
  };
  if (largest(c + contact_B_.transpose() * p) <= balanced * acting_force(contact_B_, p, force) &&
      largest(law_violations(problem_, p, gap)) <= tolerance_of(gap - g))
    return true;
  double merit = HUGE_VAL, least = HUGE_VAL, before = HUGE_VAL, left_before = HUGE_VAL;
  for (int k = 0, stays = 0; k < most && stays < longest_stay; ++k) {
    // Counts points that touch within round-off as closed at first: signs of round-off are no
    // active set
    Vector seen = gap;
    if (k == 0)
      for (Index i = 0; i < problem_.n_points(); ++i)
        seen[problem_.first[i]] -= touching * most_way;
    const SetBases bases = set_bases(problem_, contact_set(problem_, p, seen));
    if (bases.size() == 0 && c.size() > 0) return false;
    Step to;
    for (const double next : holds) {
      to = step(bases, g, c, moved, next);
      if (to.p.allFinite() && largest(times(N_, to.moved)) <= most_way) break;
    }
    if (!to.p.allFinite()) return false;
    const Vector answer = problem_.W.dense * to.p, to_gap = g + answer + contact_B_ * to.moved,
                 left = c + contact_B_.transpose() * to.p;
    const double violation = largest(law_violations(problem_, to.p, to_gap)),
                 tolerance = tolerance_of(answer), acts = acting_force(contact_B_, to.p, force);
    const bool stands =
        violation <= tolerance || (violation <= near * tolerance && violation > 0.3 * before);
    const bool balances =
        largest(left) <= balanced * acts ||
        (largest(left) <= nearly_balanced * acts && largest(left) > 0.3 * left_before);
    before = violation;
    left_before = largest(left);
    if (stands && balances) {
      p = std::move(to.p);
      project(problem_, p);
      moved = without_drift(bases, to.moved);
      return true;
    }
    double best_t = 1, best = HUGE_VAL;
    for (double t = 1; t > (stays % 4 == 3 ? 0.5 : 0.01); t /= 2) {
      const double of =
          law_violations(problem_, p + t * (to.p - p), gap + t * (to_gap - gap)).norm();
      if (of < best) {
        best = of;
        best_t = t;
      }
      if (of <= merit) break;
    }
    merit = best;
    stays = best < 0.9 * least ? 0 : stays + 1;
    least = std::min(least, best);
    p += best_t * (to.p - p);
    gap += best_t * (to_gap - gap);
    moved += best_t * (to.moved - moved);
  }
  return false;
}

// Solves contact with springs on the motions, and releases them step by step.
Vector StaticSystem::search(const Vector& g, const Vector& c, double most_way, double force,
                            Vector& p) {
  const Matrix& B = contact_B_;
  Vector moved = Vector::Zero(B.cols());
  if (!sprung_) {
    GapResponse W = problem_.W;
    W.dense.noalias() += spring_ * B * B.transpose();
    sprung_ = contact_problem(std::move(W), contact_laws_);
  }
  // A new solver: state from other right-hand sides would make restarts differ in bits
  ContactSolver solver(sprung_->W, contact_laws_);
  double hold = least_hold, before = HUGE_VAL;
  Vector r_before;
  slides_ = false;
  for (int k = 0;; ++k) {
    const ContactSolution of_contact = solver.solve(g + B * (moved + spring_ * c), p);
    p = of_contact.p;
    const Vector r = c + B.transpose() * p, here = moved + spring_ * r;
    const double acts = acting_force(B, p, force);
    const bool is_far = largest(times(N_, moved)) >= (1 - 1e-9) * most_way;
    if (!(largest(r) > balanced * acts)) {
      slides_ = false;
      return without_drift(set_bases(*sprung_, contact_set(*sprung_, p, of_contact.gap)), here);
    }
    if (k == most_moves || (is_far && k > 0)) return here;
    slides_ = k > 0 && largest(r - r_before) <= unresisted * largest(r);
    r_before = r;
    if (slides_) {
      moved += r * ((most_way - largest(times(N_, moved))) / largest(times(N_, r)));
      continue;
    }
    hold = largest(r) > slow * before ? std::max(more_hold, 1e3 * hold)
                                      : std::max(least_hold, 1e-3 * hold);
    before = largest(r);
    moved =
        next_move(stiffness_of_contact(p, of_contact.gap), r, moved, most_way, std::min(hold, 1.0));
  }
}

// Derivative of the contact forces by the motions, B^T C (R^T W C + alpha)^-1 R^T B, with springs.
Matrix StaticSystem::stiffness_of_contact(const Vector& p, const Vector& gap) const {
  const SetBases bases = set_bases(*sprung_, contact_set(*sprung_, p, gap));
  const Index n = contact_B_.cols();
  if (bases.size() == 0) return Matrix::Zero(n, n);
  const Matrix B = contact_B_(bases.rows, Eigen::all);
  Matrix A = bases.R.transpose() * Matrix(sprung_->W.dense(bases.rows, bases.rows)) * bases.C;
  A.diagonal() += bases.alpha;
  A.diagonal().array() += regular * sprung_->diagonal.mean();
  return B.transpose() * (bases.C * Lu(std::move(A)).solve(Matrix(bases.R.transpose() * B)));
}

// Newton step with springs stiff enough to stay within most_way.
Vector StaticSystem::next_move(const Matrix& H, const Vector& r, const Vector& moved,
                               double most_way, double hold) const {
  const double stiffness = 1 / spring_;
  for (;; hold *= 10) {
    Matrix A = H;
    A.diagonal().array() += hold * stiffness;
    const Vector next = moved + Lu(std::move(A)).solve(r);
    const double way = largest(times(N_, next));
    if (way <= most_way) return next;
    if (hold > most_hold || !std::isfinite(way)) {
      const Vector straight = moved + r * (most_way / largest(times(N_, r)));
      return std::isfinite(way) ? Vector(next * (most_way / way)) : straight;
    }
  }
}

}  // namespace cbr

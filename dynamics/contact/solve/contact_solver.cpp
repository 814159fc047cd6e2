// SPDX-License-Identifier: GPL-3.0-or-later
// Newton first: with factors where there are few rows, with Krylov methods where there are many.
// What it does not solve goes to other methods, each bounded: without friction an active set that
// ends whatever W is, or projected gradients; with it sweeps, and friction that grows from a tenth
// to the whole; and Newton again from there.
#include "dynamics/contact/solve/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dynamics/contact/laws/keep_state.hpp"
#include "dynamics/contact/solve/basic_impulses.hpp"
#include "dynamics/contact/solve/block_gauss_seidel.hpp"
#include "dynamics/contact/solve/cone/cone_impulses.hpp"
#include "dynamics/contact/solve/newton/contact_newton.hpp"
#include "dynamics/contact/solve/newton/inexact_newton.hpp"
#include "dynamics/contact/solve/projected_gradients.hpp"

namespace cbr {
namespace {

// Shares of the largest |g|: what is aimed at, and what is good enough not to call for another
// method.
constexpr double aim = 1e-12, inexact_aim = 3e-12, enough = 1e-10;
// Of the active set that takes one point at a time, and up to how many of them.
constexpr double basic_aim = 1e-11;
constexpr Index basic_rows = 1500;
// Rows and rank up to which a singular W with friction is solved in the coordinates that it feels;
// what no other method betters then.
constexpr Index cone_rows = 6000, cone_rank = 600;
constexpr double enough_of_cones = 1e-6;
// Rows from which Krylov methods are faster than factors: docs/decisions/contact-solver.md.
constexpr Index krylov_rows = 128;
// Where a factor is still tried when Krylov methods fail, by rows (dense) or entries of W (sparse):
// seconds, not minutes, in all.
constexpr Index factor_rows = 4000, factor_entries = 1000000, lu_rows = 1500, lu_entries = 200000;
constexpr int newton_iterations = 30, retry_iterations = 12, gradient_products = 3000;
// Sweeps before Newton's first attempt from nothing, and the growing numbers of them after a failed
// one.
constexpr int first_sweeps = 20, first_retry = 60, most_sweeps = 540, growth_steps = 30;
// Of the proximal problems that find the least violation.
constexpr double ridge = 1e-6, margin = 1e-9;
constexpr int proximal_steps = 15;

bool has_friction(const ContactProblem& problem) {
  return std::any_of(problem.laws.begin(), problem.laws.end(),
                     [](const PointLaw& law) { return law.law == ContactLaw::coulomb; });
}

bool all_frictionless(const ContactProblem& problem) {
  return std::all_of(problem.laws.begin(), problem.laws.end(),
                     [](const PointLaw& law) { return law.law == ContactLaw::frictionless; });
}

LinearSolver first_choice(const ContactProblem& problem) {
  return problem.n_rows() > krylov_rows ? LinearSolver::krylov : LinearSolver::factor;
}

bool can_factor(const ContactProblem& problem) {
  const bool friction = has_friction(problem);
  if (problem.W.is_sparse)
    return problem.W.sparse.nonZeros() <= (friction ? lu_entries : factor_entries);
  return problem.n_rows() <= (friction ? lu_rows : factor_rows);
}

// The best so far; p within the laws' cones. None at first, which is what stays when magnitudes are
// beyond a double's reach.
struct Best {
  explicit Best(const Vector& g) : p(Vector::Zero(g.size())), gap(g) {}
  Vector p, gap;
  double residual = std::numeric_limits<double>::infinity();  // a length
  // a residual that calls for no other method
  double good = 0;
  int iterations = 0;

  bool done() const { return residual <= good; }
  void offer(const ContactProblem& problem, double scale, Vector new_p, Vector new_gap,
             double new_residual) {
    if (!(new_residual < residual)) return;
    good = std::min(enough * scale + gap_round_off(problem, new_p), 1e-8 * scale);
    p = std::move(new_p);
    gap = std::move(new_gap);
    residual = new_residual;
  }
};

// One problem: W and laws, and what can be kept between right-hand sides.
class Methods {
 public:
  explicit Methods(ContactProblem problem)
      : problem_(std::move(problem)), is_finite_(all_finite(problem_.W)) {}
  const ContactProblem& problem() const { return problem_; }
  bool friction() const { return has_friction(problem_); }
  bool is_finite() const { return is_finite_; }  // of W

  void newton(const Vector& g, const Vector& p, const Vector& gap, LinearSolver linear,
              int iterations, double scale, Best& best) {
    NewtonResult result = newton_.solve(problem_, g, p, gap, linear, iterations, aim * scale);
    best.iterations += result.iterations;
    best.offer(problem_, scale, std::move(result.p), std::move(result.gap), result.residual);
  }

  // Of a dense W with many rows: false when it does not solve it.
  bool inexact(const Vector& g, Vector p, Vector gap, double scale, const GapsOf& gaps_of,
               Best& best) {
    if (problem_.W.is_sparse || problem_.n_rows() <= krylov_rows) return false;
    go_on(g, p, gap);
    const GapsOf by_W = [&](const Vector& of, Vector& its) { its = g + respond(problem_, of); };
    NewtonResult result =
        inexact_.solve(problem_, g, std::move(p), std::move(gap), newton_iterations,
                       (friction() ? inexact_aim : aim) * scale, gaps_of ? gaps_of : by_W);
    best.iterations += result.iterations;
    best.offer(problem_, scale, std::move(result.p), std::move(result.gap), result.residual);
    if (best.done() && !friction())
      newton_.ends_with(problem_, contact_set(problem_, best.p, best.gap));
    return best.done();
  }

  // g + W p; of the last solution's impulses without a product.
  Vector gap_of(const Vector& g, const Vector& p) const {
    return is_last(p) ? Vector(g + last_.answer) : g + respond(problem_, p);
  }
  void remember(const Vector& g, const Vector& p, const Vector& gap) {
    before_ = std::move(last_);
    last_ = {p, gap - g};
  }

  // With what is factored for the last set.
  NewtonResult standing(const Vector& g, double scale, Best& best) {
    NewtonResult result = newton_.solve_standing(problem_, g, aim * scale);
    best.iterations += result.iterations;
    if (result.converged) best.offer(problem_, scale, result.p, result.gap, result.residual);
    return result;
  }

  bool standing_impulses(const Vector& g, Vector& p) {
    return newton_.standing_impulses(problem_, g, p);
  }

  void renumber(GapResponse W, std::vector<PointLaw> laws, const std::vector<Index>& from) {
    const std::vector<Index> first = problem_.first;
    problem_ = contact_problem(std::move(W), std::move(laws));
    is_finite_ = all_finite(problem_.W);
    std::vector<Index> rows(static_cast<std::size_t>(problem_.n_rows()), -1);
    for (std::size_t i = 0; i < from.size(); ++i)
      for (Index d = 0; from[i] >= 0 && d < n_rows(problem_.laws[i].law); ++d)
        rows[problem_.first[i] + d] = first[from[i]] + d;
    newton_.renumber(rows);
    inexact_.forget();
    last_ = before_ = Remembered();
    sweeps_.reset();
    cones_.reset();
    norm_ = 0;
  }

  // The rest follows from W and the laws, whenever it is asked for.
  void keep_state(StateArchive& archive) {
    archive(problem_.W, problem_.laws);
    if (archive.restores()) {
      problem_ = contact_problem(std::move(problem_.W), std::move(problem_.laws));
      is_finite_ = all_finite(problem_.W);
    }
    archive(basic_first_, cones_first_);
    newton_.keep_state(archive, problem_);
    inexact_.keep_state(archive, problem_);
    archive(last_.p, last_.answer, before_.p, before_.answer);
  }

  Index n_factored() const { return newton_.n_factored(); }

  // Newton with the share of all friction coefficients; p and gap are where to start from, and the
  // result when it converged.
  bool newton_with(double share, const Vector& g, double scale, Best& best, Vector& p,
                   Vector& gap) {
    const std::vector<PointLaw> laws = problem_.laws;
    for (PointLaw& law : problem_.laws) law.friction *= share;
    NewtonResult result =
        newton_.solve(problem_, g, p, gap, LinearSolver::factor, retry_iterations, aim * scale);
    problem_.laws = laws;
    best.iterations += result.iterations;
    if (!result.converged) return false;
    p = std::move(result.p);
    gap = std::move(result.gap);
    return true;
  }

  void sweep(const Vector& g, Vector p, int n, double scale, Best& best) {
    if (!sweeps_) sweeps_.emplace(problem_);
    Vector gap = g + respond(problem_, p);
    best.iterations += sweeps_->sweep(problem_, n, aim * scale, p, gap);
    gap = g + respond(problem_, p);
    const double residual = law_violations(problem_, p, gap).lpNorm<Eigen::Infinity>();
    best.offer(problem_, scale, std::move(p), std::move(gap), residual);
  }

  void gradients(const Vector& g, Vector p, double scale, Best& best) {
    if (!(norm_ > 0)) norm_ = scaled_norm(problem_);
    Vector gap = g + respond(problem_, p);
    best.iterations +=
        projected_gradients(problem_, g, norm_, gradient_products, aim * scale, p, gap);
    const double residual = law_violations(problem_, p, gap).lpNorm<Eigen::Infinity>();
    best.offer(problem_, scale, std::move(p), std::move(gap), residual);
  }

  // Of a dense W with friction: false when it is regular, too large, or the impulses are not good
  // enough.
  bool cones(const Vector& g, const Vector& guess, double scale, Best& best) {
    if (problem_.W.is_sparse || problem_.n_rows() > cone_rows) return false;
    if (!cones_) cones_ = cone_problem(problem_, std::min(cone_rank, problem_.n_rows() - 1));
    if (cones_->rank() == 0) return false;
    ConeImpulses found = cone_impulses(problem_, *cones_, g, guess, enough * scale);
    best.iterations += found.steps;
    const bool good = found.residual <= enough_of_cones * scale;
    cones_first_ = cones_first_ || good;  // one failure does not make W regular
    best.offer(problem_, scale, std::move(found.p), std::move(found.gap), found.residual);
    return good;
  }
  bool cones_first() const { return cones_first_; }
  bool singular_with_friction() const { return cones_ && cones_->rank() > 0; }
  void begin_as(const Methods& other) {
    basic_first_ = other.basic_first_;
    cones_first_ = other.cones_first_;
    inexact_.begin_as(other.inexact_);
  }

  bool basic_first() const {
    return basic_first_ && !problem_.W.is_sparse && all_frictionless(problem_);
  }
  // Of a dense W without friction or ties.
  void basic(const Vector& g, double scale, Best& best) {
    BasicImpulses basic = basic_impulses(problem_, g, basic_aim * scale);
    basic_first_ = basic.found && basic.singular;
    best.iterations += basic.steps;
    const double residual = law_violations(problem_, basic.p, basic.gap).lpNorm<Eigen::Infinity>();
    best.offer(problem_, scale, std::move(basic.p), std::move(basic.gap), residual);
  }

 private:
  bool is_last(const Vector& p) const { return p.size() == last_.p.size() && p == last_.p; }
  // From the last impulses as they have changed lately, where that violates the laws less.
  void go_on(const Vector& g, Vector& p, Vector& gap) const {
    if (before_.p.size() != p.size() || !is_last(p)) return;
    Vector next = 2 * last_.p - before_.p, next_gap = g + 2 * last_.answer - before_.answer;
    if (!(law_violations(problem_, next, next_gap).norm() <
          law_violations(problem_, p, gap).norm()))
      return;
    p = std::move(next);
    gap = std::move(next_gap);
  }

  ContactProblem problem_;
  bool is_finite_ = true;
  ContactNewton newton_;
  InexactNewton inexact_;
  struct Remembered {
    Vector p, answer;  // answer = W p
  };
  Remembered last_, before_;  // of the last solution, and of the one before it
  bool basic_first_ = false;  // it has solved what Newton's method did not
  bool cones_first_ = false;  // the same, with friction
  std::optional<ConeProblem> cones_;
  std::optional<BlockGaussSeidel> sweeps_;
  double norm_ = 0;  // of W scaled to a unit diagonal, once known
};

// Newton's first attempt, warm from `guess` or from a few sweeps, and with factors when Krylov
// methods fail.
void attempt(Methods& methods, const Vector& g, const Vector& guess, double scale,
             const GapsOf& gaps_of, Best& best) {
  const ContactProblem& problem = methods.problem();
  const NewtonResult standing = methods.standing(g, scale, best);
  if (standing.converged) return;
  // Newton's first step from the last set is made: the next one goes on from there
  const bool goes_on = standing.iterations > 0 && all_frictionless(problem);
  if (goes_on) {
    if (methods.inexact(g, standing.outside, standing.gap, scale, gaps_of, best)) return;
    methods.newton(g, standing.outside, standing.gap, first_choice(problem), newton_iterations,
                   scale, best);
    if (best.done()) return;
  }
  Best start(g);
  Vector p = guess.size() == g.size() ? guess : Vector::Zero(g.size());
  project(problem, p);
  const bool warm = !p.isZero(0);
  if (!goes_on && methods.inexact(g, p, warm ? methods.gap_of(g, p) : g, scale, gaps_of, best))
    return;
  if (!warm && methods.friction()) {
    methods.sweep(g, p, first_sweeps, scale, start);
  } else {
    Vector gap = warm ? methods.gap_of(g, p) : g;
    const double residual = law_violations(problem, p, gap).lpNorm<Eigen::Infinity>();
    start.offer(problem, scale, std::move(p), std::move(gap), residual);
  }
  best.iterations += start.iterations;
  const LinearSolver linear = first_choice(problem);
  // Newton's impulses are the least of those with the same gaps, the sweeps' are not
  if (!(warm && start.residual <= aim * scale))
    methods.newton(g, start.p, start.gap, linear, newton_iterations, scale, best);
  if (!best.done() && !start.done() && linear == LinearSolver::krylov && can_factor(problem))
    methods.newton(g, start.p, start.gap, LinearSolver::factor, newton_iterations, scale, best);
  if (!best.done())
    best.offer(problem, scale, std::move(start.p), std::move(start.gap), start.residual);
}

// Without friction the impulses minimise an energy: descend, then let Newton take the set that was
// found to round-off.
void descend(Methods& methods, const Vector& g, double scale, Best& best) {
  const ContactProblem& problem = methods.problem();
  if (all_frictionless(problem) && !problem.W.is_sparse && problem.n_rows() <= basic_rows)
    methods.basic(g, scale, best);
  if (best.done()) return;
  methods.gradients(g, Vector::Zero(g.size()), scale, best);
  if (best.done() || !can_factor(methods.problem())) return;
  const Best start = best;
  methods.newton(g, start.p, start.gap, LinearSolver::factor, newton_iterations, scale, best);
}

// Follows the solution while all friction grows from a tenth to the whole.
void let_friction_grow(Methods& methods, const Vector& g, double scale, Best& best) {
  Vector p = Vector::Zero(g.size()), gap = g;
  double share = 0, step = 0.1;
  for (int i = 0; i < growth_steps && share < 1 && step > 1e-3; ++i) {
    const double next = std::min(1.0, share + step);
    if (methods.newton_with(next, g, scale, best, p, gap)) {
      share = next;
      step *= 2;
    } else {
      step /= 2;
    }
  }
  if (!(share < 1)) {
    const double residual = law_violations(methods.problem(), p, gap).lpNorm<Eigen::Infinity>();
    best.offer(methods.problem(), scale, std::move(p), std::move(gap), residual);
  }
}

void sweep_and_attempt(Methods& methods, const Vector& g, double scale, Best& best) {
  const bool factor = can_factor(methods.problem()), singular = methods.singular_with_friction();
  // where Newton cycles, more sweeps do not help it
  const int most = singular ? first_retry : most_sweeps;
  for (int n = first_retry; n <= most && !best.done(); n *= 3) {
    methods.sweep(g, best.p, n, scale, best);
    if (best.done()) return;
    const Best start = best;
    methods.newton(g, start.p, start.gap, factor ? LinearSolver::factor : LinearSolver::krylov,
                   retry_iterations, scale, best);
    if (!best.done() && factor && !singular && n == first_retry)
      let_friction_grow(methods, g, scale, best);
  }
}

// No impulse satisfies all: the proximal point method (Rockafellar 1976, doi 10.1137/0314056) tends
// to the gaps that violate least (Chiche, Gilbert 2016), and with these forgiven the problem has a
// solution of a bounded size.
void forgive(Methods& methods, const Vector& g, double scale, Best& best) {
  ContactProblem shifted = methods.problem();
  const Vector epsilon = ridge * shifted.diagonal;
  if (shifted.W.is_sparse) {
    for (Index i = 0; i < epsilon.size(); ++i)
      if (epsilon[i] > 0) shifted.W.sparse.coeffRef(i, i) += epsilon[i];
  } else {
    shifted.W.dense.diagonal() += epsilon;
  }
  Methods proximal(contact_problem(std::move(shifted.W), shifted.laws));
  Vector p = Vector::Zero(g.size()), gap = g;
  double moved = scale;
  for (int i = 0; i < proximal_steps && moved > aim * scale; ++i) {
    Best step(g);
    attempt(proximal, g - epsilon.cwiseProduct(p), p, scale, {}, step);
    best.iterations += step.iterations;
    p = std::move(step.p);
    const Vector next = g + respond(methods.problem(), p);
    moved = (next - gap).lpNorm<Eigen::Infinity>();
    gap = next;
  }
  Vector forgiven = g;
  Index row = 0;
  for (const PointLaw& law : shifted.laws) {
    for (Index d = 0; d < n_rows(law.law); ++d, ++row)
      if (law.law == ContactLaw::tied || gap[row] < 0)
        forgiven[row] -= gap[row] - (law.law == ContactLaw::tied ? 0.0 : margin * scale);
  }
  Best bounded(forgiven);
  attempt(methods, forgiven, Vector(), scale, {}, bounded);
  if (!bounded.done()) descend(methods, forgiven, scale, bounded);
  Vector bounded_gap = g + respond(methods.problem(), bounded.p);
  const double residual =
      law_violations(methods.problem(), bounded.p, bounded_gap).lpNorm<Eigen::Infinity>();
  // A somewhat smaller violation that takes huge impulses in opposite directions is no better
  if (residual <= 4 * best.residual || !(best.p.norm() < 1e4 * bounded.p.norm())) {
    best.p = std::move(bounded.p);
    best.gap = std::move(bounded_gap);
    best.residual = residual;
  }
}

}  // namespace

struct ContactSolver::Impl {
  Methods methods;
};

ContactSolver::ContactSolver(GapResponse W, std::vector<PointLaw> laws)
    : impl_(std::make_unique<Impl>(Impl{Methods(contact_problem(std::move(W), std::move(laws)))})) {
}
ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&&) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&&) noexcept = default;

const GapResponse& ContactSolver::W() const { return impl_->methods.problem().W; }

bool ContactSolver::standing_impulses(const Vector& g, Vector& p) {
  Methods& methods = impl_->methods;
  return methods.is_finite() && g.allFinite() && methods.standing_impulses(g, p);
}

double ContactSolver::largest_violation(const Vector& p, const Vector& gap) const {
  return p.size() > 0 ? law_violations(impl_->methods.problem(), p, gap).lpNorm<Eigen::Infinity>()
                      : 0;
}

void ContactSolver::renumber(GapResponse W, std::vector<PointLaw> laws,
                             const std::vector<Index>& from) {
  impl_->methods.renumber(std::move(W), std::move(laws), from);
}

void ContactSolver::keep_state(StateArchive& archive) { impl_->methods.keep_state(archive); }

bool ContactSolver::W_is_singular() const {
  return impl_->methods.cones_first() || impl_->methods.basic_first();
}

void ContactSolver::begin_as(const ContactSolver& other) {
  impl_->methods.begin_as(other.impl_->methods);
}

Index ContactSolver::n_factored() const { return impl_->methods.n_factored(); }

ContactSolution ContactSolver::solve(const Vector& g, const Vector& guess, Effort effort,
                                     const GapsOf& gaps_of) {
  Methods& methods = impl_->methods;
  const double scale = g.size() > 0 ? g.lpNorm<Eigen::Infinity>() : 0;
  const Vector none = Vector::Zero(g.size());
  // Of the bodies' motion, or of magnitudes beyond a double's reach: the loop will say so
  const ContactSolution not_finite{none, g, std::numeric_limits<double>::infinity()};
  if (!g.allFinite() || !methods.is_finite()) return not_finite;
  if (!(scale > 0) || law_violations(methods.problem(), none, g).isZero(0)) return {none, g};
  Best best(g);
  if (methods.basic_first()) methods.basic(g, scale, best);
  const bool cones_first = methods.cones_first();
  const bool good = cones_first && methods.cones(g, guess, scale, best);
  if (!best.done() && !good) attempt(methods, g, guess, scale, gaps_of, best);
  ContactSolution solution;
  if (!best.done() && !good) {
    solution.fallback = true;
    if (effort == Effort::all && methods.friction()) {
      if (cones_first || !methods.cones(g, guess, scale, best))
        sweep_and_attempt(methods, g, scale, best);
    } else if (effort == Effort::all) {
      descend(methods, g, scale, best);
      if (best.residual > 1e-7 * scale) forgive(methods, g, scale, best);
    }
  }
  if (!std::isfinite(best.residual) || !best.p.allFinite() || !best.gap.allFinite())
    return not_finite;
  methods.remember(g, best.p, best.gap);
  solution.p = std::move(best.p);
  solution.gap = std::move(best.gap);
  solution.residual = best.residual / scale;
  solution.iterations = best.iterations;
  return solution;
}

}  // namespace cbr

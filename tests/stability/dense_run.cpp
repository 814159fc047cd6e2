// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_run.hpp"

#include <algorithm>
#include <cmath>

#include "common/linalg/dense.hpp"
#include "tests/stability/dense_laws.hpp"

namespace cbr::test {
namespace {

// The points of one search, and what it remembers.
struct Search {
  std::size_t pair = 0;
  const DenseSurface* slave = nullptr;
  double master_size = 0;
  DenseMemory* memory = nullptr;
  std::size_t first = 0, last = 0;
};

// Points that are solved together. Rows of all, one after the other: one a point where mu is 0,
// else three.
struct Group {
  std::vector<Search> searches;
  std::vector<DensePoint> points;
  std::vector<double> mu;
};

class Run {
 public:
  Run(const std::vector<DenseBody>& bodies, const std::vector<DensePair>& pairs, double h)
      : pairs_(pairs), h_(h) {
    for (const DenseBody& body : bodies) steppers_.emplace_back(body, h);
    memory_.resize(pairs.size());
    back_.resize(pairs.size());
    springs_.resize(pairs.size());
    motion_.bodies.resize(bodies.size());
    motion_.n_pushes.assign(pairs.size(), 0);
    begin_output();
    record();
  }

  void step() {
    for (DenseStepper& body : steppers_) body.predict();
    // Springs know the start of the step only; impulses see what springs do to its end
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      if (pairs_[p].penalty) step_springs(p);
    step_impulses();
    finish_springs();
    for (DenseStepper& body : steppers_) body.accept();
    initial_ = false;
    for (const DensePair& pair : pairs_) {
      if (pair.penalty || !pair.master) continue;
      motion_.depth = std::max(motion_.depth, dense_depth(pair.slave, path(pair.slave),
                                                          *pair.master, path(*pair.master)));
    }
  }

  void begin_output() {
    impulse_.clear();
    for (const DenseStepper& body : steppers_)
      impulse_.push_back(Points::Zero(body.end().rows(), 3));
  }
  void record() {
    for (std::size_t b = 0; b < steppers_.size(); ++b) {
      motion_.bodies[b].x.push_back(steppers_[b].end());
      motion_.bodies[b].impulse.push_back(impulse_[b]);
    }
  }
  DenseMotion& motion() { return motion_; }

 private:
  struct Springs {
    double k = 0, c = 0;
    std::size_t n_seen = 0;
  };

  struct PushedSprings {
    Group group;
    Vector gap_without_motion, p;
    std::vector<Vector3> kept;  // see step_springs
  };

  DensePath path(const DenseSurface& s) const {
    const DenseStepper& body = steppers_[s.body];
    return {body.start(), body.end()};
  }

  void search(std::size_t p, Group& group) {
    const DensePair& pair = pairs_[p];
    if (!pair.master) {
      const auto points =
          dense_wall_points(pair.slave, pair.wall, path(pair.slave), initial_, memory_[p]);
      return add(group, {p, &pair.slave, pair.slave.size, &memory_[p], 0, 0}, points,
                 pair.friction);
    }
    const auto add_nodes_of = [&](const DenseSurface& slave, const DenseSurface& master,
                                  DenseMemory& memory) {
      const auto points =
          dense_face_points(slave, path(slave), master, path(master), initial_, memory);
      add(group, {p, &slave, pair.master->size, &memory, 0, 0}, points, pair.friction);
    };
    add_nodes_of(pair.slave, *pair.master, memory_[p]);
    if (pair.two_way) add_nodes_of(*pair.master, pair.slave, back_[p]);
  }

  static void add(Group& group, Search search, const std::vector<DensePoint>& points, double mu) {
    search.first = group.points.size();
    group.points.insert(group.points.end(), points.begin(), points.end());
    search.last = group.points.size();
    group.mu.resize(group.points.size(), mu);
    group.searches.push_back(search);
  }

  // Rows of the points to displacements of a body's visible dofs.
  Matrix rows_of(const Group& group, Index body) const {
    const Index n = 3 * steppers_[body].end().rows();
    Matrix G = Matrix::Zero(n_rows(group), n);
    Index row = 0;
    for (std::size_t i = 0; i < group.points.size(); ++i) {
      const Index n_of = group.mu[i] > 0 ? 3 : 1;
      for (const DensePoint::Term& term : group.points[i].terms)
        if (term.body == body)
          G.block(row, 3 * term.node, n_of, 3) += term.weight * group.points[i].frame.topRows(n_of);
      row += n_of;
    }
    return G;
  }
  static Index n_rows(const Group& group) {
    Index n = 0;
    for (const double mu : group.mu) n += mu > 0 ? 3 : 1;
    return n;
  }

  Matrix response(const Group& group) const {
    Matrix W = Matrix::Zero(n_rows(group), n_rows(group));
    for (std::size_t b = 0; b < steppers_.size(); ++b) {
      const Matrix G = rows_of(group, static_cast<Index>(b));
      W += G * steppers_[b].response() * G.transpose();
    }
    return W;
  }

  // Of the point's terms, end - start.
  Vector3 slip(const DensePoint& point) const {
    Vector3 s = Vector3::Zero();
    for (const DensePoint::Term& term : point.terms) {
      const DenseStepper& body = steppers_[term.body];
      s += term.weight * (body.end().row(term.node) - body.start().row(term.node)).transpose();
    }
    return s;
  }

  void push(const Group& group, const Vector& p, bool velocities = false) {
    for (std::size_t b = 0; b < steppers_.size(); ++b) {
      const Vector impulse = rows_of(group, static_cast<Index>(b)).transpose() * p;
      if (impulse.isZero(0)) continue;
      velocities ? steppers_[b].push_velocities(impulse) : steppers_[b].push(impulse);
      impulse_[b] += impulse.reshaped<Eigen::RowMajor>(impulse_[b].rows(), 3);
    }
  }

  // gap_n and p_n by point.
  void remember(const Group& group, const Vector& gap, const Vector& p) {
    std::vector<double> gaps, pushes;
    Index row = 0;
    for (const double mu : group.mu) {
      gaps.push_back(gap[row]);
      pushes.push_back(p[row]);
      row += mu > 0 ? 3 : 1;
    }
    for (const Search& s : group.searches) {
      const auto part = [&](const auto& all) {
        return std::vector(all.begin() + static_cast<std::ptrdiff_t>(s.first),
                           all.begin() + static_cast<std::ptrdiff_t>(s.last));
      };
      const std::vector<double> p_n = part(pushes);
      dense_remember(*s.slave, part(group.points), part(gaps), p_n, s.master_size, *s.memory);
      motion_.n_pushes[s.pair] +=
          std::count_if(p_n.begin(), p_n.end(), [](double of) { return of > 0; });
    }
  }

  // Gaps without the impulses of the group: normal ones, and slips over the step.
  Vector free_gaps(const Group& group) const {
    Vector g(n_rows(group));
    Index row = 0;
    for (std::size_t i = 0; i < group.points.size(); ++i) {
      const DensePoint& point = group.points[i];
      g[row++] = point.gap;
      if (group.mu[i] == 0) continue;
      g.segment<2>(row) = point.frame.bottomRows<2>() * slip(point);
      row += 2;
    }
    return g;
  }

  Vector solve(const Matrix& W, const Vector& g, const std::vector<double>& mu) {
    const DenseImpulses found = dense_impulses(W, g, mu);
    // Newmark settles the velocities of those points that press, and no others
    const bool newmark = std::any_of(steppers_.begin(), steppers_.end(),
                                     [](const DenseStepper& b) { return b.is_newmark(); });
    motion_.is_unique = motion_.is_unique && !(newmark ? found.several : found.several_motions);
    return found.p;
  }

  void step_impulses() {
    Group group;
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      if (!pairs_[p].penalty) search(p, group);
    if (group.points.empty()) return remember(group, {}, {});
    const Matrix W = response(group);
    const Vector g = free_gaps(group);
    const Vector p = solve(W, g, group.mu);
    push(group, p);
    const Vector settled = settle(group, p);
    remember(group, g + W * p, settled);
  }

  // Newmark: of the points with an impulse, the total one for which the laws hold with velocities
  // in the place of gaps: docs/theory.md, (38).
  Vector settle(const Group& group, const Vector& p) {
    if (!std::any_of(steppers_.begin(), steppers_.end(),
                     [](const DenseStepper& b) { return b.is_newmark(); }))
      return p;
    Group closed;
    std::vector<Index> rows;
    Index row = 0;
    for (std::size_t i = 0; i < group.points.size(); ++i) {
      const Index n = group.mu[i] > 0 ? 3 : 1;
      if (p[row] > 0) {
        closed.points.push_back(group.points[i]);
        closed.mu.push_back(group.mu[i]);
        for (Index d = 0; d < n; ++d) rows.push_back(row + d);
      }
      row += n;
    }
    if (rows.empty()) return p;
    Matrix W = Matrix::Zero(n_rows(closed), n_rows(closed));
    Vector v = Vector::Zero(n_rows(closed));
    for (std::size_t b = 0; b < steppers_.size(); ++b) {
      const Matrix G = rows_of(closed, static_cast<Index>(b));
      W += G * steppers_[b].velocity_response() * G.transpose();
      v += G * steppers_[b].end_velocity();
    }
    const Vector before = p(rows), total = solve(W, v - W * before, closed.mu);
    push(closed, total - before, true);
    Vector all = p;
    all(rows) = total;
    return all;
  }

  // The step bears s of s + 4 zeta sqrt(s) = 0.2 (4 - x^2), x = omega_max h, s = k h lambda_max(W).
  void fit_springs(const Group& group, double zeta, Springs& springs) {
    if (group.points.size() <= springs.n_seen) return;
    springs.n_seen = group.points.size();
    double omega = 0;
    for (const DensePoint& point : group.points)
      for (const DensePoint::Term& term : point.terms)
        omega = std::max(omega, steppers_[term.body].largest_frequency());
    const double x = omega * h_, root = -2 * zeta + std::sqrt(4 * zeta * zeta + 0.2 * (4 - x * x));
    const double lambda = symmetric_eigenvalues(response(group)).maxCoeff();
    const double k = root * root / (h_ * lambda);
    springs.k = springs.k > 0 ? std::min(springs.k, k) : k;
    springs.c = 2 * zeta * std::sqrt(springs.k * h_ / lambda);
  }

  void step_springs(std::size_t pair) {
    Group group;
    search(pair, group);
    if (group.points.empty()) return remember(group, {}, {});
    Springs& springs = springs_[pair];
    fit_springs(group, pairs_[pair].damping, springs);
    const Vector g = free_gaps(group);
    Vector p = Vector::Zero(g.size());
    // stretch of the tangential springs, without what this step adds to it
    std::vector<Vector3> kept;
    Index row = 0;
    for (const Search& s : group.searches)
      for (std::size_t i = s.first; i < s.last; ++i) {
        const DensePoint& point = group.points[i];
        if (point.start_gap < 0)
          p[row] = h_ * std::max(0.0, -springs.k * point.start_gap -
                                          springs.c * (point.gap - point.start_gap) / h_);
        kept.push_back(Vector3::Zero());
        if (group.mu[i] == 0) {
          ++row;
          continue;
        }
        const Vector3 n = point.frame.row(0).transpose(), motion = slip(point);
        Vector3 stretch = s.memory->stretch.row(point.slot).transpose() + motion;
        stretch -= n.dot(stretch) * n;
        const double most = group.mu[i] * p[row] / (springs.k * h_);
        if (stretch.norm() > most) stretch *= most / stretch.norm();
        p.segment<2>(row + 1) = -springs.k * h_ * (point.frame.bottomRows<2>() * stretch);
        kept.back() = stretch - (motion - n.dot(motion) * n);
        row += 3;
      }
    const Vector motion = normal_motions(group);
    push(group, p);
    pushed_.push_back({std::move(group), g - motion, p, std::move(kept)});
  }

  // By the gaps and slips with all that has acted in the step.
  void finish_springs() {
    for (const PushedSprings& springs : pushed_) {
      const Group& group = springs.group;
      remember(group, springs.gap_without_motion + normal_motions(group), springs.p);
      Index row = 0;
      for (const Search& s : group.searches) {
        s.memory->stretch.setZero();
        for (std::size_t i = s.first; i < s.last; ++i) {
          const Vector3 n = group.points[i].frame.row(0).transpose(),
                        motion = slip(group.points[i]);
          if (group.mu[i] > 0 && springs.p[row] > 0)
            s.memory->stretch.row(group.points[i].slot) =
                (springs.kept[i] + motion - n.dot(motion) * n).transpose();
          row += group.mu[i] > 0 ? 3 : 1;
        }
      }
    }
    pushed_.clear();
  }

  // In the rows of the gaps; 0 in those of slips.
  Vector normal_motions(const Group& group) const {
    Vector motion = Vector::Zero(n_rows(group));
    Index row = 0;
    for (std::size_t i = 0; i < group.points.size(); ++i) {
      motion[row] = group.points[i].frame.row(0).dot(slip(group.points[i]));
      row += group.mu[i] > 0 ? 3 : 1;
    }
    return motion;
  }

  const std::vector<DensePair>& pairs_;
  double h_;
  bool initial_ = true;
  std::vector<DenseStepper> steppers_;
  std::vector<DenseMemory> memory_, back_;
  std::vector<Springs> springs_;
  std::vector<PushedSprings> pushed_;
  std::vector<Points> impulse_;
  DenseMotion motion_;
};

}  // namespace

DenseMotion dense_motion(const std::vector<DenseBody>& bodies, const std::vector<DensePair>& pairs,
                         double h, Index n_outputs, Index steps_per_output) {
  Run run(bodies, pairs, h);
  for (Index output = 1; output < n_outputs; ++output) {
    run.begin_output();
    for (Index i = 0; i < steps_per_output; ++i) {
      run.step();
      // what follows is one of several
      if (!run.motion().is_unique) return std::move(run.motion());
    }
    run.record();
  }
  return std::move(run.motion());
}

}  // namespace cbr::test

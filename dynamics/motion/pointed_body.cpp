// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/pointed_body.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/files/state_archive.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// [a]x b = a x b
Matrix3 cross(const Vector3& a) {
  Matrix3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

Vector flat(const Points& x) { return Eigen::Map<const Vector>(x.data(), x.size()); }

Points table(const Vector& x) { return Eigen::Map<const Points>(x.data(), x.size() / 3, 3); }

// Of the largest moment of inertia: less is none.
constexpr double thin = 1e-10;

// The same where nodes have rotations: arms of less than a hundredth of the length would need
// forces that are large beside the moment.
constexpr double slender = 1e-4;

// d = U + theta x (at - x), theta: of the node at x.
AverageMaps maps_of_interface(const AveragePoint& point, const Points& positions) {
  const Matrix3 arm = cross(point.at - positions.row(point.nodes[0]).transpose());
  const Matrix3 turned = point.hand * Matrix3::Identity();
  return {{Matrix3::Identity(), -arm * turned}, {Matrix3::Zero(), turned}};
}

}  // namespace

Matrix3 rotation_of(const Vector3& theta) {
  const double angle = theta.norm();
  return angle == 0 ? Matrix3::Identity()
                    : Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix();
}

namespace {

// What a point's nodes are about their centre.
struct Spread {
  Vector w;  // sum 1
  Vector3 center = Vector3::Zero();
  std::vector<Vector3> r;
  Matrix3 J = Matrix3::Zero();
};

Spread spread_of(const AveragePoint& point, const Points& positions) {
  Spread of;
  const Index n = static_cast<Index>(point.nodes.size()) - point.n_rotations;
  of.w = point.weights.head(n) / point.weights.head(n).sum();
  for (Index i = 0; i < n; ++i) of.center += of.w[i] * positions.row(point.nodes[i]).transpose();
  for (Index i = 0; i < n; ++i) {
    of.r.push_back(positions.row(point.nodes[i]).transpose() - of.center);
    const Vector3& r = of.r.back();
    of.J += of.w[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  return of;
}

// Of J, the inverse over the axes about which the nodes have arms; the others.
struct Turns {
  Matrix3 inverse = Matrix3::Zero(), without_arm = Matrix3::Zero();
};

Turns turns_of(const Spread& spread, double least) {
  const double scale = spread.center.norm();
  const SymmetricEigen3 axes = symmetric_eigen3(spread.J);
  // Of one node J is the round-off of its place
  const double largest = axes.values.maxCoeff();
  Turns turns;
  for (Index k = 0; k < 3; ++k) {
    const Vector3 axis = axes.vectors.col(k);
    const bool has_arm = largest > thin * thin * scale * scale && axes.values[k] > least * largest;
    if (has_arm) turns.inverse += axis * axis.transpose() / axes.values[k];
    if (!has_arm) turns.without_arm += axis * axis.transpose();
  }
  return turns;
}

}  // namespace

bool lie_on_a_line(const AveragePoint& point, const Points& positions) {
  if (point.is_of_interface) return false;
  const Spread spread = spread_of(point, positions);
  return !turns_of(spread, slender).without_arm.isZero(0);
}

AverageMaps average_maps(const AveragePoint& point, const Points& positions,
                         const std::string& where) {
  if (point.is_of_interface) return maps_of_interface(point, positions);
  const Spread spread = spread_of(point, positions);
  const Turns turns = turns_of(spread, point.n_rotations > 0 ? slender : thin);
  if (!turns.without_arm.isZero(0) && point.n_rotations == 0)
    throw InputError(
        where +
        ": its nodes lie on a line, or are one, and determine no rotation: take a surface, "
        "or nodes of shells that keep their rotations");
  AverageMaps maps;
  const Matrix3 arm = cross(point.at - spread.center);
  const Index n = spread.w.size();
  for (Index i = 0; i < n; ++i) {
    maps.theta.push_back(spread.w[i] * turns.inverse * cross(spread.r[i]));
    maps.d.push_back(spread.w[i] * Matrix3::Identity() - arm * maps.theta.back());
  }
  const Vector of_rotations = point.weights.tail(point.n_rotations);
  for (const double w : of_rotations) {
    maps.theta.push_back(point.hand * w / of_rotations.sum() * turns.without_arm);
    maps.d.push_back(-arm * maps.theta.back());
  }
  return maps;
}

Matrix deformation_rows(const AveragePoint& point, const Points& positions) {
  const auto k = static_cast<Index>(point.nodes.size());
  Matrix rigid = Matrix::Zero(6, 3 * k);
  double size = 0;
  for (Index i = 0; i < k; ++i)
    size = std::max(size, (positions.row(point.nodes[i]).transpose() - point.at).norm());
  for (Index i = 0; i < k; ++i) {
    rigid.block<3, 3>(0, 3 * i).setIdentity();
    rigid.block<3, 3>(3, 3 * i) =
        cross((positions.row(point.nodes[i]).transpose() - point.at) / size);
  }
  return null_space(rigid, thin).transpose();
}

PointedBody::PointedBody(std::unique_ptr<Body> inner, std::vector<AveragePoint> points,
                         const std::string& where)
    : WrappedBody(std::move(inner)), points_(std::move(points)) {
  const Points& X = inner_->reference_positions();
  n_ = X.rows();
  arms_.assign(points_.size(), Vector3::Zero());
  for (std::size_t j = 0; j < points_.size(); ++j) {
    maps_.push_back(average_maps(points_[j], X, where));
    if (points_[j].rigid) add_deformations(j, where);
  }
  const auto n_points = static_cast<Index>(points_.size());
  Points all(n_ + 2 * n_points + static_cast<Index>(deformations_.size()), 3);
  all.topRows(n_) = X;
  for (Index i = n_; i < all.rows(); ++i) {
    const Index k = i - n_ - 2 * n_points;
    all.row(i) = points_[k < 0 ? static_cast<std::size_t>((i - n_) / 2)
                               : deformations_[static_cast<std::size_t>(k)].point]
                     .at.transpose();
  }
  facts_.positions = std::make_shared<const Points>(std::move(all));
}

void PointedBody::add_deformations(std::size_t point, const std::string& where) {
  constexpr std::size_t most_nodes = 1000;  // every row is of all nodes
  const std::size_t k = points_[point].nodes.size();
  if (points_[point].n_rotations > 0)
    throw InputError(where +
                     ": coupling: rigid needs nodes that do not lie on a line: take "
                     "coupling: average, or a surface");
  if (k > most_nodes)
    throw InputError(where + ": coupling: rigid of " + std::to_string(k) + " nodes, at most " +
                     std::to_string(most_nodes) +
                     " can be: take a smaller set, or coupling: average");
  const Matrix Z = deformation_rows(points_[point], inner_->reference_positions());
  for (Index i = 0; i + 3 <= Z.rows(); i += 3) {
    Extra extra{point, {}};
    for (Index node = 0; node < static_cast<Index>(k); ++node)
      extra.maps.push_back(Z.block<3, 3>(i, 3 * node));
    deformations_.push_back(std::move(extra));
  }
}

std::vector<Index> PointedBody::deformation_nodes(Index point) const {
  std::vector<Index> nodes;
  for (std::size_t i = 0; i < deformations_.size(); ++i)
    if (static_cast<Index>(deformations_[i].point) == point)
      nodes.push_back(n_ + 2 * static_cast<Index>(points_.size()) + static_cast<Index>(i));
  return nodes;
}

// Of a node behind those of the inner body.
const std::vector<Matrix3>& PointedBody::maps_of(Index node, std::size_t& point) const {
  const auto k = static_cast<std::size_t>(node - n_);
  if (k >= 2 * points_.size()) {
    const Extra& extra = deformations_[k - 2 * points_.size()];
    point = extra.point;
    return extra.maps;
  }
  point = k / 2;
  return k % 2 == 0 ? maps_[point].d : maps_[point].theta;
}

Index PointedBody::track(const std::vector<Index>& nodes) {
  NodeSet set;
  const auto first_point = std::lower_bound(nodes.begin(), nodes.end(), n_);
  std::vector<Index> inner(nodes.begin(), first_point);
  if (first_point == nodes.end()) {
    set.inner = inner_->track(nodes);
    sets_.push_back(std::move(set));
    return static_cast<Index>(sets_.size()) - 1;
  }
  for (auto it = first_point; it != nodes.end(); ++it) {
    std::size_t point = 0;
    maps_of(*it, point);
    const auto& of = points_[point].nodes;
    inner.insert(inner.end(), of.begin(), of.end());
  }
  std::sort(inner.begin(), inner.end());
  inner.erase(std::unique(inner.begin(), inner.end()), inner.end());
  std::vector<Index> all = nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < n_ || !takes_force(nodes[i])) continue;
    const auto point = static_cast<std::size_t>((nodes[i] - n_) / 2);
    if (!points_[point].slides) continue;
    set.slides.push_back({static_cast<Index>(i), static_cast<Index>(all.size()), point});
    all.push_back(nodes[i] + 1);
  }
  set.nodes = all;
  set.n_nodes = static_cast<Index>(nodes.size());
  std::vector<Eigen::Triplet<double, Index>> entries;
  const auto add = [&](Index row, Index node, const Matrix3& map) {
    const Index at = std::lower_bound(inner.begin(), inner.end(), node) - inner.begin();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        if (map(a, b) != 0) entries.emplace_back(3 * row + a, 3 * at + b, map(a, b));
  };
  for (Index i = 0; i < static_cast<Index>(all.size()); ++i) {
    if (all[i] < n_) {
      add(i, all[i], Matrix3::Identity());
      continue;
    }
    std::size_t j = 0;
    const auto& maps = maps_of(all[i], j);
    for (std::size_t k = 0; k < points_[j].nodes.size(); ++k) add(i, points_[j].nodes[k], maps[k]);
  }
  set.E.resize(3 * static_cast<Index>(all.size()), 3 * static_cast<Index>(inner.size()));
  set.E.setFromTriplets(entries.begin(), entries.end());
  set.X = reference_positions()(all, Eigen::all);
  set.X_inner = reference_positions()(inner, Eigen::all);
  set.inner = inner_->track(inner);
  sets_.push_back(std::move(set));
  return static_cast<Index>(sets_.size()) - 1;
}

void PointedBody::extend(const NodeSet& set, const Points& inner, Points& x) const {
  x = set.X + table(set.E * flat(inner - set.X_inner));
  for (const NodeSet::Slide& slide : set.slides) {
    const Vector3 theta = x.row(slide.rotation) - set.X.row(slide.rotation);
    x.row(slide.row) += (arms_[slide.point] + theta.cross(arms_[slide.point])).transpose();
  }
  x.conservativeResize(set.n_nodes, 3);
}

// Places turn about the body's centre, rotations and deformations about where they are.
void PointedBody::extend_turned(const NodeSet& set, const Points& inner, const BodyTurn& turn,
                                Points& x) const {
  extend(set, inner, x);
  if (turn.R == Matrix3::Identity()) return;
  for (Index i = 0; i < x.rows(); ++i) {
    const Vector3 about = takes_force(set.nodes[static_cast<std::size_t>(i)])
                              ? turn.center
                              : Vector3(set.X.row(i).transpose());
    x.row(i) = (about + turn.R * (x.row(i).transpose() - about)).transpose();
  }
}

// Impulses in axes that turn with the body, m x 3.
Points PointedBody::spread(const NodeSet& set, const Points& forces) const {
  if (set.slides.empty()) return table(set.E.transpose() * flat(forces));
  Points all = Points::Zero(set.X.rows(), 3);
  all.topRows(set.n_nodes) = forces;
  for (const NodeSet::Slide& slide : set.slides)
    all.row(slide.rotation) =
        arms_[slide.point].cross(Vector3(forces.row(slide.row).transpose())).transpose();
  return table(set.E.transpose() * flat(all));
}

// Of impulses on the set, what the spread ones leave of their moment: a body takes those where its
// nodes are now, and their shares are those of the middle of the step.
Vector3 PointedBody::missing_moment(const NodeSet& set, const Points& impulses,
                                    const Points& nodal) const {
  Points inner, x;
  turned()->unturned_positions(set.inner, inner);
  const BodyTurn turn = turned()->turn_now();
  extend_turned(set, inner, turn, x);
  Vector3 moment = Vector3::Zero();
  for (Index i = 0; i < x.rows(); ++i) {
    const Index node = set.nodes[static_cast<std::size_t>(i)];
    const Vector3 P = impulses.row(i).transpose();
    if (takes_force(node)) {
      moment += Vector3(x.row(i).transpose() - turn.center).cross(P);
    } else if (node < n_ + 2 * static_cast<Index>(points_.size())) {
      moment += P;
    }
  }
  for (Index i = 0; i < inner.rows(); ++i)
    moment -= (turn.R * (inner.row(i).transpose() - turn.center))
                  .cross(Vector3(nodal.row(i).transpose()));
  return moment;
}

// A place that slides moves as its point and by the rotation, times the arm.
Matrix PointedBody::slid(const NodeSet& set, const Matrix& S) const {
  Matrix A = Matrix::Identity(3 * set.n_nodes, S.rows());
  for (const NodeSet::Slide& slide : set.slides)
    A.block<3, 3>(3 * slide.row, 3 * slide.rotation) = -cross(arms_[slide.point]);
  return A * S * A.transpose();
}

// The block stays, and turns with the body.
NodeResponse PointedBody::turned_response(const NodeSet& set, double h) const {
  NodeResponse response;
  response.axes = turned()->turn_of_step();
  if (!set.answer || set.answer_h != h) {
    // Not of a body that has turned: the same to the last bit after a restart
    const Matrix half = set.E * turned()->unturned_response(set.inner, h).dense();
    const Matrix S = half * set.E.transpose();
    set.answer = std::make_shared<const Matrix>(0.5 * (S + S.transpose()));
    set.answer_h = h;
  }
  response.block =
      set.slides.empty() ? set.answer : std::make_shared<const Matrix>(slid(set, *set.answer));
  return response;
}

NodeResponse PointedBody::extended(const NodeSet& set, const NodeResponse& inner) const {
  NodeResponse response;
  const Matrix half = set.E * inner.dense();
  Matrix S = half * set.E.transpose();
  if (!set.slides.empty()) S = slid(set, S);
  response.set_block(0.5 * (S + S.transpose()));
  return response;
}

void PointedBody::positions(Index set, Points& x) const {
  if (is_plain(set)) return inner_->positions(sets_[set].inner, x);
  Points inner;
  if (turned() != nullptr) {
    turned()->unturned_positions(sets_[set].inner, inner);
    return extend_turned(sets_[set], inner, turned()->turn_now(), x);
  }
  inner_->positions(sets_[set].inner, inner);
  extend(sets_[set], inner, x);
}

void PointedBody::predicted_positions(Index set, Points& x) const {
  if (is_plain(set)) return inner_->predicted_positions(sets_[set].inner, x);
  Points inner;
  if (turned() != nullptr) {
    turned()->unturned_end(sets_[set].inner, inner);
    return extend_turned(sets_[set], inner, turned()->turn_at_end(), x);
  }
  inner_->predicted_positions(sets_[set].inner, inner);
  extend(sets_[set], inner, x);
}

void PointedBody::expect_forces(Index set, const Impulses& forces) {
  const NodeSet& of = sets_[set];
  if (is_plain(set)) return inner_->expect_forces(of.inner, forces);
  Points nodal[2] = {Points(0, 3), Points(0, 3)};
  forces.each([&](const Points& f, ImpulseKind kind) {
    nodal[kind == ImpulseKind::friction] = spread(of, f);
  });
  inner_->expect_forces(of.inner, {nodal[0], nodal[1]});
}

void PointedBody::take_impulses(Index set, const Impulses& impulses) {
  const NodeSet& of = sets_[set];
  if (is_plain(set)) return inner_->take_impulses(of.inner, impulses);
  impulses.each([&](const Points& p, ImpulseKind kind) {
    if (turned() == nullptr) return inner_->add_impulses(of.inner, spread(of, p), kind);
    const Matrix3 R = turned()->turn_of_step();
    const Points nodal = spread(of, p * R) * R.transpose();
    inner_->add_impulses(of.inner, nodal, kind);
    turned()->add_moment(missing_moment(of, p, nodal), kind);
  });
}

Vector3 PointedBody::add_velocities(Index set, const Points& velocities, const Vector3& momentum) {
  return inner_->nodal()->add_velocities(sets_[set].inner, velocities, momentum);
}

void PointedBody::end_velocities(Index set, Points& v) {
  if (is_plain(set)) return inner_->end_impulses()->end_velocities(sets_[set].inner, v);
  Points inner;
  inner_->end_impulses()->end_velocities(sets_[set].inner, inner);
  v = table(sets_[set].E * flat(inner));
}

NodeResponse PointedBody::velocity_response(Index set) const {
  const NodeResponse inner = inner_->end_impulses()->velocity_response(sets_[set].inner);
  return is_plain(set) ? inner : extended(sets_[set], inner);
}

void PointedBody::add_end_impulses(Index set, const Points& impulses, ImpulseKind kind) {
  inner_->end_impulses()->add_end_impulses(
      sets_[set].inner, is_plain(set) ? impulses : spread(sets_[set], impulses), kind);
}

Matrix PointedBody::floating_motions(Index set) const {
  const Matrix inner = inner_->statics()->floating_motions(sets_[set].inner);
  return is_plain(set) ? inner : Matrix(sets_[set].E * inner);
}

NodeResponse PointedBody::static_response(Index set) const {
  const NodeResponse inner = inner_->statics()->static_response(sets_[set].inner);
  return is_plain(set) ? inner : extended(sets_[set], inner);
}

void PointedBody::add_static_forces(Index set, const Points& forces, ImpulseKind kind) {
  inner_->statics()->add_static_forces(sets_[set].inner,
                                       is_plain(set) ? forces : spread(sets_[set], forces), kind);
}

NodeResponse PointedBody::response(Index set, double h) const {
  if (!is_plain(set) && turned() != nullptr) return turned_response(sets_[set], h);
  const NodeResponse inner = inner_->response(sets_[set].inner, h);
  return is_plain(set) ? inner : extended(sets_[set], inner);
}

void PointedBody::point_motion(Index point, Vector3& d, Vector3& theta, Vector3& velocity,
                               Vector3& spin) const {
  Points u, v;
  if (turned() != nullptr) {
    turned()->unturned_displacements(u, v);
  } else {
    inner_->displacements(u, v);
  }
  for (Vector3* x : {&d, &theta, &velocity, &spin}) x->setZero();
  const auto& nodes = points_[point].nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    d += maps_[point].d[i] * u.row(nodes[i]).transpose();
    theta += maps_[point].theta[i] * u.row(nodes[i]).transpose();
    velocity += maps_[point].d[i] * v.row(nodes[i]).transpose();
    spin += maps_[point].theta[i] * v.row(nodes[i]).transpose();
  }
  if (turned() == nullptr) return;
  Points whole_d = d.transpose(), whole_v = velocity.transpose();
  inner_->turn(points_[point].at.transpose(), whole_d, whole_v);
  d = whole_d.row(0).transpose();
  velocity = whole_v.row(0).transpose();
  const Matrix3 R = turned()->turn_now().R;
  spin = turned()->spin() + R * spin;
  const Eigen::AngleAxisd whole(R * rotation_of(theta));
  theta = whole.angle() * whole.axis();
}

void PointedBody::keep_state(StateArchive& archive) {
  inner_->keep_state(archive);
  if (turned() == nullptr) return;
  for (Vector3& arm : arms_) archive(arm);
}

void PointedBody::add_inner_terms(Index node, const Vector3& weight,
                                  std::vector<std::pair<Index, Vector3>>& terms) const {
  if (node < n_) {
    terms.emplace_back(node, weight);
    return;
  }
  std::size_t j = 0;
  const auto& maps = maps_of(node, j);
  for (std::size_t i = 0; i < maps.size(); ++i)
    terms.emplace_back(points_[j].nodes[i], maps[i].transpose() * weight);
}

BodyLoad PointedBody::point_load(bool is_force, Index point, const Vector3& value,
                                 const LoadHistory& history, bool follows) const {
  const auto& nodes = points_[point].nodes;
  const auto& maps = is_force ? maps_[point].d : maps_[point].theta;
  BodyLoad load{.vector = VectorForce{{}, value, follows}, .history = history};
  for (Index a = 0; a < 3; ++a) {
    Points forces = Points::Zero(n_, 3);
    for (std::size_t i = 0; i < nodes.size(); ++i) forces.row(nodes[i]) += maps[i].row(a);
    load.vector->patterns[static_cast<std::size_t>(a)].forces = forces;
  }
  return load;
}

}  // namespace cbr

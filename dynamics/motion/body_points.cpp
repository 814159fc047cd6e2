// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/body_points.hpp"

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

AverageMaps average_maps(const AveragePoint& point, const Points& positions) {
  if (point.is_of_interface) return maps_of_interface(point, positions);
  const Spread spread = spread_of(point, positions);
  const Turns turns = turns_of(spread, point.n_rotations > 0 ? slender : thin);
  if (!turns.without_arm.isZero(0) && point.n_rotations == 0)
    throw InputError(
        point.where +
        ": its nodes lie on a line, or are one, and determine no rotation: take a surface, "
        "or nodes of shells that keep their rotations: those of a mesh, of basis: craig-bampton "
        "without condense_rotations, and of sets in reduction: characteristic: {keep: [SET]}");
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

BodyPoints::BodyPoints(std::vector<AveragePoint> points, const Points& own_nodes)
    : n_(own_nodes.rows()), points_(std::move(points)), arms_(points_.size(), Vector3::Zero()) {
  for (std::size_t j = 0; j < points_.size(); ++j) {
    maps_.push_back(average_maps(points_[j], own_nodes));
    if (points_[j].rigid) add_deformations(j, own_nodes);
  }
  const auto n_points = static_cast<Index>(points_.size());
  positions_.resize(n_ + 2 * n_points + static_cast<Index>(deformations_.size()), 3);
  positions_.topRows(n_) = own_nodes;
  for (Index i = n_; i < positions_.rows(); ++i) {
    std::size_t point = 0;
    maps_of(i, point);
    positions_.row(i) = points_[point].at.transpose();
  }
}

void BodyPoints::add_deformations(std::size_t point, const Points& own_nodes) {
  const std::string& where = points_[point].where;
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
  const Matrix Z = deformation_rows(points_[point], own_nodes);
  for (Index i = 0; i + 3 <= Z.rows(); i += 3) {
    Extra extra{point, {}};
    for (Index node = 0; node < static_cast<Index>(k); ++node)
      extra.maps.push_back(Z.block<3, 3>(i, 3 * node));
    deformations_.push_back(std::move(extra));
  }
}

std::vector<Index> BodyPoints::deformation_nodes(Index point) const {
  std::vector<Index> nodes;
  for (std::size_t i = 0; i < deformations_.size(); ++i)
    if (static_cast<Index>(deformations_[i].point) == point)
      nodes.push_back(n_ + 2 * static_cast<Index>(points_.size()) + static_cast<Index>(i));
  return nodes;
}

// Of a node behind those of the body itself.
const std::vector<Matrix3>& BodyPoints::maps_of(Index node, std::size_t& point) const {
  const auto k = static_cast<std::size_t>(node - n_);
  if (k >= 2 * points_.size()) {
    const Extra& extra = deformations_[k - 2 * points_.size()];
    point = extra.point;
    return extra.maps;
  }
  point = k / 2;
  return k % 2 == 0 ? maps_[point].d : maps_[point].theta;
}

std::vector<Index> BodyPoints::track(const std::vector<Index>& nodes) {
  NodeSet& set = sets_.emplace_back();
  const auto first_point = std::lower_bound(nodes.begin(), nodes.end(), n_);
  if (first_point == nodes.end()) return nodes;
  std::vector<Index> own(nodes.begin(), first_point);
  for (auto it = first_point; it != nodes.end(); ++it) {
    std::size_t point = 0;
    maps_of(*it, point);
    const auto& of = points_[point].nodes;
    own.insert(own.end(), of.begin(), of.end());
  }
  sort_uniquely(own);
  set.nodes = nodes;
  set.n_nodes = static_cast<Index>(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < n_ || !takes_force(nodes[i])) continue;
    const auto point = static_cast<std::size_t>((nodes[i] - n_) / 2);
    if (!points_[point].slides) continue;
    set.slides.push_back({static_cast<Index>(i), static_cast<Index>(set.nodes.size()), point});
    set.nodes.push_back(nodes[i] + 1);
  }
  std::vector<Eigen::Triplet<double, Index>> entries;
  const auto add = [&](Index row, Index node, const Matrix3& map) {
    const Index at = std::lower_bound(own.begin(), own.end(), node) - own.begin();
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        if (map(a, b) != 0) entries.emplace_back(3 * row + a, 3 * at + b, map(a, b));
  };
  for (Index i = 0; i < static_cast<Index>(set.nodes.size()); ++i) {
    if (set.nodes[i] < n_) {
      add(i, set.nodes[i], Matrix3::Identity());
      continue;
    }
    std::size_t j = 0;
    const auto& maps = maps_of(set.nodes[i], j);
    for (std::size_t k = 0; k < points_[j].nodes.size(); ++k) add(i, points_[j].nodes[k], maps[k]);
  }
  set.E.resize(3 * static_cast<Index>(set.nodes.size()), 3 * static_cast<Index>(own.size()));
  set.E.setFromTriplets(entries.begin(), entries.end());
  set.X = positions_(set.nodes, Eigen::all);
  set.X_own = positions_(own, Eigen::all);
  return own;
}

void BodyPoints::extend(const NodeSet& set, Points& own) const {
  Points x = set.X + table(set.E * flat(own - set.X_own));
  for (const NodeSet::Slide& slide : set.slides) {
    const Vector3 theta = x.row(slide.rotation) - set.X.row(slide.rotation);
    x.row(slide.row) += (arms_[slide.point] + theta.cross(arms_[slide.point])).transpose();
  }
  own = x.topRows(set.n_nodes);
}

// Places turn about the body's centre, rotations and deformations about where they are.
void BodyPoints::extend(Index set, const BodyTurn& turn, Points& own) const {
  const NodeSet& of = sets_[set];
  extend(of, own);
  if (turn.R == Matrix3::Identity()) return;
  for (Index i = 0; i < own.rows(); ++i) {
    const Vector3 about = takes_force(of.nodes[i]) ? turn.center : Vector3(of.X.row(i).transpose());
    own.row(i) = (about + turn.R * (own.row(i).transpose() - about)).transpose();
  }
}

void BodyPoints::extend_rates(Index set, Points& own) const {
  own = table(sets_[set].E * flat(own));
}

Points BodyPoints::spread(Index set, const Points& impulses) const {
  const NodeSet& of = sets_[set];
  if (of.slides.empty()) return table(of.E.transpose() * flat(impulses));
  Points all = Points::Zero(of.X.rows(), 3);
  all.topRows(of.n_nodes) = impulses;
  for (const NodeSet::Slide& slide : of.slides)
    all.row(slide.rotation) =
        arms_[slide.point].cross(Vector3(impulses.row(slide.row).transpose())).transpose();
  return table(of.E.transpose() * flat(all));
}

Vector3 BodyPoints::missing_moment(Index set, const BodyTurn& turn, const Points& own,
                                   const Points& impulses, const Points& spread) const {
  Points x = own;
  extend(set, turn, x);
  Vector3 moment = Vector3::Zero();
  for (Index i = 0; i < x.rows(); ++i) {
    const Index node = sets_[set].nodes[i];
    const Vector3 P = impulses.row(i).transpose();
    if (takes_force(node)) {
      moment += Vector3(x.row(i).transpose() - turn.center).cross(P);
    } else if (node < n_ + 2 * static_cast<Index>(points_.size())) {
      moment += P;
    }
  }
  for (Index i = 0; i < own.rows(); ++i)
    moment -=
        (turn.R * (own.row(i).transpose() - turn.center)).cross(Vector3(spread.row(i).transpose()));
  return moment;
}

// A place that slides moves as its point and by the rotation, times the arm.
Matrix BodyPoints::slid(const NodeSet& set, const Matrix& S) const {
  if (set.slides.empty()) return S;
  Matrix A = Matrix::Identity(3 * set.n_nodes, S.rows());
  for (const NodeSet::Slide& slide : set.slides)
    A.block<3, 3>(3 * slide.row, 3 * slide.rotation) = -cross(arms_[slide.point]);
  return A * S * A.transpose();
}

// E S E^T
Matrix BodyPoints::product(const NodeSet& set, const NodeResponse& own) const {
  const Matrix half = set.E * own.dense();
  const Matrix S = half * set.E.transpose();
  return 0.5 * (S + S.transpose());
}

NodeResponse BodyPoints::turned_response(Index set, double h, const Matrix3& turn,
                                         const std::function<NodeResponse()>& own) const {
  const NodeSet& of = sets_[set];
  if (!of.answer || of.answer_h != h) of.answer = std::make_shared<Matrix>(product(of, own()));
  of.answer_h = h;
  NodeResponse response;
  response.axes = turn;
  response.block =
      of.slides.empty() ? of.answer : std::make_shared<const Matrix>(slid(of, *of.answer));
  return response;
}

NodeResponse BodyPoints::extended(Index set, const NodeResponse& own) const {
  NodeResponse response;
  response.set_block(slid(sets_[set], product(sets_[set], own)));
  return response;
}

void BodyPoints::point_motion(const Body& body, Index point, Vector3& d, Vector3& theta,
                              Vector3& velocity, Vector3& spin) const {
  Points u, v;
  body.turns() ? body.unturned_displacements(u, v) : body.displacements(u, v);
  for (Vector3* x : {&d, &theta, &velocity, &spin}) x->setZero();
  const auto& nodes = points_[point].nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    d += maps_[point].d[i] * u.row(nodes[i]).transpose();
    theta += maps_[point].theta[i] * u.row(nodes[i]).transpose();
    velocity += maps_[point].d[i] * v.row(nodes[i]).transpose();
    spin += maps_[point].theta[i] * v.row(nodes[i]).transpose();
  }
  if (!body.turns()) return;
  Points whole_d = d.transpose(), whole_v = velocity.transpose();
  body.turn(points_[point].at.transpose(), whole_d, whole_v);
  d = whole_d.row(0).transpose();
  velocity = whole_v.row(0).transpose();
  const Matrix3 R = body.turn_now().R;
  spin = body.spin() + R * spin;
  const Eigen::AngleAxisd whole(R * rotation_of(theta));
  theta = whole.angle() * whole.axis();
}

void BodyPoints::keep_state(StateArchive& archive) {
  for (Vector3& arm : arms_) archive(arm);
}

void BodyPoints::add_own_terms(Index node, const Vector3& weight,
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

BodyLoad BodyPoints::point_load(bool is_force, Index point, const Vector3& value,
                                const LoadHistory& history, bool follows) const {
  const auto& nodes = points_[point].nodes;
  const auto& maps = is_force ? maps_[point].d : maps_[point].theta;
  BodyLoad load{.vector = VectorForce{{}, value, follows}, .history = history};
  for (Index a = 0; a < 3; ++a) {
    Points forces = Points::Zero(n_, 3);
    for (std::size_t i = 0; i < nodes.size(); ++i) forces.row(nodes[i]) += maps[i].row(a);
    load.vector->patterns[a].forces = forces;
  }
  return load;
}

}  // namespace cbr

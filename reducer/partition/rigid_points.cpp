// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/partition/rigid_points.hpp"

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/mesh/face_weights.hpp"
#include "common/mesh/surface.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

constexpr double collinear_set = 1e-10;  // of the set's size

// Weights of the set's nodes: shares of the faces' area, or one for each of a nodeset.
Vector3 middle_of(const Mesh& mesh, const std::string& set, const std::vector<Index>& nodes) {
  const Points x = mesh.coordinates(nodes, Eigen::all);
  const Index sideset = find_sideset(mesh, set);
  if (sideset < 0) return x.colwise().mean();
  const Surface surface = extract_surface(mesh, mesh.sidesets[sideset]);
  const Vector weights = Vector(face_weights(surface, mesh.coordinates)(nodes));
  return x.transpose() * weights / weights.sum();
}

// True if the nodes determine all six rigid motions.
bool tell_rotations(const Mesh& mesh, const std::vector<Index>& nodes) {
  Points x = mesh.coordinates(nodes, Eigen::all);
  const Eigen::RowVector3d middle = x.colwise().mean();
  x.rowwise() -= middle;
  const double size = x.rowwise().norm().maxCoeff();
  return size > 0 && PivotedQr(rigid_modes(x / size, Vector3::Zero()), collinear_set).rank() == 6;
}

class Checker {
 public:
  Checker(const Mesh& mesh, const Component& component)
      : mesh_(mesh), model_(number_nodes(mesh)), owner_(mesh.node_ids.size()) {
    for (const std::string& set : component.reduction->interface_sets)
      for (const Index node : set_nodes(mesh, set)) owner_[node] = "reduction.interface";
  }

  void check(const std::string& where, const RigidPoint& point) {
    if (find_sideset(mesh_, point.name) >= 0 || find_nodeset(mesh_, point.name) >= 0)
      throw InputError(where + "a set of the mesh has this name: give the point another one");
    for (const Index node : point.nodes) {
      const std::string id = "node id " + std::to_string(mesh_.node_ids[node]);
      if (model_.row[node] < 0)
        throw InputError(where + id + " belongs to no volume element: take it out of the set");
      std::string& owner = owner_[node];
      if (!owner.empty())
        throw InputError(where + id + " is of " + owner +
                         " too, and one of the two would have to give way: take sets without "
                         "common nodes");
      owner = "the point '" + point.name + "'";
    }
    if (!tell_rotations(mesh_, point.nodes))
      throw InputError(where +
                       "the nodes of its set lie on a line, or are one, and determine no "
                       "rotation: take a surface");
  }

 private:
  const Mesh& mesh_;
  FiniteElementModel model_;
  std::vector<std::string> owner_;  // of each node of the mesh
};

// A <- G^T A G
void congruent(const SparseMatrix& G, SparseMatrix& A) {
  const SparseMatrix AG = A * G;
  const SparseMatrix G_t = G.transpose();
  A = G_t * AG;
}

}  // namespace

std::vector<RigidPoint> rigid_points(const Mesh& mesh, const Component& component) {
  std::vector<RigidPoint> points;
  if (!component.reduction || component.reduction->interface_points.empty()) return points;
  std::vector<std::string> names = component.reduction->interface_points;
  sort_uniquely(names);
  Checker checker(mesh, component);
  for (const std::string& name : names) {
    const Component::Point& of = component.points.at(name);
    const std::string where = of.source.text() + ": components." + component.name + ".points." +
                              name + " ('" + of.nodes + "'): ";
    RigidPoint point;
    point.name = name;
    try {
      point.nodes = set_nodes(mesh, of.nodes);
    } catch (const InputError& error) {
      throw InputError(where + error.what());
    }
    if (point.nodes.empty()) throw InputError(where + "the set has no nodes: take another one");
    std::sort(point.nodes.begin(), point.nodes.end());
    checker.check(where, point);
    point.at = of.at ? *of.at : middle_of(mesh, of.nodes, point.nodes);
    points.push_back(std::move(point));
  }
  return points;
}

Eigen::Matrix<double, 3, 6> motion_at(const Vector3& r) {
  Eigen::Matrix<double, 3, 6> A;
  A << Matrix3::Identity(), Matrix3::Zero();
  A.rightCols<3>() << 0, r[2], -r[1], -r[2], 0, r[0], r[1], -r[0], 0;
  return A;
}

void couple_rigidly(const Mesh& mesh, const std::vector<RigidPoint>& points,
                    FiniteElementModel& model, Points& x) {
  std::vector<Index> point_of(model.nodes.size(), -1);
  for (std::size_t j = 0; j < points.size(); ++j)
    for (const Index node : points[j].nodes) point_of[model.row[node]] = static_cast<Index>(j);
  std::vector<Index> nodes, kept;
  for (std::size_t i = 0; i < point_of.size(); ++i)
    if (point_of[i] < 0) {
      nodes.push_back(model.nodes[i]);
      kept.push_back(static_cast<Index>(i));
    }
  const auto first_point = static_cast<Index>(nodes.size());
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t i = 0; i < kept.size(); ++i)
    for (Index d = 0; d < 3; ++d)
      entries.emplace_back(3 * kept[i] + d, 3 * static_cast<Index>(i) + d, 1.0);
  for (std::size_t i = 0; i < point_of.size(); ++i) {
    if (point_of[i] < 0) continue;
    const Vector3 r = Vector3(mesh.coordinates.row(model.nodes[i])) - points[point_of[i]].at;
    const auto A = motion_at(r);
    const Index column = 3 * (first_point + 2 * point_of[i]);
    for (Index d = 0; d < 3; ++d)
      for (Index m = 0; m < 6; ++m)
        if (A(d, m) != 0) entries.emplace_back(3 * static_cast<Index>(i) + d, column + m, A(d, m));
  }
  const Index n = first_point + 2 * static_cast<Index>(points.size());
  SparseMatrix G(model.K.rows(), 3 * n);
  G.setFromTriplets(entries.begin(), entries.end());
  congruent(G, model.K);
  congruent(G, model.M);
  for (std::size_t i = 0; i < kept.size(); ++i) model.row[nodes[i]] = static_cast<Index>(i);
  Points x_all(n, 3);
  x_all.topRows(first_point) = mesh.coordinates(nodes, Eigen::all);
  for (std::size_t j = 0; j < points.size(); ++j) {
    const Index row = first_point + 2 * static_cast<Index>(j);
    for (const Index node : points[j].nodes) model.row[node] = row;
    // Messages about the point name this node
    nodes.insert(nodes.end(), 2, points[j].nodes.front());
    x_all.row(row) = x_all.row(row + 1) = points[j].at.transpose();
  }
  model.nodes = std::move(nodes);
  x = std::move(x_all);
}

}  // namespace cbr

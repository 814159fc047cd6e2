// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/statics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "common/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/dense_factor.hpp"

namespace cbr {
namespace {

constexpr double same_direction = 0.9998;  // cosine, 1 degree
constexpr double flat_enough = 0.1;        // length of an area vector over the area: below, a node has no normal

const Surface* find_surface(const Superelement& s, const std::string& name) {
  const auto found = std::find_if(s.surfaces.begin(), s.surfaces.end(), [&](const Surface& of) { return of.name == name; });
  return found != s.surfaces.end() ? &*found : nullptr;
}

std::vector<std::string> set_names(const Superelement& s, bool nodesets) {
  std::vector<std::string> names;
  for (const Surface& surface : s.surfaces) names.push_back(surface.name);
  if (nodesets)
    for (const auto& [name, nodes] : s.nodesets) names.push_back(name);
  return names;
}

[[noreturn]] void refuse_set(const std::string& key, const std::string& kind, const std::string& name,
                             const std::vector<std::string>& names) {
  const std::string hint = nearest_name(name, names);
  throw InputError("characteristic." + key + ": the interface keeps no " + kind + " '" + name + "'" + hint +
                   (hint.empty() ? ", allowed: " : " allowed: ") + (names.empty() ? "none" : join(names)));
}

// Nodes of a kept set; whether there is one.
bool find_nodes(const Superelement& s, const std::string& name, std::vector<Index>& nodes) {
  if (const Surface* surface = find_surface(s, name)) {
    nodes = surface_nodes(*surface);
    return true;
  }
  const auto set = s.nodesets.find(name);
  if (set == s.nodesets.end()) return false;
  nodes = set->second;
  return true;
}

// A nodeset of the interface, or a set by its number, has no faces of its own: then all that is kept may touch.
bool all_may_touch(const InterfaceNeeds& needs, const Superelement& s) {
  if (needs.all_touch) return true;
  return std::any_of(needs.touching.begin(), needs.touching.end(), [&](const auto& set) { return !find_surface(s, set.first); });
}

struct NodeForces {
  bool all_directions = false;
  std::vector<Vector3> normals;
};

void add_normal(const Vector3& area_vector, double area, NodeForces& forces) {
  const double length = area_vector.norm();
  if (!(length > flat_enough * area)) {
    forces.all_directions = true;
    return;
  }
  const Vector3 n = area_vector / length;
  for (const Vector3& other : forces.normals)
    if (other.dot(n) > same_direction) return;
  forces.normals.push_back(n);
  if (forces.normals.size() > 2) forces.all_directions = true;
}

}  // namespace

std::vector<TouchingSurface> touching_surfaces(const CharacteristicOptions& options, const Superelement& s) {
  const InterfaceNeeds& needs = options.needs;
  const bool everywhere = options.shear || needs.all_touch.value_or(false);
  const auto directions = [&](const std::string& name) {
    const auto found = needs.touching.find(name);
    return everywhere || (found != needs.touching.end() && found->second);
  };
  std::vector<TouchingSurface> touching;
  for (const std::string& name : options.statics) {
    const Surface* surface = find_surface(s, name);
    if (surface == nullptr) refuse_set("statics", "sideset", name, set_names(s, false));
    touching.push_back({surface, directions(name)});
  }
  if (!options.statics.empty()) return touching;
  const bool all = all_may_touch(needs, s);
  for (const Surface& surface : s.surfaces)
    if (all || needs.touching.count(surface.name) > 0) touching.push_back({&surface, directions(surface.name)});
  return touching;
}

std::vector<char> kept_nodes(const CharacteristicOptions& options, const Superelement& s) {
  std::vector<char> is_kept(s.node_ids.size(), 0);
  std::vector<Index> nodes;
  for (const std::string& name : options.keep) {
    if (!find_nodes(s, name, nodes)) refuse_set("keep", "set", name, set_names(s, true));
    for (const Index node : nodes) is_kept[static_cast<std::size_t>(node)] = 1;
  }
  for (const std::string& name : options.needs.held) {
    if (!find_nodes(s, name, nodes)) continue;
    for (const Index node : nodes) is_kept[static_cast<std::size_t>(node)] = 1;
  }
  return is_kept;
}

StaticShare static_forces(const CharacteristicOptions& options, const Superelement& s) {
  StaticShare forces;
  if (options.no_statics) return forces;
  const std::vector<char> is_kept = kept_nodes(options, s);
  std::map<Index, NodeForces> of_node;
  for (const auto& [surface, all_directions] : touching_surfaces(options, s)) {
    const NodeAreas areas = node_areas(s, *surface);
    for (std::size_t i = 0; i < areas.node.size(); ++i) {
      if (is_kept[static_cast<std::size_t>(areas.node[i])] != 0) continue;
      NodeForces& node = of_node[areas.node[i]];
      const auto row = static_cast<Index>(i);
      node.all_directions |= all_directions;
      if (!node.all_directions) add_normal(areas.vector.row(row), areas.area(row), node);
    }
  }
  std::vector<Vector3> directions;
  for (const auto& [node, of] : of_node) {
    std::vector<Vector3> its = of.normals;
    if (of.all_directions) its = {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
    forces.node.insert(forces.node.end(), its.size(), node);
    directions.insert(directions.end(), its.begin(), its.end());
  }
  forces.direction.resize(forces.size(), 3);
  for (Index i = 0; i < forces.size(); ++i) forces.direction.row(i) = directions[static_cast<std::size_t>(i)];
  return forces;
}

Matrix along_forces(const StaticShare& forces, const Superelement& s, const Matrix& V) {
  std::vector<std::array<Index, 3>> dofs(s.node_ids.size(), {-1, -1, -1});
  for (Index i = 0; i < s.c(); ++i)
    dofs[static_cast<std::size_t>(s.dof_node[static_cast<std::size_t>(i)])]
        [static_cast<std::size_t>(s.dof_component[static_cast<std::size_t>(i)])] = i;
  Matrix G = Matrix::Zero(forces.size(), V.cols());
  for (Index i = 0; i < forces.size(); ++i) {
    const auto& its = dofs[static_cast<std::size_t>(forces.node[static_cast<std::size_t>(i)])];
    for (Index d = 0; d < 3; ++d)
      if (its[static_cast<std::size_t>(d)] >= 0) G.row(i) += forces.direction(i, d) * V.row(its[static_cast<std::size_t>(d)]);
  }
  return G;
}

Matrix forces_on_dofs(const StaticShare& forces, const Superelement& s) {
  Matrix B = Matrix::Zero(s.c(), forces.size());
  std::multimap<Index, Index> of_node;
  for (Index i = 0; i < forces.size(); ++i) of_node.emplace(forces.node[static_cast<std::size_t>(i)], i);
  for (Index dof = 0; dof < s.c(); ++dof) {
    const auto [first, end] = of_node.equal_range(s.dof_node[static_cast<std::size_t>(dof)]);
    for (auto entry = first; entry != end; ++entry)
      B(dof, entry->second) = forces.direction(entry->second, s.dof_component[static_cast<std::size_t>(dof)]);
  }
  return B;
}

NodeAreas node_areas(const Superelement& s, const Surface& surface) {
  NodeAreas areas;
  areas.node = surface_nodes(surface);
  std::vector<Index> place(s.node_ids.size(), -1);
  for (std::size_t i = 0; i < areas.node.size(); ++i) place[static_cast<std::size_t>(areas.node[i])] = static_cast<Index>(i);
  areas.vector = Points::Zero(static_cast<Index>(areas.node.size()), 3);
  areas.area = Vector::Zero(areas.vector.rows());
  const IndexTable faces = linear_faces(surface).faces;
  for (Index f = 0; f < faces.rows(); ++f) {
    const Index corners = faces(f, 3) == faces(f, 2) ? 3 : 4;
    const auto x = [&](Index i) { return Vector3(s.coordinates.row(faces(f, i))); };
    const Vector3 a = 0.5 * (x(2) - x(0)).cross(x(3) - x(1));  // of a triangle, x3 = x2, too
    for (Index i = 0; i < corners; ++i) {
      const Index node = place[static_cast<std::size_t>(faces(f, i))];
      areas.vector.row(node) += a.transpose() / static_cast<double>(corners);
      areas.area(node) += a.norm() / static_cast<double>(corners);
    }
  }
  return areas;
}

InteriorInertia interior_inertia(const RigidMotions& rigid, const SparseCholesky& factor_of_K_II) {
  InteriorInertia inertia;
  inertia.R_C = Matrix(rigid.R_C);
  if (rigid.count() == 0) return inertia;
  const Matrix P_I = Matrix(rigid.P_I);
  inertia.Q = P_I.transpose() * factor_of_K_II.solve(P_I);
  return inertia;
}

Matrix inertia_of(const InteriorInertia& inertia, const Matrix& R) {
  if (inertia.Q.size() == 0) return Matrix::Zero(R.cols(), R.cols());
  const Matrix X = PivotedQr(inertia.R_C).solve(R);
  return X.transpose() * inertia.Q * X;
}

Matrix compliance_that_is_left(Matrix C, const StaticShare& forces, Index n_rigid, const Superelement& s) {
  const Index e = s.k() - n_rigid;
  const Matrix V = along_forces(forces, s, s.characteristic.V);
  const Matrix G = V.rightCols(e) * s.eigenvalues.tail(e).cwiseSqrt().cwiseInverse().asDiagonal();
  C.selfadjointView<Eigen::Lower>().rankUpdate(G, -1);
  // Nothing left of a node's own is round-off, which may have either sign
  for (Index i = 0; i < C.rows(); ++i) C(i, i) = std::max(C(i, i), 0.0);
  mirror_lower(C);
  return C;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/characteristic/statics.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/mesh/face_weights.hpp"

namespace cbr {
namespace {

const Surface* find_surface(const Superelement& s, const std::string& name) {
  const auto found = std::find_if(s.surfaces.begin(), s.surfaces.end(),
                                  [&](const Surface& of) { return of.name == name; });
  return found != s.surfaces.end() ? &*found : nullptr;
}

std::vector<std::string> set_names(const Superelement& s, bool nodesets) {
  std::vector<std::string> names;
  for (const Surface& surface : s.surfaces) names.push_back(surface.name);
  if (nodesets)
    for (const auto& [name, nodes] : s.nodesets) names.push_back(name);
  return names;
}

[[noreturn]] void refuse_set(const std::string& key, const std::string& kind,
                             const std::string& name, const std::vector<std::string>& names) {
  const std::string hint = nearest_name(name, names);
  throw InputError("characteristic." + key + ": the interface keeps no " + kind + " '" + name +
                   "'" + hint + (hint.empty() ? ", allowed: " : " allowed: ") +
                   (names.empty() ? "none" : join(names)));
}

// Of each node of s: its share of a force on the set, as loads_setup() of cbr-dyn has it.
Vector weights_on(const Superelement& s, const std::string& name) {
  if (const Surface* surface = find_surface(s, name)) return face_weights(*surface, s.coordinates);
  Vector weights = Vector::Zero(s.coordinates.rows());
  const auto set = s.nodesets.find(name);
  if (set != s.nodesets.end()) weights(set->second).setOnes();
  return weights;
}

// Forces at all nodes, for each kind of load on a set.
std::vector<Points> load_forces(const Superelement& s, const std::string& name,
                                const LoadKinds& kinds) {
  std::vector<Points> loads;
  const Vector weights = weights_on(s, name);
  if (!(weights.sum() > 0)) return loads;
  const Eigen::RowVector3d centre = weights.transpose() * s.coordinates / weights.sum();
  for (Index axis = 0; axis < 3; ++axis) {
    const Vector3 unit = Vector3::Unit(axis);
    if (kinds.forces) loads.emplace_back(weights * unit.transpose());
    // Histories are means of nodes, whatever the area of each. These loads make them right under
    // loads elsewhere, as their work is
    if ((kinds.forces || kinds.pressure || kinds.means) &&
        (find_surface(s, name) != nullptr || !kinds.forces))
      loads.emplace_back(
          weights.unaryExpr([](double weight) { return weight > 0 ? 1.0 : 0.0; }).eval() *
          unit.transpose());
    if (!kinds.moments) continue;
    Points forces(s.coordinates.rows(), 3);
    for (Index i = 0; i < forces.rows(); ++i)
      forces.row(i) =
          weights(i) * unit.cross(Vector3((s.coordinates.row(i) - centre).transpose())).transpose();
    loads.push_back(std::move(forces));
  }
  if (const Surface* surface = find_surface(s, name); surface != nullptr && kinds.pressure)
    loads.push_back(face_normals(*surface, s.coordinates));
  return loads;
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

}  // namespace

std::vector<TouchingSurface> touching_surfaces(const CharacteristicOptions& options,
                                               const Superelement& s) {
  const InterfaceNeeds& needs = options.needs;
  if (options.statics.empty()) return touching_surfaces(needs, s, options.shear);
  const bool everywhere = options.shear || needs.all_touch.value_or(false);
  std::vector<TouchingSurface> touching;
  for (const std::string& name : options.statics) {
    const Surface* surface = find_surface(s, name);
    if (surface == nullptr) refuse_set("statics", "sideset", name, set_names(s, false));
    const auto found = needs.touching.find(name);
    touching.push_back({surface, everywhere || (found != needs.touching.end() && found->second)});
  }
  return touching;
}

std::vector<char> kept_nodes(const CharacteristicOptions& options, const Superelement& s) {
  std::vector<char> is_kept(s.node_ids.size(), 0);
  std::vector<Index> nodes;
  for (const std::string& name : options.keep) {
    if (!find_nodes(s, name, nodes)) refuse_set("keep", "set", name, set_names(s, true));
    for (const Index node : nodes) is_kept[node] = 1;
  }
  for (const std::string& name : options.needs.held) {
    if (!find_nodes(s, name, nodes)) continue;
    for (const Index node : nodes) is_kept[node] = 1;
  }
  return is_kept;
}

StaticShare static_forces(const CharacteristicOptions& options, const Superelement& s) {
  return static_forces(touching_surfaces(options, s), kept_nodes(options, s), s);
}

Matrix load_columns(const CharacteristicOptions& options, const std::vector<char>& is_kept,
                    const Superelement& s) {
  std::vector<Points> loads;
  std::vector<Index> nodes;
  for (const auto& [name, kinds] : loads_beside_statics(options, options.needs)) {
    if (!find_nodes(s, name, nodes)) continue;
    if (std::all_of(nodes.begin(), nodes.end(), [&](Index node) { return is_kept[node] != 0; }))
      continue;
    for (Points& forces : load_forces(s, name, kinds)) loads.push_back(std::move(forces));
  }
  const auto n = static_cast<Index>(loads.size());
  Matrix B(s.c(), 2 * n);
  for (Index i = 0; i < s.c(); ++i)
    for (std::size_t j = 0; j < loads.size(); ++j)
      B(i, static_cast<Index>(j)) =
          s.dof_component[i] < 3 ? loads[j](s.dof_node[i], s.dof_component[i]) : 0;
  // The residual compliance answers the part of a load along these forces. It adds nothing to the
  // load's shape when that part has one, too
  const SparseMatrix along = forces_on_dofs(static_forces(options, s), s);
  B.rightCols(n) = along * Matrix(along.transpose() * B.leftCols(n));
  std::vector<Index> loaded;
  for (Index j = 0; j < B.cols(); ++j)
    if (j < n || !B.col(j).isZero(0)) loaded.push_back(j);
  return B(Eigen::all, loaded);
}

std::vector<std::string> sets_without_statics(const CharacteristicOptions& options,
                                              const std::vector<char>& is_kept,
                                              const Superelement& s) {
  std::vector<char> is_answered = is_kept;
  for (const Index node : static_forces(options, s).node) is_answered[node] = 1;
  const std::map<std::string, LoadKinds> loads = loads_beside_statics(options, options.needs);
  std::vector<std::string> names;
  std::vector<Index> nodes;
  for (const std::string& name : set_names(s, true)) {
    const auto load = loads.find(name);
    if ((load != loads.end() && load->second.acts()) || !find_nodes(s, name, nodes)) continue;
    if (!std::all_of(nodes.begin(), nodes.end(),
                     [&](Index node) { return is_answered[node] != 0; }))
      names.push_back(name);
  }
  return names;
}

SparseMatrix forces_on_dofs(const StaticShare& forces, const Superelement& s) {
  std::multimap<Index, Index> of_node;
  for (Index i = 0; i < forces.size(); ++i) of_node.emplace(forces.node[i], i);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index dof = 0; dof < s.c(); ++dof) {
    const auto [first, end] = of_node.equal_range(s.dof_node[dof]);
    const int axis = s.dof_component[dof];
    if (axis > 2) continue;  // a rotation
    for (auto entry = first; entry != end; ++entry)
      entries.emplace_back(dof, entry->second, forces.direction(entry->second, axis));
  }
  SparseMatrix B(s.c(), forces.size());
  B.setFromTriplets(entries.begin(), entries.end());
  return B;
}

InteriorInertia interior_inertia(const Interior& interior) {
  const RigidMotions& rigid = interior.p.rigid;
  InteriorInertia inertia;
  inertia.R_C = Matrix(rigid.R_C);
  if (rigid.count() == 0) return inertia;
  const Matrix P_I = Matrix(rigid.P_I);
  Matrix X = P_I;
  interior.solve_in_place(X);
  inertia.Q = interior.inner(P_I, X);
  return inertia;
}

Matrix inertia_of(const InteriorInertia& inertia, const Matrix& R) {
  if (inertia.Q.size() == 0) return Matrix::Zero(R.cols(), R.cols());
  const Matrix X = PivotedQr(inertia.R_C).solve(R);
  return X.transpose() * inertia.Q * X;
}

namespace {

// B^T V_e diag(1 / sqrt(eigenvalues))   (s x e)
Matrix of_elastic_modes(const StaticShare& forces, Index n_rigid, const Superelement& s) {
  const Index e = s.k() - n_rigid;
  const Matrix V = forces_on_dofs(forces, s).transpose() * s.characteristic.V;
  return V.rightCols(e) * s.eigenvalues.tail(e).cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace

Matrix answers_that_are_left(Matrix CX, const Matrix& X, const StaticShare& forces, Index n_rigid,
                             const Superelement& s) {
  const Matrix G = of_elastic_modes(forces, n_rigid, s), GX = G.transpose() * X;
  CX.noalias() -= G * GX;
  return CX;
}

Matrix compliance_that_is_left(Matrix C, const StaticShare& forces, Index n_rigid,
                               const Superelement& s) {
  const Matrix G = of_elastic_modes(forces, n_rigid, s);
  C.selfadjointView<Eigen::Lower>().rankUpdate(G, -1);
  // Nothing left of a node's own is round-off, which may have either sign
  for (Index i = 0; i < C.rows(); ++i) C(i, i) = std::max(C(i, i), 0.0);
  mirror_lower(C);
  return C;
}

}  // namespace cbr

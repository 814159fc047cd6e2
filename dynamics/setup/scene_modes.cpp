// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/scene_modes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "common/error.hpp"
#include "common/linalg/eigenpairs.hpp"
#include "dynamics/bodies/characteristic_form.hpp"
#include "dynamics/setup/instance_body.hpp"
#include "dynamics/setup/instance_damping.hpp"
#include "dynamics/setup/skin_shells.hpp"
#include "dynamics/setup/superelement_alone.hpp"

namespace cbr {
namespace {

// The shift of free meshes, of their mean stiffness over mass: far below elastic modes, far above round-off.
constexpr double shift = 1e-9;
// Rigid motions come out at some round-off of that.
constexpr double rigid_share = 1e-3;

void refuse_what_joins(const Scene& scene) {
  for (const ContactOptions& contact : scene.contact)
    if (contact.tied)
      throw InputError(contact.source.text() +
                       ": contact: tied: --modes knows instances one by one, not joined: leave the entry out");
  if (skin_acts(scene))
    throw InputError(scene.skin->source.text() +
                     ": skin: --modes leaves out no shells that act: give a thickness of 0, or leave the skin out");
}

Vector frequencies_of(const SceneIndex& index, const Instance& instance, const ReducedComponent& component) {
  const std::string where = "instance '" + instance.name + "'";
  const std::vector<HeldDirection> held = held_directions(index, instance, *component.geometry);
  const Superelement& s = *component.superelement;
  if (component.statics)
    return held.empty() ? component.statics->modal.omega : held_statics_form(s, *component.statics, held, where)->modal.omega;
  if (held.empty()) return component.form->omega;
  return s.is_characteristic() ? held_characteristic_form(s, held, where).omega : held_diagonal_form(s, held, where).omega;
}

// Orthonormal basis of what the held directions leave free   (3 n x free).
SparseMatrix free_basis(Index n, const std::vector<HeldDirection>& held) {
  std::vector<std::vector<Vector3>> of_node(static_cast<std::size_t>(n));
  for (const HeldDirection& direction : held) of_node[static_cast<std::size_t>(direction.node)].push_back(direction.direction);
  std::vector<Eigen::Triplet<double, Index>> entries;
  Index column = 0;
  for (Index node = 0; node < n; ++node) {
    const auto& directions = of_node[static_cast<std::size_t>(node)];
    const Matrix3 Q = complete_basis(directions);
    for (Index f = static_cast<Index>(directions.size()); f < 3; ++f, ++column)
      for (int c = 0; c < 3; ++c)
        if (Q(c, f) != 0) entries.emplace_back(3 * node + c, column, Q(c, f));
  }
  SparseMatrix Z(3 * n, column);
  Z.setFromTriplets(entries.begin(), entries.end());
  return Z;
}

Vector frequencies_of(const SceneIndex& index, const Instance& instance, const MeshedComponent& component, Index n) {
  const std::string where = "instance '" + instance.name + "'";
  const SparseMatrix Z = free_basis(component.geometry->coordinates.rows(), held_directions(index, instance, *component.geometry));
  const SparseMatrix K = Z.transpose() * component.fe->K * Z, M = Z.transpose() * component.fe->M * Z;
  if (K.rows() == 0) return {};
  const double sigma = -shift * K.diagonal().sum() / M.diagonal().sum();
  const SparseCholesky factor(SparseMatrix(K - sigma * M));
  if (!factor.ok()) throw RunError(where + ": the stiffness of the mesh is not positive semidefinite");
  const Eigenpairs pairs = sparse_eigenpairs(K, M, factor, sigma, std::min(n, static_cast<Index>(K.rows())));
  if (!pairs.converged) throw RunError(where + ": the frequencies of the mesh did not converge");
  Vector omega(pairs.lambda.size());
  for (Index j = 0; j < omega.size(); ++j) omega[j] = pairs.lambda[j] > -rigid_share * sigma ? std::sqrt(pairs.lambda[j]) : 0;
  return omega;
}

InstanceModes modes_of(const SceneIndex& index, const Instance& instance, const Vector& all, Index n) {
  Vector omega = all;
  std::sort(omega.begin(), omega.end());
  omega.conservativeResize(std::min(n, static_cast<Index>(omega.size())));
  InstanceModes modes{instance.name, omega / (2 * std::numbers::pi), Vector::Zero(omega.size())};
  const Damping damping = damping_of(index, instance);
  if (damping.none()) return modes;
  if (instance.as == InstanceKind::mesh && damping.needs_modes())
    throw InputError(instance.source.text() + ": instance '" + instance.name +
                     "': loss_factor cannot be had with as: mesh: use as: superelement");
  const Vector c = damping.rates(omega).c;
  for (Index j = 0; j < omega.size(); ++j) modes.damping_ratio[j] = omega[j] > 0 ? c[j] / (2 * omega[j]) : 0;
  return modes;
}

}  // namespace

std::vector<InstanceModes> scene_modes(const Scene& scene_of_run, Index n, Report& report) {
  Scene scene = with_options_of_files(scene_of_run);
  // Every superelement in its diagonal form
  scene.time = TimeOptions{};
  if (scene.instances.empty()) throw InputError(scene.file.string() + ": the scene has no instances");
  refuse_what_joins(scene);
  const SceneIndex index(scene);
  std::map<std::string, ReducedComponent> reduced;
  std::map<std::string, MeshedComponent> meshed;
  std::vector<InstanceModes> all;
  for (const Instance& instance : scene.instances) {
    const Component& component = component_of(scene, instance);
    Vector omega;
    if (instance.as == InstanceKind::superelement) {
      if (reduced.count(component.name) == 0) {
        check_reduced_component(scene, component, report);
        reduced[component.name] = read_reduced_component(index, component, {}, report);
      }
      omega = frequencies_of(index, instance, reduced.at(component.name));
    } else {
      if (meshed.count(component.name) == 0) meshed[component.name] = read_meshed_component(scene, component, report);
      omega = frequencies_of(index, instance, meshed.at(component.name), n);
    }
    all.push_back(modes_of(index, instance, omega, n));
  }
  return all;
}

}  // namespace cbr

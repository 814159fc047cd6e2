// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build_steps.hpp"

#include <map>
#include <string>
#include <unordered_set>
#include <utility>

#include "common/base/error.hpp"
#include "common/mesh/face_weights.hpp"
#include "common/scene/limits.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/setup/contact/points.hpp"

namespace cbr {
namespace {

bool is_nodeset(const Geometry& geometry, const std::string& name) {
  return geometry.surfaces.count(name) == 0 && geometry.nodesets.count(name) > 0;
}

// A load on faces that a superelement does not retain but has in its /loads; nullptr: none of this
// name.
const Superelement::InteriorLoad* load_inside(const BuiltScene::OfInstance& of,
                                              const std::string& surface) {
  if (of.parts.size() != 1 || of.geometry->surfaces.count(surface) > 0) return nullptr;
  const auto& loads = of.parts[0].superelement->loads;
  const auto found = loads.find(surface);
  return found != loads.end() ? &found->second : nullptr;
}

// InputError if a superelement lacks an interior load that cbr-reduce would add.
void require_load_inside(const Scene& scene, const Instance& instance, const Geometry& geometry,
                         const Load& load) {
  if (!geometry.reduced || geometry.surfaces.count(load.surface) > 0 ||
      is_nodeset(geometry, load.surface))
    return;
  const Component& component = component_of(scene, instance);
  if (!component.has_mesh) return;  // it cannot be reduced again
  const ReductionOptions& reduction = *component.reduction;
  if (reduction.is_decomposed() || reduction.basis != Basis::craig_bampton) return;
  std::vector<std::string> kept;
  for (const auto& [name, surface] : geometry.surfaces) kept.push_back(name);
  const std::string found = load.source.text() + ": the superelement of instance '" +
                            load.instance + "' has no surface '" + load.surface + "' (it keeps " +
                            (kept.empty() ? "none" : join(kept)) + ")";
  if (load.kind == Load::Kind::moment)
    throw InputError(found + ", on which a moment could act: add it to reduction.interface");
  throw InputError(found +
                   ", nor a load on it inside the part: run cbr-reduce on this scene again, which "
                   "takes in a load on a sideset, "
                   "or add it to reduction.interface, where a nodeset has to be");
}

// Returns the resultant.
Vector3 add_load_inside(const Superelement& s, const Superelement::InteriorLoad& inside,
                        const Load& load, const Matrix3& T, Index n_nodes,
                        const LoadHistory& history, std::vector<BodyLoad>& loads) {
  const Vector3 traction =
      load.kind == Load::Kind::force ? Vector3(load.value / inside.weight) : load.value;
  VectorForce vector{{}, traction, load.follows};
  for (Index a = 0; a < 3; ++a) {
    // on [q_k; u_c], component axes
    const Vector Q = inside.force * (T.transpose() * Vector3::Unit(a));
    Points forces = Points::Zero(n_nodes, 3);
    for (Index i = 0; i < s.c(); ++i) forces(s.dof_node[i], s.dof_component[i] % 3) = Q(s.k() + i);
    vector.patterns[a] = {Points(forces * T.transpose()), Q.head(s.k())};
  }
  loads.push_back({.vector = std::move(vector), .history = history});
  return inside.weight * traction;
}

// Adds a pressure, positive into the faces: -p times the nodes' area vectors along outward normals.
// Returns the resultant.
Vector3 add_pressure(const Load& load, const BuiltScene::OfInstance& of, const LoadHistory& history,
                     std::vector<BodyLoad>& loads) {
  const Geometry& geometry = *of.geometry;
  if (is_nodeset(geometry, load.surface)) refuse(load, feature::nodeset);
  if (load_inside(of, load.surface) != nullptr) refuse(load, feature::inside);
  const Surface& surface = find_surface(geometry, load.instance, load.surface, load.source);
  const Points forces =
      -load.value[0] * face_normals(surface, geometry.coordinates) * of.placement.T.transpose();
  if (load.follows) {
    loads.push_back({.vector = VectorForce{{ForcePattern{forces}}, Vector3::UnitX(), true},
                     .history = history});
  } else {
    loads.push_back(force_load(forces, history));
  }
  return forces.colwise().sum().transpose();
}

// Weights of the nodes (n) of a load: tributary areas, or one for a nodeset.
Vector load_weights(const Geometry& geometry, const Load& load) {
  if (geometry.surfaces.count(load.surface) > 0 || load.kind == Load::Kind::traction)
    return face_weights(find_surface(geometry, load.instance, load.surface, load.source),
                        geometry.coordinates);
  Vector weights = Vector::Zero(geometry.coordinates.rows());
  weights(find_nodes(geometry, load.instance, load.surface, load.source)).setOnes();
  return weights;
}

// Adds a moment on the nodes of a set. The forces have that moment, no resultant, and the least
// weighted sum of squares, as for an averaged point (RBE3).
void add_moment(const Load& load, const Instance& instance, const BuiltScene::OfInstance& of,
                const Points& positions, const LoadHistory& history, std::vector<BodyLoad>& loads) {
  const Geometry& geometry = *of.geometry;
  if (load_inside(of, load.surface) != nullptr) refuse(load, feature::inside);
  const Vector weights = load_weights(geometry, load);
  AveragePoint point;
  for (Index i = 0; i < weights.size(); ++i)
    if (weights[i] > 0) point.nodes.push_back(i);
  point.weights = weights(point.nodes);
  point.at = Vector3::Zero();
  if (!of.is_rigid) add_rotations(geometry, instance, positions, point);
  point.where =
      load.source.text() + ": moment on '" + load.surface + "' of instance '" + load.instance + "'";
  const AverageMaps maps = average_maps(point, positions);
  VectorForce vector{{}, load.value, load.follows};
  for (std::size_t a = 0; a < 3; ++a) {
    Points forces = Points::Zero(weights.size(), 3);
    for (std::size_t i = 0; i < point.nodes.size(); ++i)
      forces.row(point.nodes[i]) = maps.theta[i].row(static_cast<Index>(a));
    vector.patterns[a].forces = forces;
  }
  loads.push_back({.vector = std::move(vector), .history = history});
}

// Adds forces of `weights` times the traction.
void add_traction(const Vector& weights, const Vector3& traction, const Load& load,
                  const LoadHistory& history, std::vector<BodyLoad>& loads) {
  VectorForce vector{{}, traction, load.follows};
  for (Index a = 0; a < 3; ++a)
    vector.patterns[a].forces = Points(weights * Vector3::Unit(a).transpose());
  loads.push_back({.vector = std::move(vector), .history = history});
}

// For the reactions of supports.
void add_resultant(Index body, const Vector3& force, const LoadHistory& history,
                   Simulation& simulation) {
  if (simulation.supports.empty() || !simulation.supports[body]) return;
  simulation.supports[body]->loads.push_back({force, history});
}

}  // namespace

// Surfaces and histories are shared among loads.
std::vector<BodyPlan> body_plans(const SceneIndex& index, BuiltScene& built) {
  std::vector<BodyPlan> plans(built.simulation.bodies.size());
  std::map<std::pair<const Geometry*, std::string>, Vector> weights;
  std::unordered_set<LoadHistory, LoadHistory::Hash> histories;
  for (const Load& load : index.scene().loads) {
    built.momentum_is_kept = false;
    const LoadHistory& history = *histories.emplace(load.history).first;
    if (load.kind == Load::Kind::gravity) {
      for (std::size_t b = 0; b < built.instances.size(); ++b) {
        plans[b].loads.push_back(gravity_load(load.value, history));
        add_resultant(static_cast<Index>(b), built.instances[b].mass * load.value, history,
                      built.simulation);
      }
      for_each_point(index, [&](Index i, const std::string& name, const Component::Point& point) {
        if (!(point.mass > 0)) return;
        const Index place = point_place(index, index.scene().instances[i].name, name);
        plans[i].loads.push_back(built.simulation.bodies[i]->points()->point_load(
            true, place, point.mass * load.value, history));
        add_resultant(i, point.mass * load.value, history, built.simulation);
      });
      continue;
    }
    const Index i = index.place(load.instance);
    std::vector<BodyLoad>& loads = plans[i].loads;
    const Geometry& geometry = *built.instances[i].geometry;
    if (load.on_point) {
      const bool is_force = load.kind == Load::Kind::force;
      const Index place = point_place(index, load.instance, load.surface);
      loads.push_back(built.simulation.bodies[i]->points()->point_load(is_force, place, load.value,
                                                                       history, load.follows));
      add_resultant(i, is_force ? load.value : Vector3::Zero(), history, built.simulation);
      continue;
    }
    if (load.kind == Load::Kind::pressure) {
      const Vector3 force = add_pressure(load, built.instances[i], history, loads);
      add_resultant(i, force, history, built.simulation);
      continue;
    }
    const Points& X = built.simulation.bodies[i]->reference_positions();
    if (load.kind == Load::Kind::moment) {
      require_load_inside(index.scene(), index.scene().instances[i], geometry, load);
      add_moment(load, index.scene().instances[i], built.instances[i], X, history, loads);
      continue;
    }
    if (const auto* inside = load_inside(built.instances[i], load.surface)) {
      const Superelement& s = *built.instances[i].parts[0].superelement;
      const Vector3 force = add_load_inside(s, *inside, load, built.instances[i].placement.T,
                                            X.rows(), history, loads);
      add_resultant(i, force, history, built.simulation);
      continue;
    }
    require_load_inside(index.scene(), index.scene().instances[i], geometry, load);
    if (load.kind == Load::Kind::traction && is_nodeset(geometry, load.surface))
      refuse(load, feature::nodeset);
    const auto [of, is_new] = weights.try_emplace({&geometry, load.surface});
    if (is_new) of->second = load_weights(geometry, load);
    const Vector3 traction =
        load.kind == Load::Kind::force ? Vector3(load.value / of->second.sum()) : load.value;
    add_traction(of->second, traction, load, history, loads);
    add_resultant(i, of->second.sum() * traction, history, built.simulation);
  }
  return plans;
}

}  // namespace cbr

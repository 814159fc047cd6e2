// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <unordered_set>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/scene/scene_uses.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/setup/bodies/instance_body.hpp"
#include "dynamics/setup/bodies/instance_damping.hpp"
#include "dynamics/setup/bodies/turning.hpp"
#include "dynamics/setup/components/skin_shells.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"
#include "dynamics/setup/contact/contact_setup.hpp"
#include "dynamics/setup/contact/links.hpp"
#include "dynamics/setup/contact/starting_overlap.hpp"
#include "dynamics/setup/scene_warnings.hpp"
#include "dynamics/setup/statics_setup.hpp"
#include "dynamics/setup/stress_setup.hpp"

namespace cbr {
namespace {

bool is_nodeset(const Geometry& geometry, const std::string& name) {
  return geometry.surfaces.count(name) == 0 && geometry.nodesets.count(name) > 0;
}

// A load on faces that a superelement has not kept but knows (its /loads); nullptr: there are none
// of this name.
const Superelement::InteriorLoad* load_inside(const BuiltScene::OfInstance& of,
                                              const std::string& surface) {
  if (of.parts.size() != 1 || of.geometry->surfaces.count(surface) > 0) return nullptr;
  const auto& loads = of.parts[0].superelement->loads;
  const auto found = loads.find(surface);
  return found != loads.end() ? &found->second : nullptr;
}

// Of a superelement that could have it: cbr-reduce takes in what the scene's loads act on.
void require_load_inside(const Scene& scene, const Instance& instance, const Geometry& geometry,
                         const Load& load) {
  if (!geometry.reduced || geometry.surfaces.count(load.surface) > 0 ||
      is_nodeset(geometry, load.surface))
    return;
  const Component& component = component_of(scene, instance);
  if (!component.has_mesh) return;  // nobody reduces it again
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
                        const Load& load, const Matrix3& T, const LoadHistory& history,
                        Body& body) {
  const Vector3 traction =
      load.kind == Load::Kind::force ? Vector3(load.value / inside.weight) : load.value;
  VectorLoad vector{{}, traction, load.follows, history};
  for (Index a = 0; a < 3; ++a) {
    // on [q_k; u_c], component axes
    const Vector Q = inside.force * (T.transpose() * Vector3::Unit(a));
    Points forces = Points::Zero(body.n_nodes(), 3);
    for (Index i = 0; i < s.c(); ++i) forces(s.dof_node[i], s.dof_component[i] % 3) = Q(s.k() + i);
    vector.patterns[static_cast<std::size_t>(a)] = {forces * T.transpose(), Q.head(s.k())};
  }
  body.add_vector_load(vector);
  return inside.weight * traction;
}

// A pressure pushes into the faces: -p times the nodes' share of the area, as vectors along the
// outward normals. Returns the resultant.
Vector3 add_pressure(const Load& load, const BuiltScene::OfInstance& of, const LoadHistory& history,
                     Body& body) {
  const Geometry& geometry = *of.geometry;
  if (is_nodeset(geometry, load.surface))
    throw InputError(
        load.source.text() + ": '" + load.surface + "' of instance '" + load.instance +
        "' is a nodeset, which has no normals: give force, or the pressure on a sideset");
  if (geometry.surfaces.count(load.surface) == 0 && load_inside(of, load.surface) != nullptr)
    throw InputError(load.source.text() + ": a pressure on '" + load.surface +
                     "' inside the superelement of instance '" + load.instance +
                     "' is not known: add the sideset to reduction.interface, or give traction");
  const Surface& surface = find_surface(geometry, load.instance, load.surface, load.source);
  const Points forces =
      -load.value[0] * face_normals(surface, geometry.coordinates) * of.placement.T.transpose();
  if (load.follows) {
    body.add_vector_load({{ForcePattern{forces}}, Vector3::UnitX(), true, history});
  } else {
    body.add_force(forces, history);
  }
  return forces.colwise().sum().transpose();
}

// What each node takes of a load, n: its share of the faces' area, or one, of a nodeset.
Vector load_weights(const Geometry& geometry, const Load& load) {
  if (geometry.surfaces.count(load.surface) > 0 || load.kind == Load::Kind::traction)
    return face_weights(find_surface(geometry, load.instance, load.surface, load.source),
                        geometry.coordinates);
  Vector weights = Vector::Zero(geometry.coordinates.rows());
  weights(find_nodes(geometry, load.instance, load.surface, load.source)).setOnes();
  return weights;
}

// A moment on the nodes of a set: the forces of least weighted squares that have it and no
// resultant, as those on a point that moves with the set in the mean (RBE3).
void add_moment(const Load& load, const BuiltScene::OfInstance& of, const LoadHistory& history,
                Body& body) {
  const Geometry& geometry = *of.geometry;
  if (geometry.surfaces.count(load.surface) == 0 && load_inside(of, load.surface) != nullptr)
    throw InputError(load.source.text() + ": a moment on '" + load.surface +
                     "' inside the superelement of instance '" + load.instance +
                     "' is not known: add the set to reduction.interface");
  const Vector weights = load_weights(geometry, load);
  AveragePoint point;
  for (Index i = 0; i < weights.size(); ++i)
    if (weights[i] > 0) point.nodes.push_back(i);
  point.weights = weights(point.nodes);
  point.at = Vector3::Zero();
  const AverageMaps maps = average_maps(point, body.reference_positions(),
                                        load.source.text() + ": moment on '" + load.surface +
                                            "' of instance '" + load.instance + "'");
  VectorLoad vector{{}, load.value, load.follows, history};
  for (std::size_t a = 0; a < 3; ++a) {
    Points& forces = vector.patterns[a].forces;
    forces.setZero(weights.size(), 3);
    for (std::size_t i = 0; i < point.nodes.size(); ++i)
      forces.row(point.nodes[i]) = maps.theta[i].row(static_cast<Index>(a));
  }
  body.add_vector_load(vector);
}

// A force on each node of `weights` times the traction.
void add_traction(const Vector& weights, const Vector3& traction, const Load& load,
                  const LoadHistory& history, Body& body) {
  VectorLoad vector{{}, traction, load.follows, history};
  for (Index a = 0; a < 3; ++a)
    vector.patterns[static_cast<std::size_t>(a)].forces = weights * Vector3::Unit(a).transpose();
  body.add_vector_load(vector);
}

// For the reactions of supports.
void add_resultant(Index body, const Vector3& force, const LoadHistory& history,
                   Simulation& simulation) {
  if (simulation.supports.empty() || !simulation.supports[body]) return;
  simulation.supports[body]->loads.push_back({force, history});
}

// Of surfaces and histories that many loads have there is one of each.
void add_loads(const SceneIndex& index, BuiltScene& built) {
  std::map<std::pair<const Geometry*, std::string>, Vector> weights;
  std::unordered_set<LoadHistory, LoadHistory::Hash> histories;
  for (const Load& load : index.scene().loads) {
    built.momentum_is_kept = false;
    const LoadHistory& history = *histories.emplace(load.history).first;
    if (load.kind == Load::Kind::gravity) {
      for (std::size_t b = 0; b < built.instances.size(); ++b) {
        built.simulation.bodies[b]->add_gravity(load.value, history);
        add_resultant(static_cast<Index>(b), built.instances[b].mass * load.value, history,
                      built.simulation);
      }
      for_each_point(index, [&](Index i, const std::string& name, const Component::Point& point) {
        if (!(point.mass > 0)) return;
        const Index place = point_place(index, index.scene().instances[i].name, name);
        static_cast<PointedBody&>(*built.simulation.bodies[i])
            .add_point_force(place, point.mass * load.value, Vector3::Zero(), history);
        add_resultant(i, point.mass * load.value, history, built.simulation);
      });
      continue;
    }
    const Index i = index.place(load.instance);
    const Geometry& geometry = *built.instances[i].geometry;
    if (load.on_point) {
      const bool is_force = load.kind == Load::Kind::force;
      const Vector3 force = is_force ? load.value : Vector3::Zero(),
                    moment = is_force ? Vector3::Zero() : load.value;
      static_cast<PointedBody&>(*built.simulation.bodies[i])
          .add_point_force(point_place(index, load.instance, load.surface), force, moment, history);
      add_resultant(i, force, history, built.simulation);
      continue;
    }
    if (load.kind == Load::Kind::pressure) {
      const Vector3 force =
          add_pressure(load, built.instances[i], history, *built.simulation.bodies[i]);
      add_resultant(i, force, history, built.simulation);
      continue;
    }
    if (load.kind == Load::Kind::moment) {
      require_load_inside(index.scene(), index.scene().instances[i], geometry, load);
      add_moment(load, built.instances[i], history, *built.simulation.bodies[i]);
      continue;
    }
    if (const auto* inside = load_inside(built.instances[i], load.surface)) {
      const Superelement& s = *built.instances[i].parts[0].superelement;
      const Vector3 force = add_load_inside(s, *inside, load, built.instances[i].placement.T,
                                            history, *built.simulation.bodies[i]);
      add_resultant(i, force, history, built.simulation);
      continue;
    }
    require_load_inside(index.scene(), index.scene().instances[i], geometry, load);
    if (load.kind == Load::Kind::traction && is_nodeset(geometry, load.surface))
      refuse_traction_on_nodes(load);
    const auto [of, is_new] = weights.try_emplace({&geometry, load.surface});
    if (is_new) of->second = load_weights(geometry, load);
    const Vector3 traction =
        load.kind == Load::Kind::force ? Vector3(load.value / of->second.sum()) : load.value;
    add_traction(of->second, traction, load, history, *built.simulation.bodies[i]);
    add_resultant(i, of->second.sum() * traction, history, built.simulation);
  }
}

void add_monitors(const SceneIndex& index, BuiltScene& built) {
  Simulation& sim = built.simulation;
  std::vector<Index> contact_of_body(sim.bodies.size(), -1);
  for (std::size_t c = 0; c < sim.contact_nodes.size(); ++c)
    contact_of_body[sim.contact_nodes[c].body] = static_cast<Index>(c);
  for (const SurfaceName& surface : index.scene().output.history) {
    Monitor monitor;
    monitor.name = surface.text();
    monitor.body = index.place(surface.instance);
    if (point_of(index.scene(), surface.instance, surface.surface) != nullptr) {
      monitor.pointed = static_cast<const PointedBody*>(sim.bodies[monitor.body].get());
      monitor.point = point_place(index, surface.instance, surface.surface);
      sim.monitors.push_back(std::move(monitor));
      continue;
    }
    const BuiltScene::OfInstance& of = built.instances[monitor.body];
    if (is_inside(*of.geometry, surface.surface)) {
      watch_inside(index, surface, of, monitor);
      sim.monitors.push_back(std::move(monitor));
      continue;
    }
    const auto nodes = find_nodes(*of.geometry, surface.instance, surface.surface, surface.source);
    monitor.mean_set = sim.bodies[monitor.body]->track_mean(nodes);
    monitor.contact = contact_of_body[monitor.body];
    if (monitor.contact >= 0) {
      const auto& contact = sim.contact_nodes[monitor.contact].nodes;
      for (std::size_t slot = 0; slot < contact.size(); ++slot)
        if (std::binary_search(nodes.begin(), nodes.end(), contact[slot]))
          monitor.contact_slots.push_back(static_cast<Index>(slot));
    }
    sim.monitors.push_back(std::move(monitor));
  }
}

void refuse_what_cannot_be(const Scene& scene) {
  if (!scene.time)
    throw InputError(scene.file.string() +
                     ": the scene has no 'time' section: cbr-dyn needs time: {end: SECONDS}");
  if (scene.instances.empty())
    throw InputError(scene.file.string() + ": the scene has no instances");
  check_contact_with_time(scene);
  check_statics(scene);
  for (const ContactOptions& contact : scene.contact) {
    const std::string what =
        std::string("enforcement: ") + word_of(enforcement_words, contact.enforcement);
    if (scene.time->integrator == Integrator::exact && contact.enforcement == Enforcement::nodal &&
        skin_acts(scene))
      throw InputError(
          contact.source.text() + ": contact: " + what +
          " with shells that act (skin) needs integrator: " +
          "central-difference: the diagonal form of superelements with shells has no nodal masses");
  }
}

// Exact bodies that only impulses meet answer as to forces that last. Penalty and nodal enforcement
// are kept as they are published.
void set_contact_step(const std::vector<ContactKind>& contact, BuiltScene& built) {
  const Simulation& sim = built.simulation;
  std::vector<char> only_impulses(contact.size(), 1);
  for (const ContactPair& pair : sim.pairs) {
    if (pair.enforcement == Enforcement::impulse) continue;
    for (const Index c : {pair.slave->body, pair.master->body})
      only_impulses[sim.contact_nodes[c].body] = 0;
  }
  for (std::size_t b = 0; b < contact.size(); ++b)
    if (contact[b] != ContactKind::none && only_impulses[b])
      sim.bodies[b]->set_contact_step(sim.plan.h);
}

// Modal mass scaling of what touches: modes above 2 / step. What does not is as it was.
void scale_bodies(const std::vector<ContactKind>& contact, BuiltScene& built) {
  const double clip = built.simulation.plan.clip;
  for (std::size_t b = 0; b < contact.size(); ++b) {
    Body& body = *built.simulation.bodies[b];
    if (ScalingAbility* scaling = body.scaling())
      scaling->scale(clip > 0 && contact[b] != ContactKind::none ? clip : HUGE_VAL);
  }
}

// The shortest time in which a history leaves a value and turns back.
double shortest_pulse(const History& history) {
  double shortest = std::numeric_limits<double>::infinity(), start = 0;
  int before = 0;
  for (std::size_t k = 1; k < history.time.size(); ++k) {
    const double change = history.value[k] - history.value[k - 1];
    const int sign = change > 0 ? 1 : change < 0 ? -1 : 0;
    if (sign == 0) continue;
    if (before == -sign) shortest = std::min(shortest, history.time[k] - start);
    if (before != sign) start = history.time[k - 1];
    before = sign;
  }
  return shortest;
}

// A pulse between two steps would leave no trace: only a body that moves exactly takes a load as it
// is between its steps.
void warn_of_missed_loads(const SceneIndex& index, const BuiltScene& built, Report& report) {
  const auto& bodies = built.simulation.bodies;
  const double h = built.simulation.plan.h;
  const bool any_sampled =
      std::any_of(bodies.begin(), bodies.end(), [](const auto& body) { return !body->is_exact(); });
  for (std::size_t i = 0; any_sampled && i < index.scene().loads.size(); ++i) {
    const Load& load = index.scene().loads[i];
    const bool sampled =
        load.kind == Load::Kind::gravity || !bodies[index.place(load.instance)]->is_exact();
    const double pulse = shortest_pulse(load.history);
    if (!sampled || pulse >= 2 * h * (1 - 1e-9)) continue;
    std::ostringstream text;
    text.precision(4);
    text << load.source.text() << ": loads[" << i << "].history rises and falls within " << pulse
         << " s, less than two steps of " << h
         << " s, and is seen at the ends of steps only: take a smaller step";
    report.warning(text.str());
  }
}

// A surface of the skin that no instance brings to cbr-dyn.
void require_skin(const Scene& scene, const BuiltScene& built) {
  if (!skin_acts(scene)) return;
  std::set<std::string> there_are;
  for (const auto& of : built.instances)
    for (const auto& [name, surface] : of.geometry->surfaces)
      there_are.insert(name), there_are.insert(of.name + "." + name);
  for (const std::string& name : scene.skin->surfaces)
    if (!there_are.count(name))
      throw InputError(scene.skin->source.text() + ": skin: surfaces: no instance has a surface '" +
                       name + "'" + nearest_name(name, {there_are.begin(), there_are.end()}) +
                       "; a superelement has those that its interface keeps (available: " +
                       join({there_are.begin(), there_are.end()}) + ")");
}

void note_shells(const Scene& scene, BuiltScene& built) {
  for (const auto& of : built.instances)
    if (of.n_shell_faces > 0)
      built.notes.push_back("skin: " + std::to_string(of.n_shell_faces) +
                            " shells of stiffness and mass on instance '" + of.name + "'");
  if (scene.skin && !skin_acts(scene))
    built.notes.push_back(
        "skin: the shells have no thickness, or no modulus and density: they do nothing and cost "
        "nothing");
}

// Components, each read once, and the instances made of them.
class Builder {
 public:
  Builder(const SceneIndex& index, const BuildOptions& options, Report& report, BuiltScene& built)
      : index_(index), scene_(index.scene()), options_(options), report_(report), built_(built) {}

  void add_instances() {
    check();
    for (const Instance& instance : scene_.instances) read(instance);
    const auto phase = report_.phase("setup");
    BodyMaker maker(index_, threads());
    for (const Instance& instance : scene_.instances) add(instance, maker);
    for (Index i = 0; i < static_cast<Index>(scene_.instances.size()); ++i) add_points(i);
  }

 private:
  // Before any file is read whole.
  void check() {
    std::set<std::string> checked;
    for (const Instance& instance : scene_.instances)
      if (instance.as == InstanceKind::superelement && checked.insert(instance.component).second)
        check_reduced_component(scene_, component_of(scene_, instance), report_);
  }

  void read(const Instance& instance) {
    const Component& component = component_of(scene_, instance);
    if (instance.as == InstanceKind::superelement) {
      if (!reduced_.count(component.name))
        reduced_[component.name] = read_reduced_component(index_, component, options_, report_);
    } else if (!meshed_.count(component.name)) {
      meshed_[component.name] = read_meshed_component(index_, component, options_, report_);
    }
  }

  // Threads pay when a product takes longer than bringing them together, and much longer than that
  // when the machine has other work.
  std::shared_ptr<RowThreads> threads() const {
    constexpr double worth_it = 1e-4;
    double longest = 0;
    for (const auto& [name, component] : meshed_)
      if (component.model) longest = std::max(longest, component.model->forces.estimated_seconds());
    return std::make_shared<RowThreads>(longest > worth_it ? n_threads() : 1);
  }

  void add_points(Index i) {
    const Instance& instance = scene_.instances[i];
    if (component_of(scene_, instance).points.empty()) return;
    auto& body = built_.simulation.bodies[i];
    body = std::make_unique<PointedBody>(
        std::move(body), points_of(index_, built_, i),
        instance.source.text() + ": points of instance '" + instance.name + "'");
  }

  void add(const Instance& instance, BodyMaker& maker) {
    BuiltScene::OfInstance of;
    of.name = instance.name, of.component = instance.component;
    of.placement = {instance.transformation(), instance.position, instance.velocity};
    InstanceBody made;
    if (instance.as == InstanceKind::superelement) {
      const ReducedComponent& component = reduced_.at(instance.component);
      of.geometry = component.geometry, of.parts = component.parts, of.n_modal = component.n_modal;
      made = maker.make(instance, component);
    } else {
      const MeshedComponent& component = meshed_.at(instance.component);
      of.geometry = component.geometry, of.mesh = component.mesh;
      of.is_rigid = instance.as == InstanceKind::rigid;
      of.properties = component.properties, of.body_node = component.body_node;
      made = maker.make(instance, component);
    }
    of.mass = made.mass;
    built_.notes.insert(built_.notes.end(), made.notes.begin(), made.notes.end());
    of.modes = made.modes;
    if (const Damping damping = damping_of(index_, instance); !damping.none()) {
      damp(instance, damping, *made.body);
      if (damping.material.alpha > 0) built_.momentum_is_kept = false;
    }
    of.n_shell_faces = skin_faces(scene_, instance.name, *of.geometry).rows();
    for (std::size_t i = 0; made.supported && i < made.supported->reaction_sets().size(); ++i)
      built_.simulation.reactions.push_back({instance.name, made.supported, i});
    built_.simulation.bodies.push_back(std::move(made.body));
    built_.simulation.supports.push_back(
        index_.is_held(instance) ? std::optional<Supports>(Supports()) : std::nullopt);
    built_.instances.push_back(std::move(of));
  }

  const SceneIndex& index_;
  const Scene& scene_;
  const BuildOptions& options_;
  Report& report_;
  BuiltScene& built_;
  std::map<std::string, ReducedComponent> reduced_;
  std::map<std::string, MeshedComponent> meshed_;
};

}  // namespace

BuiltScene build(const Scene& scene_of_run, Report& report, const BuildOptions& options) {
  Scene scene = with_options_of_files(scene_of_run);
  refuse_what_cannot_be(scene);
  if (scene.time->is_static) scene = with_growing_loads(std::move(scene));
  BuiltScene built;
  built.momentum_is_kept = scene.boundary.empty();
  const SceneIndex index(scene);
  refuse_what_does_not_turn(index);
  if (const std::string note = note_of_what_stays(index); !note.empty())
    built.notes.push_back(note);
  Builder(index, options, report, built).add_instances();
  require_skin(scene, built);
  note_shells(scene, built);
  const auto phase = report.phase("setup");
  const std::vector<ContactKind> in_contact = add_contact(index, built, report);
  add_loads(index, built);
  add_monitors(index, built);
  add_stress(index, built);
  built.gaps.start(built.simulation);
  built.simulation.is_static = scene.time->is_static;
  built.simulation.preload = preload_steps(scene);
  if (scene.time->is_static) {
    built.simulation.plan = plan_statics(*scene.time, scene.output.every);
  } else {
    built.simulation.plan =
        plan_time(*scene.time, scene.output.every, built.simulation.bodies, in_contact);
    set_contact_step(in_contact, built);
    scale_bodies(in_contact, built);
  }
  look_for_overlaps(scene, built, report);
  warn_of_odd_scenes(scene, built, report);
  warn_of_missed_loads(index, built, report);
  return built;
}

}  // namespace cbr

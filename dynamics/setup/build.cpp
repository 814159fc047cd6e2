// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/scene/scene_uses.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/motion/prescribed_motion.hpp"
#include "dynamics/setup/bodies/instance_body.hpp"
#include "dynamics/setup/bodies/instance_damping.hpp"
#include "dynamics/setup/bodies/turning.hpp"
#include "dynamics/setup/build_steps.hpp"
#include "dynamics/setup/built/instance_elements.hpp"
#include "dynamics/setup/components/skin_shells.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"
#include "dynamics/setup/contact/contact_setup.hpp"
#include "dynamics/setup/contact/link_rates.hpp"
#include "dynamics/setup/contact/points.hpp"
#include "dynamics/setup/contact/starting_overlap.hpp"

namespace cbr {
namespace {

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

// Springs and dashpots on rigid bodies are stable at any step, but inaccurate at long ones. They
// limit the step if nothing else does.
TimePlan plan_motion(const Scene& scene, const BuiltScene& built,
                     const std::vector<ContactKind>& in_contact) {
  const double every = scene.output.every;
  TimePlan plan = plan_time(*scene.time, every, built.simulation.bodies, in_contact);
  if (scene.time->step || plan.newmark_alpha) return plan;
  const LinkRate fastest = fastest_link(built);
  TimeOptions shorter = *scene.time;
  shorter.step = link_step(fastest, every, scene.time->end);
  if (!(*shorter.step > 0) || plan.h <= *shorter.step) return plan;
  plan = plan_time(shorter, every, built.simulation.bodies, in_contact);
  std::ostringstream limit;
  limit.precision(4);
  limit << "link '" << fastest.link << "' (" << fastest.rate << " rad/s)";
  plan.limit = limit.str();
  return plan;
}

// Exact bodies with impulses only respond to them as to constant forces in the step. Penalty and
// nodal enforcement stay as published.
void take_contact_step(const std::vector<ContactKind>& contact, const Simulation& sim,
                       std::vector<BodyPlan>& plans) {
  std::vector<char> only_impulses(contact.size(), 1);
  for (const ContactPair& pair : sim.pairs) {
    if (pair.enforcement == Enforcement::impulse) continue;
    for (const Index c : {pair.slave->body, pair.master->body})
      only_impulses[sim.contact_nodes[c].body] = 0;
  }
  for (std::size_t b = 0; b < contact.size(); ++b)
    if (contact[b] != ContactKind::none && only_impulses[b]) plans[b].contact_step = sim.plan.h;
}

// InputError: a surface of the skin that no instance has.
void require_skin(const Scene& scene, const BuiltScene& built) {
  if (!skin_acts(scene)) return;
  std::set<std::string> there_are;
  for (const auto& of : built.instances)
    for (const auto& [name, surface] : of.geometry->surfaces) {
      there_are.insert(name);
      there_are.insert(of.name + "." + name);
    }
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

// Components, each read once, and their instances.
class Builder {
 public:
  // refuses: large rotation that is not possible is an error; false: the instance stays linear.
  Builder(SceneIndex& index, const BuildOptions& options, bool refuses, Report& report,
          BuiltScene& built)
      : index_(index),
        scene_(index.scene()),
        options_(options),
        refuses_(refuses),
        report_(report),
        built_(built) {}

  void add_instances() {
    check();
    for (const Instance& instance : scene_.instances) read(instance);
    choose_what_turns();
    const auto phase = report_.phase("setup");
    BodyMaker maker(index_, threads());
    for (const Instance& instance : scene_.instances) add(instance, maker);
    for (Index i = 0; i < static_cast<Index>(scene_.instances.size()); ++i) add_points(i);
  }

 private:
  // Before any file is read completely.
  void check() {
    std::set<std::string> checked;
    for (const Instance& instance : scene_.instances)
      if (instance.as == InstanceKind::superelement && checked.insert(instance.component).second)
        check_reduced_component(options_.reduced_for != nullptr ? *options_.reduced_for : scene_,
                                component_of(scene_, instance), report_);
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

  void choose_what_turns() {
    for (const Instance& instance : scene_.instances) {
      why_linear_.push_back(why_linear(index_, instance));
      if (why_linear_.back().empty()) why_linear_.back() = why_made_linear(instance);
      if (why_linear_.back().empty() || !turns(index_, instance)) continue;
      if (refuses_ || !instance.angular_velocity.isZero(0))
        refuse_to_turn(instance, why_linear_.back());
      index_.keep_linear(instance);
    }
  }

  std::string why_made_linear(const Instance& instance) const {
    const std::string why = instance.as == InstanceKind::superelement
                                ? why_linear(reduced_.at(instance.component), instance)
                                : why_linear(meshed_.at(instance.component), instance);
    return why.empty() ? why_linear(damping_of(index_, instance)) : why;
  }

  // Threads pay if a product takes longer than their synchronisation, by a wide margin as the
  // machine may be busy.
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
    built_.simulation.bodies[i]->add_points(
        points_of(index_, built_, i),
        instance.source.text() + ": points of instance '" + instance.name + "'");
  }

  void add(const Instance& instance, BodyMaker& maker) {
    BuiltScene::OfInstance of;
    of.name = instance.name;
    of.component = instance.component;
    of.placement = {instance.transformation(), instance.position, instance.velocity};
    InstanceBody made;
    if (instance.as == InstanceKind::superelement) {
      const ReducedComponent& component = reduced_.at(instance.component);
      of.geometry = component.geometry;
      of.parts = component.parts;
      of.n_modal = component.n_modal;
      made = maker.make(instance, component);
    } else {
      const MeshedComponent& component = meshed_.at(instance.component);
      of.geometry = component.geometry;
      of.mesh = component.mesh;
      of.is_rigid = instance.as == InstanceKind::rigid;
      if (!of.is_rigid) {
        of.mass_kind = component.mass;
      }
      of.properties = component.properties;
      of.body_node = component.body_node;
      made = maker.make(instance, component);
    }
    of.mass = made.mass;
    of.n_following = made.n_following;
    of.why_linear = why_linear_[built_.instances.size()];
    built_.notes.insert(built_.notes.end(), made.notes.begin(), made.notes.end());
    of.modes = made.modes;
    if (damping_of(index_, instance).material.alpha > 0) built_.momentum_is_kept = false;
    of.n_shell_faces = skin_faces(scene_, instance.name, *of.geometry).rows();
    const PrescribedMotion* supports = made.body->supports();
    for (std::size_t i = 0; supports != nullptr && i < supports->sets().size(); ++i)
      built_.simulation.reactions.push_back({instance.name, made.body.get(), i});
    built_.simulation.bodies.push_back(std::move(made.body));
    built_.simulation.supports.push_back(
        index_.is_held(instance) ? std::optional<Supports>(Supports()) : std::nullopt);
    built_.instances.push_back(std::move(of));
  }

  SceneIndex& index_;
  const Scene& scene_;
  const BuildOptions& options_;
  const bool refuses_;
  Report& report_;
  BuiltScene& built_;
  std::vector<std::string> why_linear_;  // per instance
  std::map<std::string, ReducedComponent> reduced_;
  std::map<std::string, MeshedComponent> meshed_;
};

// Notes instances with large rotation, and the limits of others that allow it.
void note_turning(const SceneIndex& index, bool is_automatic, BuiltScene& built) {
  const Scene& scene = index.scene();
  if (scene.time->rotations == Rotations::small)
    built.large_is_refused = what_large_is_refused_for(scene);
  if (const std::string note = note_of_what_stays(index); !note.empty())
    built.notes.push_back(note);
  if (is_automatic && built.large_is_refused.empty()) built.turn_limit = turn_limits(index, built);
}

void watch_strains(BuiltScene& built) {
  Simulation& sim = built.simulation;
  if (!sim.is_static && sim.preload == 0) return;
  for (std::size_t i = 0; i < built.instances.size(); ++i) {
    const BuiltScene::OfInstance& of = built.instances[i];
    const Box box = extents(*sim.bodies[i], of);
    if (!of.is_rigid)
      built.strains.add(sim, static_cast<Index>(i), (box.upper - box.lower).maxCoeff(),
                        *of.geometry);
  }
}

}  // namespace

Scene with_rotations(Scene scene, const BuildOptions& options) {
  if (scene.time) scene.time->rotations = resolved(scene, options.turns);
  return scene;
}

BuiltScene build(const Scene& scene_of_run, Report& report, const BuildOptions& options) {
  Scene scene = with_options_of_files(scene_of_run);
  refuse_what_cannot_be(scene);
  if (scene.time->is_static) scene = with_growing_loads(std::move(scene));
  BuiltScene built;
  built.momentum_is_kept = scene.boundary.empty();
  const bool is_automatic = scene.time->rotations == Rotations::automatic;
  scene = with_rotations(std::move(scene), options);
  SceneIndex index(scene);
  refuse_what_does_not_turn(index);
  Builder(index, options, !is_automatic, report, built).add_instances();
  note_turning(index, is_automatic, built);
  require_skin(scene, built);
  note_shells(scene, built);
  const auto phase = report.phase("setup");
  const std::vector<ContactKind> in_contact = add_contact(index, built, report);
  std::vector<BodyPlan> plans = body_plans(index, built);
  add_monitors(index, built);
  add_stress(index, built);
  built.gaps.start(built.simulation);
  built.simulation.is_static = scene.time->is_static;
  built.simulation.preload = preload_steps(scene);
  watch_strains(built);
  if (scene.time->is_static) {
    built.simulation.plan = plan_statics(*scene.time, scene.output.every);
  } else {
    built.simulation.plan = plan_motion(scene, built, in_contact);
    take_contact_step(in_contact, built.simulation, plans);
  }
  for (std::size_t b = 0; b < plans.size(); ++b) built.simulation.bodies[b]->prepare(plans[b]);
  look_for_overlaps(scene, built, report);
  warn_of_odd_scenes(scene, built, report);
  warn_of_missed_loads(index, built, report);
  return built;
}

}  // namespace cbr

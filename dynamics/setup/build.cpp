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
#include "dynamics/motion/body_points.hpp"
#include "dynamics/motion/prescribed_motion.hpp"
#include "dynamics/run/simulation/time_plan.hpp"
#include "dynamics/setup/bodies/instance_body.hpp"
#include "dynamics/setup/bodies/turning.hpp"
#include "dynamics/setup/build_steps.hpp"
#include "dynamics/setup/built/instance_elements.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"
#include "dynamics/setup/contact/contact_setup.hpp"
#include "dynamics/setup/contact/points.hpp"
#include "dynamics/setup/contact/starting_overlap.hpp"

namespace cbr {
namespace {

void check_time_and_instances(const Scene& scene) {
  if (!scene.time)
    throw InputError(scene.file.string() +
                     ": the scene has no 'time' section: cbr-dyn needs time: {end: SECONDS}");
  if (scene.instances.empty())
    throw InputError(scene.file.string() + ": the scene has no instances");
}

// Loads without a history grow from 0 to their value at the end.
Scene with_growing_loads(Scene scene) {
  for (Load& load : scene.loads)
    if (load.history.time.empty()) load.history = {{0, scene.time->end}, {0, 1}};
  return scene;
}

// Load steps of time.step, or ten; adjusted to the outputs.
TimePlan plan_statics(const TimeOptions& time, double every) {
  constexpr double usual_steps = 10, most_steps = 1e6;
  const double h = time.step ? *time.step : time.end / usual_steps;
  if (time.end / h > most_steps) {
    std::ostringstream text;
    text << time.source.text() << ": time: " << time.end / h << " load steps, at most "
         << most_steps << " are allowed: take a longer time.step";
    throw InputError(text.str());
  }
  TimePlan plan = fit_steps(h, every, time.end);
  plan.limit = time.step ? "time.step" : "";
  return plan;
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
    for (InstancePlan& plan : index_.plans()) plan_rotation(scene_, plan);
    check_plans();
    const auto phase = report_.phase("setup");
    BodyMaker maker(index_, threads());
    for (const Instance& instance : scene_.instances) add(instance, maker);
    for (Index i = 0; i < static_cast<Index>(scene_.instances.size()); ++i) add_points(i);
  }

 private:
  // Before any file is read completely.
  void check() {
    for (InstancePlan& plan : index_.plans())
      if (scene_.time->rotations == Rotations::large && !plan.is_held() && !plan.is_fixed &&
          (refuses_ || plan.features.contains(feature::spin)))
        plan.features.try_emplace(feature::large_rotation, Asked{&plan.instance->source});
    check_plans();
    std::set<std::string> checked;
    for (const Instance& instance : scene_.instances)
      if (instance.as == InstanceKind::superelement && checked.insert(instance.component).second)
        check_reduced_component(options_.reduced_for != nullptr ? *options_.reduced_for : scene_,
                                component_of(scene_, instance), report_);
  }

  void check_plans() const {
    for (const InstancePlan& plan : index_.plans())
      check_limits(plan.features, "instance '" + plan.instance->name + "'");
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
    built_.simulation.bodies[i]->add_points(points_of(index_, built_, i));
  }

  void add(const Instance& instance, BodyMaker& maker) {
    const InstancePlan& plan = index_.plan(instance);
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
    of.why_linear = plan.why_linear;
    of.damping = plan.damping;
    for (const std::string& note : made.notes)
      if (std::find(built_.notes.begin(), built_.notes.end(), note) == built_.notes.end())
        built_.notes.push_back(note);
    of.modes = made.modes;
    if (plan.damping.material.alpha > 0) built_.momentum_is_kept = false;
    of.n_shell_faces = plan.n_shell_faces;
    const PrescribedMotion* supports = made.body->supports();
    for (std::size_t i = 0; supports != nullptr && i < supports->sets().size(); ++i)
      built_.simulation.reactions.push_back({instance.name, made.body.get(), i});
    built_.simulation.bodies.push_back(std::move(made.body));
    built_.simulation.supports.push_back(
        plan.is_held() || plan.is_fixed ? std::optional<Supports>(Supports()) : std::nullopt);
    built_.momentum_is_kept &= !plan.is_held() && !plan.is_fixed;
    built_.instances.push_back(std::move(of));
  }

  SceneIndex& index_;
  const Scene& scene_;
  const BuildOptions& options_;
  const bool refuses_;
  Report& report_;
  BuiltScene& built_;
  std::map<std::string, ReducedComponent> reduced_;
  std::map<std::string, MeshedComponent> meshed_;
};

// Notes instances with large rotation, and the limits of others that allow it.
void note_turning(const SceneIndex& index, bool is_automatic, BuiltScene& built) {
  if (const std::string note = note_of_what_stays(index); !note.empty())
    built.notes.push_back(note);
  if (is_automatic && allows_large(index.scene())) built.turn_limit = turn_limits(index, built);
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
  place_instances(scene, report);
  check_time_and_instances(scene);
  if (scene.time->is_static) scene = with_growing_loads(std::move(scene));
  BuiltScene built;
  const bool is_automatic = scene.time->rotations == Rotations::automatic;
  scene = with_rotations(std::move(scene), options);
  if (scene.time->rotations == Rotations::large) {
    Features of_run = features_of_run(scene);
    of_run[feature::large_rotation] = {&scene.time->source};
    check_limits(of_run, "time");
  }
  SceneIndex index(scene);
  Builder(index, options, !is_automatic, report, built).add_instances();
  note_turning(index, is_automatic, built);
  require_skin(scene, built);
  note_shells(scene, built);
  const auto phase = report.phase("setup");
  const std::vector<ContactKind> in_contact = add_contact(index, built, report);
  if (!built.turn_limit.empty()) built.will_turn = first_turning_strike(index, built);
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

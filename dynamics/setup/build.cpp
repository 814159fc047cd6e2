// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "common/error.hpp"
#include "common/program.hpp"
#include "dynamics/setup/contact_setup.hpp"

namespace cbr {
namespace {

Index instance_index(const Scene& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (scene.instances[i].name == name) return static_cast<Index>(i);
  return -1;  // read_scene has seen to it
}

bool is_held(const Scene& scene, const Instance& instance) {
  return std::any_of(scene.boundary.begin(), scene.boundary.end(), [&](const auto& b) { return b.instance == instance.name; });
}

bool is_nodal(const Scene& scene, const Instance& instance) {
  return std::any_of(scene.contact.begin(), scene.contact.end(), [&](const ContactOptions& c) {
    return c.enforcement == Enforcement::nodal &&
           (c.all || c.first.instance == instance.name || c.second.instance == instance.name);
  });
}

Placement placement_of(const Instance& instance) { return {instance.transformation(), instance.position, instance.velocity}; }

std::string scene_argument(const Scene& scene) { return scene.file == "-" ? "SCENE" : scene.file.string(); }

void require_current(const Scene& scene, const Component& component, const ReductionOptions& reduction) {
  const std::string& file = reduction.superelement.string();
  const std::string cure = ": run cbr-reduce " + scene_argument(scene);
  if (!std::filesystem::exists(reduction.superelement))
    throw InputError(component.source.text() + ": component '" + component.name + "': the superelement " + file +
                     " does not exist" + cure);
  const std::string hash = read_content_hash(reduction.superelement);
  if (hash.empty()) read_superelement(reduction.superelement);  // says what is wrong with a damaged or foreign file
  if (hash != content_hash(scene, component)) {
    throw InputError(component.source.text() + ": component '" + component.name + "': the superelement " + file +
                     " was not made from the present mesh, materials and reduction options" + cure);
  }
}

// The held directions of an instance in component axes; several conditions on one node are joined.
std::vector<HeldDirection> held_directions(const Scene& scene, const Instance& instance, const Geometry& geometry) {
  std::map<std::pair<Index, int>, bool> held;
  for (const BoundaryCondition& condition : scene.boundary) {
    if (condition.instance != instance.name) continue;
    for (const Index node : find_nodes(geometry, instance.name, condition.nodes, condition.source))
      for (int c = 0; c < 3; ++c)
        if (condition.fix[c]) held[{node, c}] = true;
  }
  const Matrix3 T = instance.transformation();
  std::vector<HeldDirection> list;
  // u_scene = T u, so e_c . u_scene = (T^T e_c) . u
  for (const auto& [at, unused] : held) list.push_back({at.first, T.row(at.second).transpose()});
  return list;
}

std::unique_ptr<SuperelementBody> superelement_instance(const Scene& scene, const Instance& instance, const ComponentModel& model) {
  std::shared_ptr<const DiagonalForm> form = model.form;
  if (is_held(scene, instance)) {
    form = std::make_shared<DiagonalForm>(held_diagonal_form(*model.superelement, held_directions(scene, instance, *model.geometry),
                                                             "instance '" + instance.name + "'"));
  }
  const Scheme scheme = scene.time->integrator == Integrator::exact ? Scheme::exact : Scheme::central_difference;
  return std::make_unique<SuperelementBody>(instance.name, model.superelement, form, placement_of(instance), scheme);
}

void add_loads(const Scene& scene, BuiltScene& built) {
  for (const Load& load : scene.loads) {
    built.momentum_is_kept = false;
    if (load.kind == Load::Kind::gravity) {
      for (auto& body : built.simulation.bodies) body->add_gravity(load.value, load.history);
      continue;
    }
    const Index i = instance_index(scene, load.instance);
    const Geometry& geometry = *built.instances[i].geometry;
    const Vector weights = face_weights(find_surface(geometry, load.instance, load.surface, load.source), geometry.coordinates);
    const double area = weights.sum();
    const Vector3 traction = load.kind == Load::Kind::force ? Vector3(load.value / area) : load.value;
    built.simulation.bodies[i]->add_force(weights * traction.transpose(), load.history);
  }
}

void add_monitors(const Scene& scene, BuiltScene& built) {
  Simulation& sim = built.simulation;
  for (const SurfaceName& surface : scene.output.history) {
    Monitor monitor;
    monitor.name = surface.text();
    monitor.body = instance_index(scene, surface.instance);
    const auto nodes = find_nodes(*built.instances[monitor.body].geometry, surface.instance, surface.surface, surface.source);
    monitor.mean_set = sim.bodies[monitor.body]->track_mean(nodes);
    for (std::size_t c = 0; c < sim.contact_nodes.size(); ++c) {
      if (sim.contact_nodes[c].body != monitor.body) continue;
      monitor.contact = static_cast<Index>(c);
      const auto& contact = sim.contact_nodes[c].nodes;
      for (std::size_t slot = 0; slot < contact.size(); ++slot)
        if (std::binary_search(nodes.begin(), nodes.end(), contact[slot]))
          monitor.contact_slots.push_back(static_cast<Index>(slot));
    }
    sim.monitors.push_back(std::move(monitor));
  }
}

void refuse_what_is_missing(const Scene& scene) {
  if (!scene.time) throw InputError(scene.file.string() + ": the scene has no 'time' section: cbr-dyn needs time: {end: SECONDS}");
  if (scene.time->integrator == Integrator::newmark) {
    throw InputError(scene.time->source.text() +
                     ": time.integrator: newmark is not available in this version (available: exact, central-difference)");
  }
  if (scene.instances.empty()) throw InputError(scene.file.string() + ": the scene has no instances");
}

void note_skin(const Scene& scene, BuiltScene& built) {
  if (!scene.skin || (scene.skin->youngs_modulus == 0 && scene.skin->density == 0)) return;
  built.notes.push_back(
      scene.skin->source.text() +
      ": skin: the fictitious shells carry no stiffness or mass yet in this version: contact uses the faces directly");
}

ComponentModel superelement_model(const Scene& scene, const Component& component) {
  if (!component.reduction) {
    throw InputError(component.source.text() + ": component '" + component.name +
                     "' is used as: superelement but has no 'reduction': add one and run cbr-reduce, or use as: mesh");
  }
  require_current(scene, component, *component.reduction);
  bool any_free = false, any_held = false, any_nodal = false;
  for (const Instance& instance : scene.instances) {
    if (instance.component != component.name || instance.as != InstanceKind::superelement) continue;
    (is_held(scene, instance) ? any_held : any_free) = true;
    any_nodal |= is_nodal(scene, instance);
  }
  SuperelementParts parts;
  parts.matrices = any_held || any_nodal;
  parts.diagonal = any_free;
  parts.recovery = !scene.output.fields.empty();
  ComponentModel model;
  model.superelement = std::make_shared<Superelement>(read_superelement(component.reduction->superelement, parts));
  if (any_free && !parts.matrices && !model.superelement->has_diagonal_form()) {
    parts.matrices = true;
    *model.superelement = read_superelement(component.reduction->superelement, parts);
  }
  model.geometry = std::make_shared<Geometry>(geometry_of(*model.superelement));
  return model;
}

// Everything that the instances of a component `as: mesh` share.
void add_mesh_model(const Scene& scene, const Component& component, Report& report, ComponentModel& model) {
  FiniteElementModel fe;
  {
    const auto phase = report.phase("read");
    model.mesh = std::make_shared<Mesh>(read_mesh(component.mesh));
  }
  const auto phase = report.phase("setup");
  model.properties = block_properties(scene, component, *model.mesh);
  fe = assemble(*model.mesh, model.properties, component.mass);
  model.body_node = fe.row;
  model.mesh_geometry = std::make_shared<Geometry>(geometry_of(*model.mesh, fe));
  model.mesh_model =
      std::make_shared<MeshModel>(mesh_model(fe, model.mesh_geometry->coordinates, component.mass == MassKind::lumped));
}

void add_instance(const Scene& scene, const Instance& instance, const ComponentModel& model,
                  const std::shared_ptr<RowThreads>& threads, BuiltScene& built) {
  BuiltScene::OfInstance of;
  of.name = instance.name, of.component = instance.component;
  of.placement = placement_of(instance);
  if (instance.as == InstanceKind::superelement) {
    of.geometry = model.geometry;
    of.superelement = model.superelement;
    of.mass = model.superelement->rigid_body.mass;
    auto body = superelement_instance(scene, instance, model);
    of.superelement_body = body.get();
    built.simulation.bodies.push_back(std::move(body));
  } else {
    of.geometry = model.mesh_geometry;
    of.mesh = model.mesh;
    of.properties = model.properties;
    of.body_node = model.body_node;
    of.mass = model.mesh_model->rigid_body.mass;
    built.simulation.bodies.push_back(std::make_unique<MeshBody>(instance.name, model.mesh_model, of.placement,
                                                                 held_directions(scene, instance, *model.mesh_geometry), threads));
  }
  built.instances.push_back(std::move(of));
}

}  // namespace

ComponentModel read_superelement_model(const Scene& scene, const Component& component, Report& report) {
  ComponentModel model;
  {
    const auto phase = report.phase("read");
    model = superelement_model(scene, component);
  }
  const bool any_free = std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& i) {
    return i.component == component.name && i.as == InstanceKind::superelement && !is_held(scene, i);
  });
  if (any_free) {
    const auto phase = report.phase("setup");
    model.form = std::make_shared<DiagonalForm>(free_diagonal_form(*model.superelement, "component '" + component.name + "'"));
  }
  return model;
}

BuiltScene build(const Scene& scene, Report& report) {
  refuse_what_is_missing(scene);
  BuiltScene built;
  built.momentum_is_kept = scene.boundary.empty();
  note_skin(scene, built);
  std::map<std::string, ComponentModel> models;
  for (const Instance& instance : scene.instances) {
    const Component& component = component_of(scene, instance);
    ComponentModel& model = models[component.name];
    if (instance.as == InstanceKind::superelement && !model.superelement) {
      const ComponentModel read = read_superelement_model(scene, component, report);
      model.superelement = read.superelement, model.form = read.form, model.geometry = read.geometry;
    }
    if (instance.as == InstanceKind::mesh && !model.mesh) add_mesh_model(scene, component, report, model);
  }
  const auto phase = report.phase("setup");
  // Threads pay when a product takes longer than waking them: some thousand nodes.
  Index largest = 0;
  for (const auto& [name, model] : models)
    if (model.mesh_model) largest = std::max(largest, model.mesh_model->K.rows());
  const auto threads = std::make_shared<RowThreads>(largest > 2000 ? n_threads() : 1);
  for (const Instance& instance : scene.instances) add_instance(scene, instance, models[instance.component], threads, built);
  const std::vector<ContactKind> in_contact = add_contact(scene, built, report);
  add_loads(scene, built);
  add_monitors(scene, built);
  built.simulation.plan = plan_time(*scene.time, scene.output.every, built.simulation.bodies, in_contact);
  return built;
}

}  // namespace cbr

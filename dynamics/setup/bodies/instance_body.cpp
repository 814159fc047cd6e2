// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/bodies/instance_body.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "common/scene/scene_uses.hpp"
#include "common/scene/static_forces.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "dynamics/motion/coupled/coupled_system.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"
#include "dynamics/motion/modal/forms/residual_compliance.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/motion/prescribed_motion.hpp"
#include "dynamics/setup/bodies/mesh_modes.hpp"
#include "dynamics/setup/bodies/support_motion.hpp"
#include "dynamics/setup/bodies/turning.hpp"
#include "dynamics/setup/components/contact_faces.hpp"

namespace cbr {
namespace {

// For a body in axes that follow the prescribed motion.
Placement placement_of(const SceneIndex& index, const Instance& instance) {
  const Vector3 of_supports = support_motion(index, instance).velocity(0);
  return {instance.transformation(), instance.position, instance.velocity - of_supports};
}

std::string where(const Instance& instance) { return "instance '" + instance.name + "'"; }

CoupledModel model_of(const MeshedComponent& component) {
  return coupled_model(*component.fe, component.geometry->coordinates);
}

CoupledModel model_of(const ReducedComponent& component) {
  if (component.parts.size() == 1) return coupled_model(component.parts.front().superelement);
  std::vector<std::shared_ptr<const Superelement>> domains;
  std::vector<std::vector<Index>> place;
  for (const ReducedPart& part : component.parts) {
    domains.push_back(part.superelement);
    place.push_back(part.node);
  }
  return coupled_model(domains, component.geometry->coordinates, place, component.rigid_body);
}

// The highest frequency (rad/s) that steps of time.cfl critical steps resolve, or steps of
// output.every, which bounds them; none if steps resolve all modes.
std::optional<double> limit_of_long_steps(const Scene& scene, const ModalForm& form) {
  const double all = form.omega.size() > 0 ? form.omega.maxCoeff() : 0, every = scene.output.every;
  const double highest = std::max(all / *scene.time->cfl, every > 0 ? 2 / every : 0);
  return highest < all ? std::optional(highest) : std::nullopt;
}

const RigidBody& rigid_body_of(const Instance&, const ReducedComponent& component) {
  return component.rigid_body;
}

RigidBody rigid_body_of(const Instance& instance, const MeshedComponent& component) {
  if (instance.as == InstanceKind::rigid) return *component.rigid_body;
  return rigid_body(component.fe->M, component.geometry->coordinates, component.fe->n_rotations);
}

}  // namespace

std::vector<HeldDirection> held_directions(const SceneIndex& index, const Instance& instance,
                                           const Geometry& geometry) {
  constexpr double none_left = 1e-9;
  const Matrix3 T = instance.transformation();
  std::vector<HeldDirection> list;
  std::map<Index, std::vector<Vector3>> fixed;  // of the nodes
  for (const auto& [node, axis] : geometry.fixed) {
    fixed[node].push_back(Vector3::Unit(axis));
    if (!geometry.reduced) list.push_back({node, Vector3::Unit(axis)});
  }
  // u_scene = T u, so e_c . u_scene = (T^T e_c) . u
  for (const HeldAxis& held : held_axes(index, instance, geometry)) {
    HeldDirection along{held.node, T.row(held.axis).transpose()};
    if (const auto known = fixed.find(held.node); known != fixed.end()) {
      for (const Vector3& other : known->second)
        along.direction -= along.direction.dot(other) * other;
      if (along.direction.norm() < none_left) continue;
      along.direction.normalize();
      known->second.push_back(along.direction);
    }
    list.push_back(along);
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const HeldDirection& a, const HeldDirection& b) { return a.node < b.node; });
  return list;
}

template <typename Component>
BodyMaker::Shelled& BodyMaker::shelled(const Instance& instance, const Component& component) {
  // Instances of one component may differ in their skinned surfaces.
  std::string key =
      instance.component + (instance.as == InstanceKind::mesh ? " mesh" : " superelement");
  if (skin_acts(scene_))
    for (const auto& [name, surface] : component.geometry->surfaces)
      for (const std::string& skinned : scene_.skin->surfaces)
        if (skinned == name || skinned == instance.name + "." + name) key += " " + name;
  Shelled& shelled = shelled_[key];
  if (!shelled.model) {
    CoupledModel model = model_of(component);
    if (skin_acts(scene_))
      add_shells(skin_shells(scene_, instance.name, *component.geometry), model);
    shelled.model = std::make_shared<CoupledModel>(std::move(model));
  }
  return shelled;
}

InstanceBody BodyMaker::make_coupled(const InstancePlan& plan, const Geometry& geometry,
                                     Shelled& shelled) {
  const Instance& instance = *plan.instance;
  std::vector<HeldDirection> held = held_directions(index_, instance, geometry);
  std::shared_ptr<CoupledSystem> system = held.empty() ? shelled.system : nullptr;
  if (!system) {
    const bool free = held.empty();
    system = std::make_shared<CoupledSystem>(shelled.model, std::move(held), where(instance));
    if (free) shelled.system = system;
  }
  return {std::make_unique<CoupledBody>(instance.name, system, placement_of(index_, instance),
                                        plan.scheme, NewmarkOptions{scene_.time->alpha},
                                        plan.damping.material),
          shelled.model->rigid_body.mass};
}

std::unique_ptr<ModalBody> BodyMaker::modal_body(
    const InstancePlan& plan, const std::shared_ptr<const Superelement>& superelement,
    const std::shared_ptr<const ModalForm>& form) const {
  const Instance& instance = *plan.instance;
  auto body =
      std::make_unique<ModalBody>(instance.name, superelement, form, placement_of(index_, instance),
                                  plan.scheme, NewmarkOptions{scene_.time->alpha}, plan.damping);
  if (plan.turns) body->turn_freely(instance.angular_velocity, scene_.time->end);
  return body;
}

std::shared_ptr<const ModalForm> BodyMaker::held_form(const Instance& instance,
                                                      const ReducedComponent& component) {
  std::vector<HeldDirection> held = held_directions(index_, instance, *component.geometry);
  auto& forms = held_forms_[component.superelement.get()];
  for (const auto& [known, form] : forms)
    if (known == held) return form;
  const Superelement& s = *component.superelement;
  const auto form =
      component.has_residual()
          ? held_residual_form(s, *component.form, held, where(instance))
          : std::make_shared<const ModalForm>(
                s.is_characteristic() ? held_characteristic_form(s, held, where(instance))
                                      : held_modal_form(s, held, where(instance)));
  forms.emplace_back(std::move(held), form);
  return form;
}

std::shared_ptr<const ModalForm> BodyMaker::truncated(
    const InstancePlan& plan, const ReducedComponent& component,
    const std::shared_ptr<const ModalForm>& form) {
  if (form->residual || plan.truncation == Truncation::none) return nullptr;
  const auto [at, is_new] = truncated_.try_emplace(form.get());
  if (!is_new) return at->second;
  const Superelement& s = *component.superelement;
  const bool is_asked = plan.truncation == Truncation::asked;
  const std::optional<double> highest =
      is_asked ? limit_of_long_steps(scene_, *form) : automatic_limit(s.eigenvalues, *form);
  if (!highest) return nullptr;
  const InterfaceNeeds needs = interface_needs(scene_, component_of(scene_, *plan.instance));
  const std::vector<Index> loaded = is_asked ? loaded_nodes(needs, s) : std::vector<Index>();
  const StaticShare forces = static_forces(touching_surfaces(needs, s), {}, s, loaded);
  if (is_asked || is_large_face(forces)) at->second = truncated_form(*highest, form, forces, s);
  return at->second;
}

InstanceBody BodyMaker::make_modal(const InstancePlan& plan, const ReducedComponent& component) {
  const std::shared_ptr<const ModalForm> whole =
      plan.is_held() ? held_form(*plan.instance, component) : component.form;
  const std::shared_ptr<const ModalForm> part = truncated(plan, component, whole);
  const auto& form = part ? part : whole;
  auto body = modal_body(plan, component.superelement, form);
  InstanceBody made{.mass = component.rigid_body.mass,
                    .n_following = whole->omega.size() - form->omega.size()};
  if (plan.turns) made.notes = notes_of_spin(*plan.instance, *component.superelement, *body);
  made.body = std::move(body);
  return made;
}

InstanceBody BodyMaker::make_modal_with_shells(const InstancePlan& plan,
                                               const ReducedComponent& component) {
  const Instance& instance = *plan.instance;
  Shelled& with = shelled(instance, component);
  if (!with.nodes) with.nodes = std::make_shared<Superelement>(nodes_only(*with.model));
  const auto form_of = [&](const std::vector<HeldDirection>& held) {
    return std::make_shared<ModalForm>(modal_form(*with.model, held, where(instance)));
  };
  if (plan.is_held())
    return {modal_body(plan, with.nodes,
                       form_of(held_directions(index_, instance, *component.geometry))),
            with.model->rigid_body.mass};
  if (!with.form) with.form = form_of({});
  return {modal_body(plan, with.nodes, with.form), with.model->rigid_body.mass};
}

InstanceBody BodyMaker::make(const Instance& instance, const ReducedComponent& component) {
  return make_supported(instance, component);
}

InstanceBody BodyMaker::make(const Instance& instance, const MeshedComponent& component) {
  return make_supported(instance, component);
}

template <typename Component>
InstanceBody BodyMaker::make_supported(const Instance& instance, const Component& component) {
  const InstancePlan& its = index_.plan(instance);
  InstanceBody made = make_held(its, component);
  SupportPlan plan = its.moves_alike ? translation(instance, *component.geometry, made.mass)
                                     : shapes(instance, component, *made.body);
  plan.has_inertia = !scene_.time->is_static;
  plan.waits = preload_steps(scene_) > 0;
  if (!its.moves_alike || !plan.drives.empty()) made.body->move_supports(std::move(plan));
  return made;
}

SupportShapes BodyMaker::shapes_of(const Instance& instance, const ReducedComponent& component,
                                   const std::vector<HeldDirection>& held, const Matrix& motion) {
  if (component.parts.size() == 1) {
    const Superelement& s = *component.parts.front().superelement;
    if (s.is_massless()) return modal_shapes(s, *component.form, held, motion);
    if (s.is_characteristic())
      return modal_shapes(s, free_characteristic_form(s, where(instance)), held, motion);
  }
  return coupled_shapes(shelled(instance, component).model, held, motion, where(instance));
}

SupportShapes BodyMaker::shapes_of(const Instance& instance, const MeshedComponent& component,
                                   const std::vector<HeldDirection>& held, const Matrix& motion) {
  if (instance.as != InstanceKind::rigid)
    return coupled_shapes(shelled(instance, component).model, held, motion, where(instance));
  return rigid_shapes(*nodes_of_rigid_.at(&component), held, motion,
                      instance.source.text() + ": the supports of instance '" + instance.name +
                          "', a rigid body, move it as one, and react as one: give them one "
                          "motion and one set, or use as: mesh or superelement");
}

template <typename Component>
SupportPlan BodyMaker::shapes(const Instance& instance, const Component& component,
                              const Body& held) {
  SupportShapesWanted wanted = support_shapes_wanted(index_, instance, *component.geometry);
  SupportPlan plan;
  plan.shapes = shapes_of(instance, component,
                          held_directions(index_, instance, *component.geometry), wanted.motion);
  plan.drives = std::move(wanted.drives);
  plan.sets = std::move(wanted.sets);
  plan.n_modal = plan.shapes.psi.rows() - 3 * held.n_nodes();
  plan.T = instance.transformation();
  const RigidBody rigid = rigid_body_of(instance, component);
  plan.mass = rigid.mass;
  plan.inertia = rigid.inertia;
  return plan;
}

SupportPlan BodyMaker::translation(const Instance& instance, const Geometry& geometry,
                                   double mass) const {
  const DrivenMotion motion = support_motion(index_, instance);
  SupportPlan plan{.mass = mass};
  plan.directions.resize(3, 0);
  for (Index axis = 0; axis < 3; ++axis)
    for (const DrivenAxis& drive : motion.axes[axis]) {
      plan.drives.push_back(drive);
      plan.directions.conservativeResize(Eigen::NoChange, plan.directions.cols() + 1);
      plan.directions.rightCols(1) = Vector3::Unit(axis);
    }
  for (const auto& [node, rotation] : geometry.rotations) plan.rotations.push_back(rotation);
  return plan;
}

InstanceBody BodyMaker::make_held(const InstancePlan& plan, const ReducedComponent& component) {
  if (plan.body == BodyKind::form) return make_modal(plan, component);
  if (plan.body == BodyKind::form_with_shells) return make_modal_with_shells(plan, component);
  return make_coupled(plan, *component.geometry, shelled(*plan.instance, component));
}

InstanceBody BodyMaker::make_mesh_modes(const InstancePlan& plan,
                                        const MeshedComponent& component) const {
  auto modes = std::make_shared<MeshModes>(
      mesh_modes(component, held_directions(index_, *plan.instance, *component.geometry),
                 *component.modes, where(*plan.instance)));
  auto body = modal_body(plan, modes->nodes, modes->form);
  body->sum_forces();
  return {std::move(body), modes->nodes->rigid_body.mass, modes};
}

InstanceBody BodyMaker::make_rigid(const InstancePlan& plan, const MeshedComponent& component) {
  const Instance& instance = *plan.instance;
  std::shared_ptr<const Superelement>& nodes = nodes_of_rigid_[&component];
  if (!nodes) {
    auto of_mesh = mesh_nodes(component);
    of_mesh->rigid_body = *component.rigid_body;
    nodes = of_mesh;
  }
  const std::shared_ptr<const ModalForm> form =
      rigid_form(*nodes, held_directions(index_, instance, *component.geometry), where(instance));
  return {modal_body(plan, nodes, form), nodes->rigid_body.mass};
}

InstanceBody BodyMaker::make_held(const InstancePlan& plan, const MeshedComponent& component) {
  const Instance& instance = *plan.instance;
  if (plan.body == BodyKind::rigid) return make_rigid(plan, component);
  if (plan.body == BodyKind::mesh_modes) return make_mesh_modes(plan, component);
  if (plan.body == BodyKind::coupled)
    return make_coupled(plan, *component.geometry, shelled(instance, component));
  MeshOptions options{.damping = plan.damping.material};
  if (plan.turns) options.angular_velocity = instance.angular_velocity;
  if (preload_steps(scene_) > 0)
    options.statics = make_coupled(plan, *component.geometry, shelled(instance, component)).body;
  return {std::make_unique<MeshBody>(instance.name, component.model, placement_of(index_, instance),
                                     held_directions(index_, instance, *component.geometry),
                                     threads_, std::move(options)),
          component.model->rigid_body.mass};
}

}  // namespace cbr

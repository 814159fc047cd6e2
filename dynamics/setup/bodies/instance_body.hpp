// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/bodies: the body of each instance.
//
// Makes the body of an instance, by its kind, its supports and loads, and the integrator.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/coupled/coupled_system.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Constrained directions of an instance in component axes; conditions on the same node are merged.
std::vector<HeldDirection> held_directions(const SceneIndex& index, const Instance& instance,
                                           const Geometry& geometry);

struct MeshModes;
struct SupportShapes;

struct InstanceBody {
  std::unique_ptr<Body> body;
  double mass = 0;  // including shells
  std::shared_ptr<const MeshModes> modes = {};
  std::vector<std::string> notes = {};  // for BuiltScene::notes
  Index n_following = 0;                // quasi-static modes, in addition to Body::n_dofs()
};

class BodyMaker {
 public:
  BodyMaker(const SceneIndex& index, std::shared_ptr<RowThreads> threads)
      : index_(index), scene_(index.scene()), threads_(std::move(threads)) {}

  // InputError: boundary conditions on missing nodes, or with contradicting motions. RunError: a
  // mass that is not positive definite.
  InstanceBody make(const Instance& instance, const ReducedComponent& component);
  InstanceBody make(const Instance& instance, const MeshedComponent& component);

 private:
  struct Shelled {
    std::shared_ptr<const CoupledModel> model;
    std::shared_ptr<const Superelement> nodes;  // of the model, for its diagonal form
    std::shared_ptr<const ModalForm> form;      // of the free model
    std::shared_ptr<CoupledSystem> system;      // for free instances
  };
  // With supports at rest, in axes that follow the prescribed motion; then with that motion.
  InstanceBody make_held(const InstancePlan& plan, const ReducedComponent& component);
  InstanceBody make_held(const InstancePlan& plan, const MeshedComponent& component);
  InstanceBody make_mesh_modes(const InstancePlan& plan, const MeshedComponent& component) const;
  InstanceBody make_rigid(const InstancePlan& plan, const MeshedComponent& component);
  template <typename Component>
  InstanceBody make_supported(const Instance& instance, const Component& component);
  SupportPlan translation(const Instance& instance, const Geometry& geometry, double mass) const;
  // For multi-support excitation, or reactions of sets.
  template <typename Component>
  SupportPlan shapes(const Instance& instance, const Component& component, const Body& held);
  SupportShapes shapes_of(const Instance& instance, const ReducedComponent& component,
                          const std::vector<HeldDirection>& held, const Matrix& motion);
  SupportShapes shapes_of(const Instance& instance, const MeshedComponent& component,
                          const std::vector<HeldDirection>& held, const Matrix& motion);
  template <typename Component>
  Shelled& shelled(const Instance& instance, const Component& component);
  InstanceBody make_coupled(const InstancePlan& plan, const Geometry& geometry, Shelled& shelled);
  std::unique_ptr<ModalBody> modal_body(const InstancePlan& plan,
                                        const std::shared_ptr<const Superelement>& superelement,
                                        const std::shared_ptr<const ModalForm>& form) const;
  // Shared by all instances of a component with the same constraints, in component axes.
  std::shared_ptr<const ModalForm> held_form(const Instance& instance,
                                             const ReducedComponent& component);
  InstanceBody make_modal(const InstancePlan& plan, const ReducedComponent& component);
  // The form whose highest modes are quasi-static, for a plan that truncates: free with a large
  // contact face, or with cfl above 1. Otherwise null.
  std::shared_ptr<const ModalForm> truncated(const InstancePlan& plan,
                                             const ReducedComponent& component,
                                             const std::shared_ptr<const ModalForm>& form);
  InstanceBody make_modal_with_shells(const InstancePlan& plan, const ReducedComponent& component);

  const SceneIndex& index_;
  const Scene& scene_;
  std::shared_ptr<RowThreads> threads_;
  std::map<const Superelement*,
           std::vector<std::pair<std::vector<HeldDirection>, std::shared_ptr<const ModalForm>>>>
      held_forms_;
  std::map<const ModalForm*, std::shared_ptr<const ModalForm>> truncated_;
  std::map<const MeshedComponent*, std::shared_ptr<const Superelement>> nodes_of_rigid_;
  // by component, kind and skinned surfaces
  std::map<std::string, Shelled> shelled_;
};

}  // namespace cbr

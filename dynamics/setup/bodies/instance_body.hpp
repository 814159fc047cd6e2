// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/bodies: which body moves an instance.
//
// The body that an instance becomes: by what it is, what is on it, and the integrator.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/motion/coupled/coupled_system.hpp"
#include "dynamics/motion/scaled/scaled_model.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// The held directions of an instance in component axes; several conditions on one node are joined.
std::vector<HeldDirection> held_directions(const SceneIndex& index, const Instance& instance,
                                           const Geometry& geometry);

struct MeshModes;
class SupportedBody;
struct SupportShapes;

struct InstanceBody {
  std::unique_ptr<Body> body;
  double mass = 0;  // with shells
  std::shared_ptr<const MeshModes> modes = {};
  std::vector<std::string> notes = {};  // for BuiltScene::notes
  Index n_following = 0;  // coordinates that follow contact as statics, beside Body::n_dofs()
  // within `body`, where reactions of sets are asked for or supports move unevenly
  SupportedBody* supported = nullptr;
};

class BodyMaker {
 public:
  BodyMaker(const SceneIndex& index, std::shared_ptr<RowThreads> threads)
      : index_(index), scene_(index.scene()), threads_(std::move(threads)) {}

  // InputError: boundary conditions on nodes that are not there, or that move unlike each other;
  // shells that cannot be. RunError: a mass that is not positive definite.
  InstanceBody make(const Instance& instance, const ReducedComponent& component);
  InstanceBody make(const Instance& instance, const MeshedComponent& component);

 private:
  struct Shelled {
    std::shared_ptr<const CoupledModel> model;
    std::shared_ptr<const Superelement> nodes;  // of the model, for its diagonal form
    std::shared_ptr<const DiagonalForm> form;   // of the free model
    std::shared_ptr<CoupledSystem> system;      // likewise
  };
  // With supports at rest, in axes that move with them; and with their motion.
  InstanceBody make_held(const Instance& instance, const ReducedComponent& component);
  InstanceBody make_held(const Instance& instance, const MeshedComponent& component);
  InstanceBody make_mesh_modes(const Instance& instance, const MeshedComponent& component) const;
  InstanceBody make_rigid(const Instance& instance, const MeshedComponent& component);
  InstanceBody driven(const Instance& instance, const Geometry& geometry, InstanceBody held) const;
  // The same where supports move unlike each other, or their reactions are asked for.
  template <typename Component>
  InstanceBody supported(const Instance& instance, const Component& component, InstanceBody held);
  SupportShapes shapes_of(const Instance& instance, const ReducedComponent& component,
                          const std::vector<HeldDirection>& held, const Matrix& motion);
  SupportShapes shapes_of(const Instance& instance, const MeshedComponent& component,
                          const std::vector<HeldDirection>& held, const Matrix& motion);
  template <typename Component>
  Shelled& shelled(const Instance& instance, const Component& component);
  InstanceBody make_coupled(const Instance& instance, const Geometry& geometry, Shelled& shelled);
  InstanceBody make_scaled_from_matrices(const Instance& instance,
                                         const ReducedComponent& component);
  // One for all instances of a component that are held in the same way, in its own axes.
  std::shared_ptr<const DiagonalForm> held_form(const Instance& instance,
                                                const ReducedComponent& component);
  InstanceBody make_with_statics(const Instance& instance, const ReducedComponent& component);
  InstanceBody make_modal(const Instance& instance, const ReducedComponent& component);
  // Either of the two, free, in axes that turn with it.
  InstanceBody make_turning(const Instance& instance, const ReducedComponent& component);
  // With step: auto, of a free superelement with a large face that touches: its highest modes
  // answer at once. Else nothing.
  std::shared_ptr<const StaticsForm> truncated(const Instance& instance,
                                               const ReducedComponent& component,
                                               const DiagonalForm& form);
  InstanceBody make_modal_with_shells(const Instance& instance, const ReducedComponent& component);

  const SceneIndex& index_;
  const Scene& scene_;
  std::shared_ptr<RowThreads> threads_;
  std::map<const Superelement*,
           std::vector<std::pair<std::vector<HeldDirection>, std::shared_ptr<const DiagonalForm>>>>
      held_forms_;
  std::map<const Superelement*,
           std::vector<std::pair<std::vector<HeldDirection>, std::shared_ptr<const StaticsForm>>>>
      held_statics_;
  std::map<const DiagonalForm*, std::shared_ptr<const StaticsForm>> truncated_;
  std::map<const MeshedComponent*, std::shared_ptr<const Superelement>> nodes_of_rigid_;
  // by what they were made from: a form or a superelement
  std::map<const void*, std::shared_ptr<ScaledModel>> scaled_;
  // by component, kind and skinned surfaces
  std::map<std::string, Shelled> shelled_;
};

}  // namespace cbr

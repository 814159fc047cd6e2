// SPDX-License-Identifier: GPL-3.0-or-later
// Coordinates of each instance, decided once from its kind, supports and loads, and the integrator.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "dynamics/setup/components/geometry.hpp"
#include "dynamics/setup/components/scene_index.hpp"

namespace cbr {

// Coordinates of an instance in time integration.
enum class Coordinates { modal, coupled, nodal };  // ModalBody, CoupledBody, MeshBody

struct MotionPlan {
  Coordinates coordinates = Coordinates::modal;
  bool has_shells = false;  // active ones
  bool is_held = false;     // constrained by boundary conditions
  bool as_stored = false;   // with the diagonal form of the superelement's file

  bool is_modal() const { return coordinates == Coordinates::modal; }
  bool moves_freely_in_form() const { return is_modal() && !is_held && !has_shells; }
};

using MotionPlans = std::map<std::string, MotionPlan>;  // by instance

// Inputs of the plans of a superelement's instances.
struct PlannedSuperelement {
  const Geometry& geometry;
  Index n_dofs = 0;
  bool has_form = false;                     // the file stores the diagonal form
  bool has_only_modes = false;               // basis characteristic: nothing but the form exists
  std::optional<Index> diagonal_limit = {};  // of the command line
};

bool has_shells(const Scene& scene, const Instance& instance, const Geometry& geometry);

// Coupled: shells or newmark on a mesh, and superelements whose diagonal form is neither stored nor
// small. `exact` is modal.
MotionPlans plan_superelements(const SceneIndex& index, const std::string& component,
                               const PlannedSuperelement& of);
MotionPlans plan_meshes(const SceneIndex& index, const std::string& component,
                        const Geometry& geometry);

}  // namespace cbr

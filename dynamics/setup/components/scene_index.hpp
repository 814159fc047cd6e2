// SPDX-License-Identifier: GPL-3.0-or-later
// How each instance moves, decided once, as plain data; and the plan of each instance, with the
// entries of the scene that refer to it. A scene may have thousands of instances, and hundreds of
// thousands of lines that refer to one.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/scene/limits.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/motion/body.hpp"
#include "dynamics/motion/damping.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr {

enum class BodyKind {
  form,              // ModalBody: of a superelement
  form_with_shells,  // ModalBody: of its matrices and those of a skin
  coupled,           // CoupledBody: dense blocks of a superelement, or a mesh
  mesh,              // MeshBody
  mesh_modes,        // ModalBody: the lowest modes of a mesh
  rigid              // ModalBody: six coordinates, or fewer
};

// Modes above a limit that become quasi-static: by step: auto, or by a cfl above 1.
enum class Truncation { none, automatic, asked };

struct InstancePlan {
  const Instance* instance = nullptr;
  Features features;
  // By the scene alone
  std::vector<const BoundaryCondition*> boundary;  // in the scene's order
  bool is_fixed = false;                           // by reduction.fixed
  bool may_touch = false;                          // by a contact
  bool only_impulses = true;  // contact has enforcement: impulse; no ties, links, loaded points
  bool has_loads = false;     // except gravity
  bool moves_alike = true;    // all supports have one translation, without reactions of sets
  Damping damping;            // of its materials and its own
  Truncation truncation = Truncation::none;
  // By its component, too
  BodyKind body = BodyKind::rigid;
  Scheme scheme = Scheme::exact;
  bool as_stored = false;   // with the diagonal form of the superelement's file
  Index n_shell_faces = 0;  // of a skin that acts
  bool turns = false;       // has large rotation
  std::string why_linear;   // reason against large rotation; empty: it is possible

  // By boundary conditions, or by fixed dofs that its body has.
  bool is_held() const {
    return !boundary.empty() || (is_fixed && instance->as != InstanceKind::superelement);
  }
  bool moves_freely_in_form() const { return body == BodyKind::form && !is_held(); }
};

// What a plan needs of a component that has been read.
struct PlannedComponent {
  const Geometry& geometry;
  // of a superelement
  Index n_dofs = 0;
  bool has_form = false;                     // the file stores the diagonal form
  bool has_only_modes = false;               // it has no matrices of the interface
  std::optional<Index> diagonal_limit = {};  // of the command line
  bool as_modes = false;                     // of a mesh, for --modes and --sweep
};

// Chooses the bodies of a component's instances. A superelement is coupled if its diagonal form is
// neither stored nor small, and the integrator is not `exact`. A mesh is coupled with shells,
// `newmark` or statics.
void plan_bodies(const Scene& scene, const std::vector<InstancePlan*>& plans,
                 const PlannedComponent& of);
// The last step, once all features are known: large rotation where it is possible.
void plan_rotation(const Scene& scene, InstancePlan& plan);

class SceneIndex {
 public:
  // The scene must outlive this object. InputError: materials of a component with different
  // damping.
  explicit SceneIndex(const Scene& scene);

  const Scene& scene() const { return scene_; }
  // Index in scene.instances; precondition: it exists (read_scene has checked).
  Index place(const std::string& instance) const { return places_.at(instance); }
  const InstancePlan& plan(const Instance& instance) const { return plans_[place(instance.name)]; }
  std::vector<InstancePlan>& plans() { return plans_; }  // in the order of the instances
  // Of the instances of a component that are this.
  std::vector<InstancePlan*> plans(const Component& component, InstanceKind as);

 private:
  const Scene& scene_;
  std::unordered_map<std::string, Index> places_;
  std::vector<InstancePlan> plans_;
};

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Entries of a scene by instance. A scene may have thousands of instances, and hundreds of
// thousands of lines that refer to one.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/scene/scene.hpp"

namespace cbr {

class SceneIndex {
 public:
  // The scene must outlive this object.
  explicit SceneIndex(const Scene& scene);

  const Scene& scene() const { return scene_; }
  // Index in scene.instances; precondition: it exists (read_scene has checked).
  Index place(const std::string& instance) const { return places_.at(instance); }
  // Conditions of the instance, in the scene's order.
  const std::vector<const BoundaryCondition*>& boundary(const Instance& instance) const {
    return of(instance).boundary;
  }
  bool is_held(const Instance& instance) const { return !of(instance).boundary.empty(); }
  // Whether a contact includes the instance, and one that needs nodal masses.
  bool may_touch(const Instance& instance) const { return all_touch_ || of(instance).touches; }
  bool is_nodal(const Instance& instance) const { return all_nodal_ || of(instance).nodal; }
  // Whether all its contact has `enforcement: impulse`, without ties.
  bool has_only_impulses(const Instance& instance) const {
    return !all_other_ && !of(instance).other;
  }
  bool has_loads(const Instance& instance) const { return of(instance).loaded; }  // except gravity
  // Excludes the instance from large rotation, for reasons found in its files.
  void keep_linear(const Instance& instance) {
    of_[static_cast<std::size_t>(place(instance.name))].linear = true;
  }
  // *DAMPING of the materials that the component's file assigns, by block name.
  const std::map<std::string, MaterialDamping>& damping_of_file(const Component& component) const;
  bool stays_linear(const Instance& instance) const { return of(instance).linear; }

 private:
  struct Of {
    std::vector<const BoundaryCondition*> boundary;
    bool touches = false, nodal = false, other = false, loaded = false, linear = false;
  };
  const Of& of(const Instance& instance) const {
    return of_[static_cast<std::size_t>(place(instance.name))];
  }

  void read_damping(const Component& component);

  const Scene& scene_;
  std::map<std::string, std::map<std::string, MaterialDamping>> damping_;  // by component
  std::unordered_map<std::string, Index> places_;
  std::vector<Of> of_;  // per instance
  bool all_touch_ = false, all_nodal_ = false, all_other_ = false;
};

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// The plan of each instance, with the entries of the scene that refer to it. A scene may have
// thousands of instances, and hundreds of thousands of lines that refer to one.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/scene/scene.hpp"
#include "dynamics/setup/components/instance_plan.hpp"

namespace cbr {

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

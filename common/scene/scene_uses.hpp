// SPDX-License-Identifier: GPL-3.0-or-later
// Which sets of a component's mesh a scene names: asked by both programs before their work.
#pragma once

#include <string>
#include <vector>

#include "common/scene/scene.hpp"

namespace cbr {

// A set of an instance, as `output.history`, `boundary` or `contact` (the key) name it.
struct SetUse {
  std::string key, instance, set;
  SourceLine source;
  bool needs_faces = false;    // a sideset; else a nodeset will do
  bool may_be_inside = false;  // recovery data of a superelement will do
  bool is_of_stress = false;   // which they are needed for
};

// In the scene's order, of the instances of the component that stand as `as`.
std::vector<SetUse> set_uses(const Scene& scene, const Component& component, InstanceKind as);

// Whether a point of the component is a node of its superelement.
bool is_interface_point(const Component& component, const std::string& name);

// The point of reduction.points that moves the nodes of `set`; else the set.
std::string moved_set(const Component& component, const std::string& set);

// "history.yaml:9: output.history: 'left.mid': ": how a message about it begins.
std::string place_of(const SetUse& use);

// Shells without thickness, or with neither modulus nor density, have no effect.
bool skin_acts(const Scene& scene);

}  // namespace cbr

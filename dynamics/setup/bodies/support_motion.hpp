// SPDX-License-Identifier: GPL-3.0-or-later
// Prescribed motion of an instance's supports, from the scene's boundary conditions.
#pragma once

#include <string>
#include <vector>

#include "dynamics/motion/prescribed_motion.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// A constrained displacement along an axis of the scene. For rotations: of their node,
// geometry.rotations.
struct HeldAxis {
  Index node = 0;
  int axis = 0;
  bool operator<(const HeldAxis& other) const {
    return node != other.node ? node < other.node : axis < other.axis;
  }
  bool operator==(const HeldAxis& other) const = default;
};

// Ascending; conditions on the same node are merged. InputError: missing rotations.
std::vector<HeldAxis> held_axes(const SceneIndex& index, const Instance& instance,
                                const Geometry& geometry);

// Why shells of an instance are hinged where they are held, with the cure; empty: they are not.
std::string why_hinged(const Scene& scene, const Instance& instance);

// The translation of all supports; none if they move differently.
DrivenMotion support_motion(const SceneIndex& index, const Instance& instance);

// Multi-support excitation, and motions of the sets whose reactions are requested.
struct SupportShapesWanted {
  Matrix motion;  // along held_axes(), a column each: of the time functions, then six per set
  std::vector<DrivenAxis> drives;
  std::vector<ReactionSet> sets;
};
// InputError: two conditions constrain an axis with different motions; a set without constrained
// axes.
SupportShapesWanted support_shapes_wanted(const SceneIndex& index, const Instance& instance,
                                          const Geometry& geometry);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// How the scene's boundary conditions move the supports of an instance.
#pragma once

#include <string>
#include <vector>

#include "dynamics/motion/driven_motion.hpp"
#include "dynamics/motion/support_shapes.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// A displacement that is held, along an axis of the scene. Of rotations it is one of their node,
// geometry.rotations.
struct HeldAxis {
  Index node = 0;
  int axis = 0;
  bool operator<(const HeldAxis& other) const {
    return node != other.node ? node < other.node : axis < other.axis;
  }
  bool operator==(const HeldAxis& other) const = default;
};

// Ascending; several conditions on one node are joined. InputError: rotations that are not there.
std::vector<HeldAxis> held_axes(const SceneIndex& index, const Instance& instance,
                                const Geometry& geometry);

// Whether supports move by one translation, and nobody asks for the reactions of sets.
bool supports_move_alike(const SceneIndex& index, const Instance& instance);
// That translation; none where they do not move alike.
DrivenMotion support_motion(const SceneIndex& index, const Instance& instance);

// The motions of supports that do not, and of the sets whose reactions are asked for.
struct SupportShapesWanted {
  Matrix motion;  // along held_axes(), one column each: of the drives, then six of each set
  std::vector<DrivenAxis> drives;
  std::vector<ReactionSet> sets;
};
// InputError: what two conditions hold and move unlike each other; no motion at all of a set.
SupportShapesWanted support_shapes_wanted(const SceneIndex& index, const Instance& instance,
                                          const Geometry& geometry);

}  // namespace cbr

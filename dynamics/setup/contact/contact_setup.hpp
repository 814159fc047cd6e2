// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/setup/contact: pairs, ties and links, and their initial state.
//
// Contact pairs of a scene: the slave side, the nodes in contact, and the weights of nodal
// enforcement.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// Fills contact_nodes and pairs. The finer surface (smaller mean face) gives the slave nodes; of
// equal ones the first named. Adds links, and joints after the bodies. Returns the kind of contact
// per body. Warns of `nodal` enforcement with its weights.
std::vector<ContactKind> add_contact(const SceneIndex& index, BuiltScene& built, Report& report);

// links.cpp: adds pairs of surfaces without faces: for each link one for its constrained
// translations and one for its rotations. Springs, and masses of points, get the same, each with a
// joint after the bodies. A rigid point has one for its nodes. contact_of_instance: indices in
// Simulation::contact_nodes.
void add_links(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance,
               BuiltScene& built);

// friction_shapes.cpp: checks faces of basis characteristic in a pair with friction. Warns of a
// face without residual compliance and with fewer interface modes than directions. It slides and
// sticks in large patches, and friction dissipates several times too much
// (docs/decisions/characteristic.md). InputError: residual compliance along the normals only.
void look_for_friction_shapes(const ContactPair& pair, const BuiltScene& built, const Scene& scene,
                              Report& report);

// link_rates.cpp: fastest link: on rigid bodies the larger of omega (springs) and c / m (dashpots),
// with elastic ends held in place; the largest angular velocity of a given rotation.
struct LinkRate {
  double rate = 0;  // 1 / s; 0: no such link
  std::string link;
};
LinkRate fastest_link(const BuiltScene& built);

// Largest h rate / 2, the relative error of velocities at the end of a step, which lack half of the
// next impulse. A given rotation goes by as many rad a step, where links close by linear steps.
constexpr double link_step_share = 0.01;

// Longest step for that error, 0: no limit. Rates that outputs at intervals `every` cannot show do
// not reduce it further, as springs and dashpots are stable at any step.
double link_step(const LinkRate& fastest, double every, double end);

}  // namespace cbr

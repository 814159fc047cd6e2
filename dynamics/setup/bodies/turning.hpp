// SPDX-License-Identifier: GPL-3.0-or-later
// Which scenes and instances turn by large angles (time.rotations: large).
#pragma once

#include <string>
#include <vector>

#include "dynamics/motion/modal/superelement_body.hpp"
#include "dynamics/motion/modal/turning_body.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Null: none.
const Load* gravity_of(const Scene& scene);
// `automatic` as build() takes it: `small`, or `large` where the caller wants it or an instance
// spins from the start or hangs on a hinge under gravity (then those turn that can).
Rotations resolved(const Scene& scene, bool wants_large);
// Whether an instance turns by any angle: with `large` each that nothing holds, and that can. All
// others are linear.
bool turns(const SceneIndex& index, const Instance& instance);
// InputError, one line that names what does not turn, before any file is read. `rotations: small`
// refuses angular velocities alone.
void refuse_what_does_not_turn(const SceneIndex& index);
// Why an instance cannot turn by any angle, told by the scene's text, and by what it is made of;
// empty: it can.
std::string why_linear(const SceneIndex& index, const Instance& instance);
std::string why_linear(const ReducedComponent& component, const Instance& instance);
std::string why_linear(const MeshedComponent& component, const Instance& instance);
std::string why_linear(const Damping& damping);
// InputError: the same.
[[noreturn]] void refuse_to_turn(const Instance& instance, const std::string& why);
// What `large` would be refused for before any file is read, whatever turns; empty: nothing.
std::string what_large_is_refused_for(const Scene& scene);
// What of its spin an instance that turns does not feel; empty: nothing worth a word.
std::vector<std::string> notes_of_spin(const Instance& instance, const Superelement& superelement,
                                       const TurningBody& body, const SuperelementBody& modal);
// With `large`, one line that names those that stay linear; empty: all turn.
std::string note_of_what_stays(const SceneIndex& index);

}  // namespace cbr

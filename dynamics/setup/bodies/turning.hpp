// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes and instances with large rotation (time.rotations: large).
#pragma once

#include <string>
#include <vector>

#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {

// Null: no gravity.
const Load* gravity_of(const Scene& scene);
// Replaces `automatic`. `large` if the caller requests it, or an instance spins initially or is on
// a hinge under gravity. It applies to instances that allow it. Else `small`.
Rotations resolved(const Scene& scene, bool wants_large);
// Whether an instance has large rotation: with `large` all unconstrained ones that allow it. Others
// are linear.
bool turns(const SceneIndex& index, const Instance& instance);
// InputError before any file is read, in one line with the item that does not allow large rotation.
// `rotations: small` rejects angular velocities only.
void refuse_what_does_not_turn(const SceneIndex& index);
// Reasons against large rotation of an instance, by the scene and by its component; empty: it is
// possible.
std::string why_linear(const SceneIndex& index, const Instance& instance);
std::string why_linear(const ReducedComponent& component, const Instance& instance);
std::string why_linear(const MeshedComponent& component, const Instance& instance);
std::string why_linear(const Damping& damping);
// InputError with that reason.
[[noreturn]] void refuse_to_turn(const Instance& instance, const std::string& why);
// The reason against `large` for the whole scene, known before any file is read; empty: none.
std::string what_large_is_refused_for(const Scene& scene);
// Spin effects that the model of an instance neglects; empty: none that matters.
std::vector<std::string> notes_of_spin(const Instance& instance, const Superelement& superelement,
                                       const ModalBody& body);
// With `large`, one line with the instances that stay linear; empty: none.
std::string note_of_what_stays(const SceneIndex& index);

}  // namespace cbr

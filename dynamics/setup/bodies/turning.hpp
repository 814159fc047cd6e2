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
// Whether the run allows large rotation of some instance.
bool allows_large(const Scene& scene);
// Replaces `automatic`. `large` if the caller requests it, or an instance spins initially or is on
// a hinge under gravity. It applies to instances that allow it. Else `small`.
Rotations resolved(const Scene& scene, bool wants_large);
// Spin effects that the model of an instance neglects; empty: none that matters.
std::vector<std::string> notes_of_spin(const Instance& instance, const Superelement& superelement,
                                       const ModalBody& body);
// With `large`, one line with the instances that stay linear; empty: none.
std::string note_of_what_stays(const SceneIndex& index);

}  // namespace cbr

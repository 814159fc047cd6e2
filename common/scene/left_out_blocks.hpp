// SPDX-License-Identifier: GPL-3.0-or-later
// Blocks of a mesh that no program computes with, shells without a thickness and beams: told by
// all of them.
#pragma once

#include <string>

#include "common/app/report.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// InputError when the scene gives a material or an element to such a block.
void refuse_left_out_blocks(const Component& component, const Mesh& mesh);

// "fin (25 quad4), web (12 tri3), beam (11 of its 11 nodes are of no element)"; empty when
// all is structure.
std::string left_out_blocks(const Mesh& mesh);

// Warns, by the component's name; `blocks`: as above, nothing is said when it is empty. InputError
// when the scene names one.
void warn_of_left_out_blocks(const Component& component, const std::string& blocks, Report& report);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Components that are a superelement file alone (key `superelement`): what a scene tells of other
// components, their file tells.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"

namespace cbr {

// The scene with the basis, the number of domains and the choice of modes of each file that an
// instance uses alone. Files that cannot be read are left to require_superelement(). Reads
// attributes only.
Scene with_options_of_files(const Scene& scene);

// InputError: the file does not exist, or is of hex27 and of a version that lost the centre nodes
// of its faces. Precondition: the component has no mesh.
void require_superelement(const Component& component);

// Of each block that the file recovers, by /provenance of the file. InputError at the component: a
// block of which it does not tell the material, or whose material is orthotropic.
std::vector<BlockProperties> properties_in_file(
    const Component& component, const std::map<std::string, std::string>& provenance,
    const std::vector<Block>& blocks);

}  // namespace cbr

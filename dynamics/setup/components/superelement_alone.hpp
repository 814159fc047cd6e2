// SPDX-License-Identifier: GPL-3.0-or-later
// Components that are a superelement file alone (key `superelement`): the file has the data that
// the scene has for other components.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"

namespace cbr {

// The scene with basis, number of domains and choice of modes of each superelement file used alone.
// Reads attributes only. Leaves unreadable files to require_superelement().
Scene with_options_of_files(const Scene& scene);

// InputError: the file does not exist, or has hex27 elements and a version that lost the central
// nodes of their faces. Precondition: the component has no mesh.
void require_superelement(const Component& component);

// Of any superelement. InputError at the component: WHAT about its file; the defect of hex27 above.
[[noreturn]] void refuse_file(const Component& component, const std::string& what);
void require_face_centres(const Component& component, const std::string& cure);

// Properties of the blocks that the file recovers, from its /provenance. InputError at the
// component: a block without its material, or with an orthotropic one.
std::vector<BlockProperties> properties_in_file(
    const Component& component, const std::map<std::string, std::string>& provenance,
    const std::vector<Block>& blocks);

}  // namespace cbr

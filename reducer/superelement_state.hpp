// SPDX-License-Identifier: GPL-3.0-or-later
// What the superelement file of a component is, before anything is reduced: up to date or not, and
// what is written into it of its making.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"

namespace cbr {

// Unchanged inputs; without_form: all is there but the diagonal form, which is wanted.
enum class FileState { current, without_form, stale };

// Of how many coordinates the diagonal form is wanted; an `exact` limit of the command line wants
// larger ones without it.
struct WantedForm {
  Index limit = 0;
  bool exact = false;
};

// Compares the file with the scene and its mesh; hash: content_hash(), loads: load_sets().
FileState state_of(const Scene& scene, const Component& component, const std::string& hash,
                   const std::vector<std::string>& loads, const WantedForm& wanted);

// InputError: the file is a mesh, the scene or of another kind. A mistyped -o or superelement:
// would cost the user one of these.
void refuse_to_overwrite(const Scene& scene, const std::string& input,
                         const std::filesystem::path& target);

// The file's provenance.
std::map<std::string, std::string> provenance(const Scene& scene, const Component& component,
                                              const std::vector<BlockProperties>& properties,
                                              const Mesh& mesh);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/skin_shells.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/scene/scene_uses.hpp"
#include "dynamics/setup/components/contact_faces.hpp"

namespace cbr {

IndexTable skin_faces(const Scene& scene, const std::string& instance, const Geometry& geometry) {
  IndexTable faces(0, 4);
  if (!skin_acts(scene)) return faces;
  for (const auto& [name, surface] : geometry.surfaces) {
    const bool named = std::any_of(scene.skin->surfaces.begin(), scene.skin->surfaces.end(),
                                   [&, &its_name = name](const auto& s) {
                                     return s == its_name || s == instance + "." + its_name;
                                   });
    if (named) join_faces(contact_faces(surface), faces);
  }
  return faces;
}

ShellModel skin_shells(const Scene& scene, const std::string& instance, const Geometry& geometry) {
  const SkinOptions& skin = *scene.skin;
  const Material material{skin.youngs_modulus, skin.poissons_ratio, skin.density};
  try {
    return assemble_shells(skin_faces(scene, instance, geometry), geometry.coordinates,
                           {material, skin.thickness});
  } catch (const InputError& error) {
    throw InputError(skin.source.text() + ": skin: instance '" + instance + "': " + error.what());
  }
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later

#include <algorithm>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement_file.hpp"
#include "common/superelement/superelement_group.hpp"
#include "reducer/component_reducer.hpp"
#include "reducer/partition/interface_sets.hpp"

namespace cbr {
namespace {

// Each set is on the interface or has its load inside, and no others have.
bool has_loads(const Superelement& s, const std::vector<std::string>& sets) {
  const auto is_kept = [&](const std::string& name) {
    return s.nodesets.count(name) > 0 ||
           std::any_of(s.surfaces.begin(), s.surfaces.end(),
                       [&](const Surface& surface) { return surface.name == name; });
  };
  return std::all_of(sets.begin(), sets.end(),
                     [&](const auto& name) { return is_kept(name) || s.loads.count(name) > 0; }) &&
         std::all_of(s.loads.begin(), s.loads.end(), [&](const auto& load) {
           return std::find(sets.begin(), sets.end(), load.first) != sets.end();
         });
}

}  // namespace

FileState state_of(const Scene& scene, const Component& component, const std::string& hash,
                   const std::vector<std::string>& loads, const WantedForm& wanted) {
  const ReductionOptions& reduction = *component.reduction;
  if (read_content_hash(reduction.superelement) != hash || is_of_other_mass(component))
    return FileState::stale;
  if (lacks_face_centres(reduction.superelement)) return FileState::stale;
  Superelement s;
  bool group = false;
  try {
    group = is_superelement_group(reduction.superelement);
    const SuperelementParts light = {false, true, false};
    s = group ? join(read_superelement_group(reduction.superelement, light))
              : read_superelement(reduction.superelement, light);
  } catch (const InputError&) {
    return FileState::stale;  // damaged: it is made anew
  }
  check_kept_sets(scene, component, s);
  if (!has_loads(s, loads)) return FileState::stale;
  const bool is_wanted = s.n() <= wanted.limit && s.has_interface_matrices();
  if (is_wanted && !s.has_diagonal_form())
    return group ? FileState::stale : FileState::without_form;
  return wanted.exact && !is_wanted && s.has_diagonal_form() ? FileState::stale
                                                             : FileState::current;
}

void refuse_to_overwrite(const Scene& scene, const std::string& input,
                         const std::filesystem::path& target) {
  const auto is_target = [&](const std::filesystem::path& file) {
    std::error_code error;
    return std::filesystem::equivalent(file, target, error) && !error;
  };
  for (const auto& [name, component] : scene.components) {
    if (component.has_mesh && is_target(component.mesh))
      throw InputError("superelement '" + target.string() + "' is the mesh of component '" + name +
                       "' and would overwrite it: give the superelement another name, as " + name +
                       ".cbr.h5");
  }
  if (is_target(input))
    throw InputError("superelement '" + target.string() +
                     "' is the scene itself and would overwrite it: give it another name");
  refuse_other_file(target, superelement_kind(), "the superelement",
                    "give the superelement another name");
}

std::map<std::string, std::string> provenance(const Scene& scene, const Component& component,
                                              const std::vector<BlockProperties>& properties,
                                              const Mesh& mesh) {
  std::map<std::string, std::string> p =
      option_provenance(component, mass_of_superelement(component, mesh));
  p["mesh"] = component.mesh.filename().string();
  p["mesh_hash"] = mesh_hash(component.mesh);
  if (component.reduction->is_characteristic())
    p.merge(needs_provenance(interface_needs(scene, component)));
  p.merge(block_provenance(mesh, properties));
  return p;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "skinner/command.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/files/output_file.hpp"
#include "common/files/unchanged_files.hpp"
#include "common/scene/left_out_blocks.hpp"
#include "common/scene/scene.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement.hpp"
#include "skinner/skin.hpp"

namespace cbr {
namespace {

void write(const SkinnedMesh& skinned, const std::filesystem::path& file, Report& report) {
  {
    const auto phase = report.phase("writing the mesh");
    write_mesh(skinned.mesh, file);
  }
  for (const auto& note : skinned.notes) report.line(note);
  for (const Block& block : skinned.mesh.blocks)
    if (block.reduced)
      report.warning(file.string() + ": cannot hold that block '" + block.name +
                     "' has reduced integration: give it element: reduced in a scene");
  for (const auto& block : skinned.blocks)
    report.line(block.name + ": " + std::to_string(block.n_shells) + " shells (" +
                std::string(name(block.kind)) + ") on " + std::to_string(block.n_nodes) + " nodes");
  report.line("written: " + file.string() + ", " + std::to_string(skinned.mesh.coordinates.rows()) +
              " nodes, " + std::to_string(skinned.mesh.blocks.size()) + " blocks");
  report.timings();
}

// What cbr-dyn refuses is a warning here: cbr-reduce may be run after cbr-skin, too.
void warn_of_stale_superelements(const Scene& scene, Report& report) {
  for (const auto& [name, component] : scene.components) {
    const bool used = std::any_of(scene.instances.begin(), scene.instances.end(),
                                  [&, &its_name = name](const Instance& instance) {
                                    return instance.as == InstanceKind::superelement &&
                                           instance.component == its_name;
                                  });
    if (!used || !component.reduction || !component.has_mesh ||
        !std::filesystem::exists(component.reduction->superelement))
      continue;
    if (read_content_hash(component.reduction->superelement) == content_hash(scene, component) &&
        !is_of_other_mass(component))
      continue;
    report.warning(component.source.text() + ": component '" + name + "': the superelement " +
                   component.reduction->superelement.string() +
                   " was not made from the present mesh, materials and reduction options (" +
                   stale_text(scene, component) + "), the skinned mesh is: run cbr-reduce " +
                   (scene.file == "-" ? "SCENE" : scene.file.string()));
  }
}

void skin_a_mesh(const SkinCommand& command, Report& report) {
  if (command.sidesets.empty())
    throw InputError(command.input + ": which sidesets? Give --sideset NAME, once for each");
  if (command.output.empty())
    throw InputError(command.input + ": where to? Give -o FILE.msh or -o FILE.exo");
  if (is_same_file(command.input, command.output))
    throw InputError(command.output.string() +
                     ": is the mesh to skin and would be overwritten: give -o another name");
  refuse_other_mesh(command.output, "the skinned mesh", "give -o another name");
  report.refuse_timings_at(command.output, "the skinned mesh");
  UnchangedFiles inputs;
  for (const auto& file : mesh_files(command.input)) inputs.add(file);
  SkinnedMesh skinned;
  {
    const auto phase = report.phase("reading the mesh");
    skinned.mesh = read_mesh(command.input);
  }
  try {
    const auto phase = report.phase("skinning");
    const std::string left_out = left_out_blocks(skinned.mesh);
    skinned = skin_mesh(std::move(skinned.mesh), command.sidesets);
    if (!left_out.empty())
      report.warning(command.input + ": " + left_out + ": cbr-reduce and cbr-dyn ignore shells");
  } catch (const InputError& error) {
    throw InputError(command.input + ": " + error.what());
  }
  inputs.check();
  write(skinned, command.output, report);
}

void skin_a_scene(const SkinCommand& command, std::ostream* scene_out, Report& report) {
  if (!command.sidesets.empty())
    throw InputError(command.input +
                     ": --sideset requires a mesh (.msh, .exo, .inp, .bdf, ...) as INPUT; in a "
                     "scene give skin: surfaces");
  Scene scene = read_scene(command.input);
  if (scene.skin) {
    if (!command.output.empty())
      scene.skin->mesh = std::filesystem::absolute(command.output).lexically_normal();
    if (!is_written_mesh_name(scene.skin->mesh))
      throw InputError(scene.skin->source.text() + ": skin: mesh: '" +
                       scene.skin->mesh.filename().string() +
                       "' found, a name that ends in .msh, .exo, .e or .g is wanted");
    for (const auto& [name, component] : scene.components)
      if (component.has_mesh && is_same_file(component.mesh, scene.skin->mesh))
        throw InputError(scene.skin->source.text() + ": skin: mesh: '" +
                         scene.skin->mesh.filename().string() + "' is the mesh of component '" +
                         name + "' and would be overwritten: give the skinned mesh another name");
    refuse_other_mesh(
        scene.skin->mesh, "the skinned mesh",
        command.output.empty() ? "give skin.mesh another name" : "give -o another name");
    report.refuse_timings_at(scene.skin->mesh, "the skinned mesh");
    UnchangedFiles inputs;
    for (const Instance& instance : scene.instances)
      if (const Component& component = component_of(scene, instance); component.has_mesh)
        for (const auto& file : mesh_files(component.mesh)) inputs.add(file);
    SkinnedMesh skinned;
    {
      const auto phase = report.phase("reading and skinning");
      skinned = skin_scene(scene);
      for (const auto& [component, blocks] : skinned.left_out)
        warn_of_left_out_blocks(scene.components.at(component), blocks, report);
      warn_of_stale_superelements(scene, report);
    }
    inputs.check();
    write(skinned, scene.skin->mesh, report);
  } else {
    if (!command.output.empty())
      throw InputError(command.input +
                       ": -o was given, and the scene has no skin: add skin: to the scene");
    report.line("the scene has no skin: passed on unchanged");
  }
  if (scene_out != nullptr) write_scene(scene, *scene_out);
}

}  // namespace

void run_skin(const SkinCommand& command, std::ostream* scene_out, Report& report) {
  is_mesh_name(command.input) ? skin_a_mesh(command, report)
                              : skin_a_scene(command, scene_out, report);
}

}  // namespace cbr

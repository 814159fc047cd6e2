// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/left_out_blocks.hpp"

#include "common/error.hpp"

namespace cbr {

void refuse_left_out_blocks(const Component& component, const Mesh& mesh) {
  const auto refuse = [&](const std::string& named, const Component::BlockOptions& options, Index n, const std::string& type) {
    throw InputError(options.source.text() + ": components." + component.name + ".blocks." + named + ": the " + std::to_string(n) +
                     " " + type + " elements of " + component.mesh.string() +
                     " are not computed with: only solids are in this version; take the block out of the scene");
  };
  for (const auto& [named, options] : component.blocks) {
    const Index found = find_block(mesh, named);
    if (found >= 0) {
      const Block& block = mesh.blocks[static_cast<std::size_t>(found)];
      if (dimension(block.type) != 3) refuse(named, options, block.connectivity.rows(), std::string(name(block.type)));
    }
  }
}

std::string left_out_blocks(const Mesh& mesh) {
  std::vector<std::string> texts;
  for (const Block& block : mesh.blocks)
    if (dimension(block.type) != 3)
      texts.push_back(block.name + " (" + std::to_string(block.connectivity.rows()) + " " + std::string(name(block.type)) + ")");
  return join(texts);
}

void warn_of_left_out_blocks(const Component& component, const std::string& blocks, Report& report) {
  if (blocks.empty()) return;
  for (const auto& [named, options] : component.blocks)
    if ((", " + blocks).find(", " + named + " (") != std::string::npos)
      throw InputError(options.source.text() + ": components." + component.name + ".blocks." + named + ": of " + blocks +
                       " nothing is computed with: only solids are in this version; take the block out of the scene");
  const std::string before = report.about();
  report.about("");
  report.warning("component '" + component.name + "': " + component.mesh.filename().string() + ": left out: " + blocks +
                 ": shells are not computed with, their stiffness and mass are missing");
  report.about(before);
}

}  // namespace cbr

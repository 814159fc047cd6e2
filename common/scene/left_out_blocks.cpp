// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/left_out_blocks.hpp"

#include <algorithm>

#include "common/base/error.hpp"

namespace cbr {
namespace {

std::vector<char> nodes_of_structure(const Mesh& mesh) {
  std::vector<char> is_used(static_cast<std::size_t>(mesh.coordinates.rows()), 0);
  for (const Block& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    for (const Index node : block.connectivity.reshaped())
      is_used[static_cast<std::size_t>(node)] = 1;
  }
  return is_used;
}

// Nodesets with nodes that no solid has, such as a beam's, of whose elements a gmsh file leaves a
// nodeset.
std::vector<std::string> loose_nodesets(const Mesh& mesh) {
  std::vector<std::string> texts;
  if (mesh.nodesets.empty()) return texts;
  const std::vector<char> is_of_solid = nodes_of_structure(mesh);
  for (const Nodeset& set : mesh.nodesets) {
    const auto loose = std::count_if(set.nodes.begin(), set.nodes.end(), [&](Index node) {
      return is_of_solid[static_cast<std::size_t>(node)] == 0;
    });
    if (loose > 0)
      texts.push_back(set.name + " (" + std::to_string(loose) + " of its " +
                      std::to_string(set.nodes.size()) + " nodes are of no element)");
  }
  return texts;
}

// Such as the last elements of a file that is cut between two lines have left. A few reference
// points are usual, and nodes of nodesets are told with these.
void add_unused_nodes(const Mesh& mesh, std::vector<std::string>& texts) {
  std::vector<char> is_used = nodes_of_structure(mesh);
  for (const Nodeset& set : mesh.nodesets)
    for (const Index node : set.nodes) is_used[static_cast<std::size_t>(node)] = 1;
  const auto n = std::count(is_used.begin(), is_used.end(), 0),
             all = static_cast<std::ptrdiff_t>(is_used.size());
  constexpr std::ptrdiff_t usual_share = 20;
  if (n * usual_share > all)
    texts.push_back(std::to_string(n) + " of its " + std::to_string(all) +
                    " nodes, as no solid has them (is the file cut short?)");
}

}  // namespace

void refuse_left_out_blocks(const Component& component, const Mesh& mesh) {
  const auto refuse = [&](const std::string& named, const Component::BlockOptions& options, Index n,
                          const std::string& type) {
    throw InputError(options.source.text() + ": components." + component.name + ".blocks." + named +
                     ": the " + std::to_string(n) + " " + type + " elements of " +
                     component.mesh.string() +
                     " have no thickness: add thickness, with which tri3 and quad4 are shells, or "
                     "remove the block from the scene");
  };
  for (const auto& [named, options] : component.blocks) {
    const Index found = find_block(mesh, named);
    if (found >= 0) {
      const Block& block = mesh.blocks[static_cast<std::size_t>(found)];
      if (!is_structure(block))
        refuse(named, options, block.connectivity.rows(), std::string(name(block.type)));
    }
  }
}

std::string left_out_blocks(const Mesh& mesh) {
  std::vector<std::string> texts;
  for (const Block& block : mesh.blocks)
    if (!is_structure(block))
      texts.push_back(block.name + " (" + std::to_string(block.connectivity.rows()) + " " +
                      std::string(name(block.type)) + ")");
  for (const std::string& text : loose_nodesets(mesh)) texts.push_back(text);
  add_unused_nodes(mesh, texts);
  return join(texts);
}

void warn_of_left_out_blocks(const Component& component, const std::string& blocks,
                             Report& report) {
  if (blocks.empty()) return;
  for (const auto& [named, options] : component.blocks)
    if ((", " + blocks).find(", " + named + " (") != std::string::npos)
      throw InputError(options.source.text() + ": components." + component.name + ".blocks." +
                       named + ": not computed with are " + blocks +
                       ": give the block a thickness, with which tri3 and quad4 are shells, or "
                       "take it out of the scene");
  const std::string before = report.about();
  report.about("");
  report.warning("component '" + component.name + "': " +
                 (component.has_mesh ? component.mesh : component.reduction->superelement)
                     .filename()
                     .string() +
                 ": left out: " + blocks +
                 ": only solids are used, and shells with a thickness (blocks.NAME.thickness); "
                 "these have no stiffness and no mass");
  report.about(before);
}

}  // namespace cbr

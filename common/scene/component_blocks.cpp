// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/component_blocks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/staleness.hpp"

namespace cbr {
namespace {

// Of each node: the number of elements of structure that have it.
std::vector<Index> uses_of_nodes(const Mesh& mesh) {
  std::vector<Index> uses(mesh.coordinates.rows(), 0);
  for (const Block& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    for (const Index node : block.connectivity.reshaped()) ++uses[node];
  }
  return uses;
}

// Whether a hex20 has four parallel edges that no other element has: it lies in a row.
bool is_in_row(const std::vector<Index>& uses, const Block& block, Index e) {
  for (const auto& edges : {std::array{8, 10, 16, 18}, {9, 11, 17, 19}, {12, 13, 14, 15}})
    if (std::all_of(edges.begin(), edges.end(),
                    [&](int i) { return uses[block.connectivity(e, i)] == 1; }))
      return true;
  return false;
}

// Nodesets with nodes that no solid has, such as a beam's, of whose elements a gmsh file leaves a
// nodeset.
std::vector<std::string> loose_nodesets(const Mesh& mesh) {
  std::vector<std::string> texts;
  if (mesh.nodesets.empty()) return texts;
  const std::vector<Index> is_of_solid = uses_of_nodes(mesh);
  for (const Nodeset& set : mesh.nodesets) {
    const auto loose = std::count_if(set.nodes.begin(), set.nodes.end(),
                                     [&](Index node) { return is_of_solid[node] == 0; });
    if (loose > 0)
      texts.push_back(set.name + " (" + std::to_string(loose) + " of its " +
                      std::to_string(set.nodes.size()) + " nodes are of no element)");
  }
  return texts;
}

// Such as the last elements of a file that is cut between two lines have left. A few reference
// points are usual, and the warning counts nodes of nodesets among these.
void add_unused_nodes(const Mesh& mesh, std::vector<std::string>& texts) {
  std::vector<Index> is_used = uses_of_nodes(mesh);
  for (const Nodeset& set : mesh.nodesets)
    for (const Index node : set.nodes) is_used[node] = 1;
  const auto n = std::count(is_used.begin(), is_used.end(), 0),
             all = static_cast<std::ptrdiff_t>(is_used.size());
  constexpr std::ptrdiff_t usual_share = 20;
  if (n * usual_share > all)
    texts.push_back(std::to_string(n) + " of its " + std::to_string(all) +
                    " nodes, as no solid has them (is the file cut short?)");
}

// sqrt(E / rho) of solids: foam has some 10 m/s, diamond 2e7 mm/s.
constexpr double slowest = 10, fastest = 2e7;

// Of elements that are too stiff in bending near a Poisson's ratio of 0.5: docs/theory.md, "1.
// Finite elements". Empty: no need.
std::string cure_of_locking(const std::string& element, double ratio) {
  constexpr double round_off = 1e-9;
  if (element == "hex8" || element == "hex8-incompatible")
    return ratio >= (element == "hex8" ? 0.49 : 0.499) - round_off
               ? "element: hex8-hourglass, or a mesh of hex20 or hex27"
               : "";
  const bool locks = element == "tet4" || element == "wedge6" || element == "pyramid5";
  return locks && ratio >= 0.49 - round_off ? "a mesh of tet10" : "";
}

// Numbers as in tables of psi and lbf/in^3. Of two metals alone, as other units have such numbers.
bool is_weight(double youngs_modulus, double density) {
  const auto are = [&](double E, double weight) {
    return std::abs(youngs_modulus / E - 1) < 0.05 && std::abs(density / weight - 1) < 0.05;
  };
  return are(2.95e7, 0.285) || are(1.015e7, 0.099);  // steel, aluminium
}

std::string speed_text(double speed) {
  return format_text("%.3g length units a second, ", speed) +
         (speed < slowest
              ? "slower than in any solid: is youngs_modulus in MPa beside a density in "
                "kg/m^3? With lengths in m give Pa, with mm give t/mm^3"
              : "faster than in any solid: is youngs_modulus in Pa beside a density in "
                "t/mm^3? With lengths in mm give MPa, with m give kg/m^3");
}

void warn_of_component(const Component& component, Report& report, const std::string& text) {
  const std::string before = report.about();
  report.about("component '" + component.name + "': ");
  report.warning(text);
  report.about(before);
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
      const Block& block = mesh.blocks[found];
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
  warn_of_component(component, report,
                    (component.has_mesh ? component.mesh : component.reduction->superelement)
                            .filename()
                            .string() +
                        ": left out: " + blocks +
                        ": only solids are used, and shells with a thickness "
                        "(blocks.NAME.thickness); these have no stiffness and no mass");
}

std::map<std::string, std::string> block_provenance(
    const Mesh& mesh, const std::vector<BlockProperties>& properties) {
  std::map<std::string, std::string> p;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    if (!is_structure(mesh.blocks[b])) continue;
    const Material& m = properties[b].material;
    const std::string key = "block " + mesh.blocks[b].name + ": ";
    for (const auto& [what, value] : material_provenance(m)) p[key + what] = value;
    if (const double thickness = mesh.blocks[b].thickness; thickness > 0)
      p[key + "thickness"] = number_text(thickness);
    p[key + "element"] = element_word(std::string(name(mesh.blocks[b].type)), properties[b].hex);
  }
  if (const std::string blocks = left_out_blocks(mesh); !blocks.empty()) p["left_out"] = blocks;
  return p;
}

void warn_of_blocks(const Component& component,
                    const std::map<std::string, std::string>& provenance, Report& report) {
  const auto text = [&](const std::string& key) {
    const auto found = provenance.find(key);
    return found == provenance.end() ? std::string() : found->second;
  };
  warn_of_left_out_blocks(component, text("left_out"), report);
  std::map<std::string, std::vector<std::string>> warnings;  // with the names of their blocks
  for (const auto& [key, element] : provenance) {
    constexpr std::string_view begin = "block ", end = ": element";
    if (!key.starts_with(begin) || !key.ends_with(end)) continue;
    const std::string block = key.substr(0, key.size() - end.size()),
                      name = block.substr(begin.size());
    // of an orthotropic material "[...]", which is no number
    const auto number = [&](const char* of) {
      const std::string value = text(block + ": " + of);
      return value.empty() || value.front() == '[' ? NAN : std::strtod(value.c_str(), nullptr);
    };
    const double youngs_modulus = number("youngs_modulus"), density = number("density"),
                 ratio = number("poissons_ratio"), speed = std::sqrt(youngs_modulus / density);
    // A density of 1 is that of quantities without units
    if (density != 1 && (speed < slowest || speed > fastest))
      warnings["waves travel at sqrt(E / rho) = " + speed_text(speed)].push_back(name);
    if (is_weight(youngs_modulus, density))
      warnings[format_text("a density of %g beside %g psi is a metal's weight in lbf/in^3: divide "
                           "it by 386.1 in/s^2",
                           density, youngs_modulus)]
          .push_back(name);
    if (const std::string cure = cure_of_locking(element, ratio); !cure.empty())
      warnings[element + " locks at a Poisson's ratio of " + format_text("%.6g", ratio) +
               ", so that the part is too stiff in bending: use " + cure]
          .push_back(name);
  }
  for (const auto& [what, blocks] : warnings)
    warn_of_component(component, report, "block " + join(blocks) + ": " + what);
}

void warn_of_mesh(const Component& component, const Mesh& mesh,
                  const std::vector<BlockProperties>& properties, Report& report) {
  if (!mesh.dropped.empty())
    warn_of_component(component, report,
                      component.mesh.filename().string() + ": not read: " + mesh.dropped);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (block.type != ElementType::hex20 || properties[b].hex != HexFormulation::reduced) continue;
    const std::vector<Index> uses = uses_of_nodes(mesh);
    Index n = 0;
    for (Index e = 0; e < block.connectivity.rows(); ++e) n += is_in_row(uses, block, e);
    if (n > 0)
      warn_of_component(component, report,
                        "block " + block.name + ": " + std::to_string(n) +
                            " hex20 of reduced integration lie in rows of single elements, which "
                            "have motions without stiffness: mesh two across, or give element: "
                            "hex8, which integrates hex20 in full");
  }
}

MassKind mass_of_mesh(const Component& component) {
  return component.mass.value_or(MassKind::lumped);
}

MassKind mass_of_superelement(const Component& component, const Mesh& mesh) {
  if (component.mass) return *component.mass;
  const bool spoilt = std::any_of(mesh.blocks.begin(), mesh.blocks.end(), [](const Block& block) {
    return is_structure(block) && is_spoilt_by_lumping(std::string(name(block.type)));
  });
  return spoilt ? MassKind::consistent : MassKind::lumped;
}

bool is_spoilt_by_lumping(const std::string& element) {
  return element.starts_with("hex20") || element == "tet10" || element.starts_with("wedge15") ||
         element == "tri3" || element == "quad4";
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/superelement_alone.hpp"

#include <algorithm>
#include <charconv>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement_group.hpp"
#include "dynamics/setup/components/component_model.hpp"

namespace cbr {
namespace {

void take_options(ReductionOptions& reduction) {
  const Hdf5Reader file(reduction.superelement);
  // A basis of other programs has Craig-Bampton matrices.
  if (file.has_attribute("/", "basis"))
    reduction.basis =
        value_of(basis_words, file.read_string("/", "basis")).value_or(Basis::craig_bampton);
  if (is_superelement_group(reduction.superelement))
    reduction.domains = file.read_index("/", "n_domains");
  if (!file.has("/fixed/resisted")) return;
  FixedSet& fixed = reduction.fixed.emplace_back();
  fixed.source = reduction.source;
  const Matrix resisted = file.read_matrix("/fixed/resisted");
  for (Index axis = 0; axis < std::min<Index>(3, resisted.cols()); ++axis)
    fixed.fix[axis] = resisted.col(axis).norm() > 1e-9;
}

}  // namespace

Scene with_options_of_files(const Scene& scene) {
  Scene known = scene;
  for (const Instance& instance : known.instances) {
    const auto found = known.components.find(instance.component);
    if (found == known.components.end() || found->second.has_mesh) continue;
    try {
      take_options(*found->second.reduction);
    } catch (const InputError&) {
      // Reading the whole file reports it with its place
    }
  }
  return known;
}

std::vector<BlockProperties> properties_in_file(
    const Component& component, const std::map<std::string, std::string>& provenance,
    const std::vector<Block>& blocks) {
  std::vector<BlockProperties> properties;
  for (const Block& block : blocks) {
    const auto told = [&](const char* what) {
      const auto found = provenance.find("block " + block.name + ": " + what);
      return found == provenance.end() ? std::string() : found->second;
    };
    const auto number = [&](const char* what) {
      const std::string text = told(what);
      double value = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error == std::errc() && end == text.data() + text.size()) return value;
      refuse_file(component, "has no single " + std::string(what) + " of block '" + block.name +
                                 "' (none, or an orthotropic material), which stress needs: leave "
                                 "stress out of output.fields");
    };
    BlockProperties of;
    of.material = {number("youngs_modulus"), number("poissons_ratio"), number("density")};
    const std::string element = told("element");
    for (const auto& [word, formulation] : hex_words)
      if (element_word(std::string(name(block.type)), formulation) == element) of.hex = formulation;
    properties.push_back(of);
  }
  return properties;
}

void refuse_file(const Component& component, const std::string& what) {
  throw InputError(component.source.text() + ": component '" + component.name +
                   "': the superelement " + component.reduction->superelement.string() + " " +
                   what);
}

void require_face_centres(const Component& component, const std::string& cure) {
  if (lacks_face_centres(component.reduction->superelement))
    refuse_file(component,
                "is of hex27 and lacks the centre nodes of its faces, which versions before 0.2 "
                "lost" +
                    cure);
}

void require_superelement(const Component& component) {
  if (!std::filesystem::exists(component.reduction->superelement))
    refuse_file(component, "does not exist: give the path of a superelement (.cbr.h5)");
  require_face_centres(component, ": reduce its component again");
}

std::map<Index, Index> separate_rotations(Superelement& s) {
  const auto n = static_cast<Index>(s.node_ids.size());
  std::map<Index, Index> rotations;
  for (std::size_t i = 0; i < s.dof_node.size(); ++i) {
    if (s.dof_component[i] < 3) continue;
    const auto next = n + static_cast<Index>(rotations.size());
    s.dof_node[i] = rotations.try_emplace(s.dof_node[i], next).first->second;
  }
  const auto more = static_cast<Index>(rotations.size());
  if (more == 0) return rotations;
  s.coordinates.conservativeResize(n + more, Eigen::NoChange);
  s.node_ids.resize(static_cast<std::size_t>(n + more));
  for (const auto& [node, rotation] : rotations) {
    s.coordinates.row(rotation) = s.coordinates.row(node);
    s.node_ids[rotation] = s.node_ids[node];
  }
  // Recovery data number interior nodes after the interface's last
  const auto shift = [&](Index& place) { place += place >= n ? more : 0; };
  for (Superelement::Recovery& recovery : s.recovery) {
    for (Index& place : recovery.rotations) shift(place);
    for (Block& block : recovery.blocks)
      for (Index& place : block.connectivity.reshaped()) shift(place);
  }
  for (auto& [name, nodes] : s.recovered_sets)
    for (Index& place : nodes) shift(place);
  return rotations;
}

}  // namespace cbr

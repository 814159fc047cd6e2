// SPDX-License-Identifier: GPL-3.0-or-later
// The options of a reduction, one entry each. From this table follow the keys of the scene, what
// cbr-reduce hands on, the content hash, /provenance, and the command line of cbr-reduce.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/scene/scene_keys.hpp"

namespace cbr {

struct ReductionKey {
  SceneKey scene;  // of `reduction`
  // How its line of the hash begins. Empty: the option does not change the superelement, or
  // characteristic_text() has it.
  std::string hash = {};
  // The attribute of /provenance; empty: none.
  std::string provenance = {};
  std::optional<Basis> only_with = {};
  // Of cbr-reduce; empty: none.
  std::string option = {}, type_name = {}, help = {};
  // Values that --option allows, for its message.
  std::string allowed = {};
  // A word that is refused, and the cure.
  std::string retired = {}, successor = {};

  // Files that are older than the key have no line of it, and are up to date where it is not
  // written.
  bool is_younger = false;

  bool goes_with(Basis basis) const { return !only_with || *only_with == basis; }
  bool has_line(Basis basis) const { return goes_with(basis) && (!is_younger || scene.is_written); }
};

// Of `fixed`, in yaml/scene_parse_reduction.cpp.
void read_fixed(const SceneNode& node, const SceneReading& reading, std::vector<FixedSet>& fixed);
std::string fixed_text(const std::vector<FixedSet>& fixed);

// The table, bound to these options.
std::vector<ReductionKey> reduction_keys(ReductionOptions& reduction);
// Its keys of the scene, of which those of other bases are not written.
std::vector<SceneKey> scene_keys(ReductionOptions& reduction);

// True if `given` names the key. Keys that are not given follow from those that are.
void complete(ReductionOptions& reduction, const std::vector<std::string>& given);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Contact pairs by the scene's entries.
#pragma once

#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// A surface of an instance in contact, by the instance's index and the surface's name; "all" with
// `whole`: all surfaces joined.
struct SideName {
  Index instance = 0;
  std::string surface;
  bool whole = false;
  bool operator<(const SideName& other) const {
    return std::tie(instance, whole, surface) <
           std::tie(other.instance, other.whole, other.surface);
  }
};

// A pair to be made; `all` makes many from one entry of the scene.
struct ContactEntry {
  const ContactOptions* options = nullptr;
  const SideName *first = nullptr, *second = nullptr;
  const WallOptions* wall = nullptr;  // then there is no second side
};

struct ContactEntries {
  std::set<SideName> sides;  // targets of the entries' pointers
  std::vector<ContactEntry> list;
};

// Explicit entries, then those of `all`: each pair of instances, or of an instance and a wall,
// without an explicit entry, or with ties alone. InputError if `all` finds none, or more than fit
// in memory.
ContactEntries contact_entries(const SceneIndex& index, const BuiltScene& built, Report& report);

// InputError if the state of the pairs of `contact: all` needs more than `memory` bytes.
void require_memory_for_pairs(double n_pairs, double memory, const ContactOptions& all);

}  // namespace cbr

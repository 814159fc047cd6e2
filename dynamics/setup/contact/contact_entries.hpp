// SPDX-License-Identifier: GPL-3.0-or-later
// Which pairs a scene asks for.
#pragma once

#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "dynamics/setup/built/built_scene.hpp"

namespace cbr {

// A surface of an instance that takes part, by the instance's index and the surface's name; "all"
// with `whole`: all of them joined.
struct SideName {
  Index instance = 0;
  std::string surface;
  bool whole = false;
  bool operator<(const SideName& other) const {
    return std::tie(instance, whole, surface) <
           std::tie(other.instance, other.whole, other.surface);
  }
};

// One pair to be: `all` makes many of one entry of the scene.
struct ContactEntry {
  const ContactOptions* options = nullptr;
  const SideName *first = nullptr, *second = nullptr;
  const WallOptions* wall = nullptr;  // then there is no second
};

struct ContactEntries {
  std::set<SideName> sides;  // that the entries point to
  std::vector<ContactEntry> list;
};

// Those that the scene names, then those that `all` stands for: every two instances, and every
// instance with every wall, that no explicit entry names. InputError when `all` finds none, or more
// than memory holds.
ContactEntries contact_entries(const SceneIndex& index, const BuiltScene& built, Report& report);

// InputError when `contact: all` makes so many pairs that `memory` bytes cannot hold what each
// keeps from step to step.
void require_memory_for_pairs(double n_pairs, double memory, const ContactOptions& all);

}  // namespace cbr

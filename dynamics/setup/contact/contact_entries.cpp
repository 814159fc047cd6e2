// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_entries.hpp"

#include <algorithm>
#include <set>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "dynamics/setup/components/contact_faces.hpp"

namespace cbr {
namespace {

// Members of explicit entries: two instances, or an instance and a wall. Ties without a pretension
// are not among them: what is not tied of their instances meets.
struct Named {
  std::set<std::pair<Index, Index>> instances;
  std::set<std::pair<Index, const WallOptions*>> walls;
};

Named named_by(const std::vector<ContactEntry>& entries, const ContactOptions& all) {
  Named named;
  for (const ContactEntry& entry : entries) {
    if (entry.wall) named.walls.emplace(entry.first->instance, entry.wall);
    const ContactOptions& of = *entry.options;
    if (!entry.wall && (all.tied || !of.tied || of.pretension_force || of.shortening))
      named.instances.insert(std::minmax(entry.first->instance, entry.second->instance));
  }
  return named;
}

ContactEntries explicit_entries(const SceneIndex& index) {
  ContactEntries entries;
  const auto side = [&](const SurfaceName& name) {
    return &*entries.sides.insert({index.place(name.instance), name.surface, false}).first;
  };
  std::unordered_map<std::string, const WallOptions*> walls;
  for (const WallOptions& wall : index.scene().walls) walls[wall.name] = &wall;
  for (const ContactOptions& options : index.scene().contact) {
    if (options.all) continue;
    ContactEntry entry;
    entry.options = &options;
    entry.first = side(options.first);
    if (options.second.is_wall()) {
      entry.wall = walls.at(options.second.surface);
    } else {
      entry.second = side(options.second);
    }
    entries.list.push_back(entry);
  }
  return entries;
}

// Adds all pairs of instances, and of instances and walls, without an explicit entry.
void add_all(const Scene& scene, const BuiltScene& built, const ContactOptions& options,
             const Named& named, Report& report, ContactEntries& entries) {
  std::vector<const SideName*> sides;
  for (Index i = 0; i < static_cast<Index>(built.instances.size()); ++i) {
    if (has_faces(*built.instances[i].geometry)) {
      sides.push_back(&*entries.sides.insert({i, "all", true}).first);
    } else {
      report.line("note: contact: all leaves out instance '" + built.instances[i].name +
                  "', which has no surfaces");
    }
  }
  const auto n = static_cast<double>(sides.size());
  require_memory_for_pairs(n * (n - 1) / 2, machine_memory_bytes(), options);
  bool any = false;
  for (std::size_t a = 0; a < sides.size(); ++a) {
    for (std::size_t b = a + 1; b < sides.size(); ++b) {
      any = true;
      if (!named.instances.count({sides[a]->instance, sides[b]->instance}))
        entries.list.push_back({&options, sides[a], sides[b], nullptr});
    }
    for (const WallOptions& wall : scene.walls) {
      if (options.tied) continue;
      any = true;
      if (!named.walls.count({sides[a]->instance, &wall}))
        entries.list.push_back({&options, sides[a], nullptr, &wall});
    }
  }
  if (any) return;
  throw InputError(
      options.source.text() + ": contact: all finds no pair: " + std::to_string(sides.size()) +
      " instances with surfaces and " + std::to_string(options.tied ? 0 : scene.walls.size()) +
      " rigid walls, expected two instances" + (options.tied ? "" : ", or one and a wall"));
}

}  // namespace

void require_memory_for_pairs(double n_pairs, double memory, const ContactOptions& all) {
  // measured with 3000 instances that never meet: docs/stability-load.md
  constexpr double bytes_of_pair = 300;
  if (n_pairs * bytes_of_pair <= memory) return;
  std::ostringstream text;
  text.precision(3);
  text << all.source.text() << ": contact: all makes " << n_pairs << " pairs, which take "
       << human_bytes(n_pairs * bytes_of_pair) << " or more, the machine has "
       << human_bytes(memory) << ": name the pairs that can meet";
  throw InputError(text.str());
}

ContactEntries contact_entries(const SceneIndex& index, const BuiltScene& built, Report& report) {
  const Scene& scene = index.scene();
  ContactEntries entries = explicit_entries(index);
  for (const ContactOptions& options : scene.contact)
    if (options.all)
      add_all(scene, built, options, named_by(entries.list, options), report, entries);
  return entries;
}

}  // namespace cbr

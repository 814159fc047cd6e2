// SPDX-License-Identifier: GPL-3.0-or-later
// Contact pairs by the scene's entries, the surfaces of instances in them, and their nodes.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/mesh/pressure_functions.hpp"
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

// By instance: its index in Simulation::contact_nodes.
using ContactNumbers = std::map<Index, Index>;

// Data of sides, made once for all their pairs. Keyed by address.
class ContactSides {
 public:
  // `built` must outlive this object.
  explicit ContactSides(const BuiltScene& built) : built_(built) {}

  // Faces by the instance's nodes, outward in the scene.
  const IndexTable& faces(const SideName& name, const SourceLine& source);
  // By the contact nodes of its body, which must exist. `whole`: second-order faces are not cut
  // into linear ones.
  std::shared_ptr<const ContactSurface> surface(const SideName& name, bool whole,
                                                const ContactNumbers& contact_of_instance);
  // A surface without the faces between nodes in `tied`, which are tied to the other side, and
  // `by_nodes`: without the nodes, as none of them is to be tested.
  std::shared_ptr<const ContactSurface> untied(const ContactSurface& surface,
                                               const std::set<Index>& tied, bool by_nodes) const;
  // By the surface's slots; `wanted`: number of functions, above 0.
  std::shared_ptr<const PressureFunctions> functions(const SideName& name, Index wanted);
  // Likewise: corner_functions() of second-order faces; null if all are linear.
  std::shared_ptr<const PressureFunctions> corners(const SideName& name);
  // By the instance's nodes, with the mesh's faces.
  std::vector<const Surface*> surfaces(const SideName& name) const;
  bool is_mirrored(const SideName& name) const;

 private:
  IndexTable whole_faces_of(const SideName& name) const;
  void measure(const std::set<Index>& tied, ContactSurface& surface) const;

  const BuiltScene& built_;
  std::unordered_map<const SideName*, IndexTable> faces_;
  // with second-order faces cut, and whole
  std::unordered_map<const SideName*, std::shared_ptr<const ContactSurface>> cut_, whole_;
  std::map<std::pair<const SideName*, Index>, std::shared_ptr<const PressureFunctions>> functions_;
  std::unordered_map<const SideName*, std::shared_ptr<const PressureFunctions>> corners_;
};

// InputError if two surfaces of one instance share nodes.
void refuse_shared_nodes(const ContactEntry& entry, ContactSides& sides);

// Instances in contact with their sides: few each, for any number of pairs.
using SidesOfInstances = std::map<Index, std::vector<const SideName*>>;
SidesOfInstances sides_of_instances(const std::vector<ContactEntry>& entries);

// Makes Simulation::contact_nodes: the nodes of instances in contact. `linked`: further ones, by
// instance.
ContactNumbers add_contact_nodes(SidesOfInstances names,
                                 const std::map<Index, std::set<Index>>& linked,
                                 ContactSides& sides, Simulation& sim);

// Tributary areas, for nodal pressures.
void fill_areas(const SidesOfInstances& names, const ContactNumbers& contact_of_instance,
                ContactSides& sides, Simulation& sim);

}  // namespace cbr

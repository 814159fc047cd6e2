// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces of instances that take part in contact, and the nodes of them.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/mesh/pressure_functions.hpp"
#include "dynamics/setup/contact/contact_entries.hpp"

namespace cbr {

// By instance: its place in Simulation::contact_nodes.
using ContactNumbers = std::map<Index, Index>;

// What sides are, made once however many pairs they are in. By their addresses.
class ContactSides {
 public:
  // `built` must outlive it.
  explicit ContactSides(const BuiltScene& built) : built_(built) {}

  // Faces in the instance's nodes, outward in the scene.
  const IndexTable& faces(const SideName& name, const SourceLine& source);
  // In the contact nodes of its body, which are known by now. `whole`: faces of second order are
  // not cut into linear ones.
  std::shared_ptr<const ContactSurface> surface(const SideName& name, bool whole,
                                                const ContactNumbers& contact_of_instance);
  // Of the surface's nodes, in its slots; `wanted` of them, above 0.
  std::shared_ptr<const PressureFunctions> functions(const SideName& name, Index wanted);
  // Likewise: corner_functions() of faces of second order; null where all are linear.
  std::shared_ptr<const PressureFunctions> corners(const SideName& name);
  // In the instance's nodes, as the mesh has them.
  std::vector<const Surface*> surfaces(const SideName& name) const;
  bool is_mirrored(const SideName& name) const;

 private:
  IndexTable whole_faces_of(const SideName& name) const;

  const BuiltScene& built_;
  std::unordered_map<const SideName*, IndexTable> faces_;
  // with faces of second order cut, and whole
  std::unordered_map<const SideName*, std::shared_ptr<const ContactSurface>> cut_, whole_;
  std::map<std::pair<const SideName*, Index>, std::shared_ptr<const PressureFunctions>> functions_;
  std::unordered_map<const SideName*, std::shared_ptr<const PressureFunctions>> corners_;
};

// InputError where two surfaces of one instance have common nodes.
void refuse_shared_nodes(const ContactEntry& entry, ContactSides& sides);

// Which instances take part, with which sides: few each, however many pairs they are in.
using SidesOfInstances = std::map<Index, std::vector<const SideName*>>;
SidesOfInstances sides_of_instances(const std::vector<ContactEntry>& entries);

// Makes Simulation::contact_nodes: the nodes with which instances take part. `linked`: further
// ones, by instance.
ContactNumbers add_contact_nodes(SidesOfInstances names,
                                 const std::map<Index, std::set<Index>>& linked,
                                 ContactSides& sides, Simulation& sim);

// What nodal pressures are measured by.
void fill_areas(const SidesOfInstances& names, const ContactNumbers& contact_of_instance,
                ContactSides& sides, Simulation& sim);

}  // namespace cbr

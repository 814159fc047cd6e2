// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact_setup.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "common/error.hpp"

namespace cbr {
namespace {

struct ContactSide {
  Index instance = 0;
  LinearFaces faces;  // the instance's nodes
};

ContactSide side_of(const Scene& scene, const BuiltScene& built, const SurfaceName& name) {
  ContactSide side;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (scene.instances[i].name == name.instance) side.instance = static_cast<Index>(i);
  const auto& of = built.instances[side.instance];
  const Surface& surface = find_surface(*of.geometry, name.instance, name.surface, name.source);
  side.faces = linear_faces(surface);
  if (of.placement.T.determinant() < 0) {
    // A mirror turns faces inside out: (a b c d) -> (a d c b), a triangle (a b c c) -> (a c b b).
    for (Index f = 0; f < side.faces.faces.rows(); ++f) {
      auto row = side.faces.faces.row(f);
      if (row(2) == row(3)) {
        std::swap(row(1), row(2));
        row(3) = row(2);
      } else {
        std::swap(row(1), row(3));
      }
    }
  }
  return side;
}

ContactSurface local_surface(const ContactSide& side, const SurfaceName& name, const std::map<Index, Index>& contact_of_instance,
                             const BuiltScene& built) {
  ContactSurface surface;
  surface.name = name.text();
  surface.body = contact_of_instance.at(side.instance);
  const ContactNodes& contact = built.simulation.contact_nodes[surface.body];
  surface.faces = side.faces.faces;
  std::set<Index> used;
  for (Index i = 0; i < surface.faces.size(); ++i) {
    Index& node = surface.faces.data()[i];
    node = std::lower_bound(contact.nodes.begin(), contact.nodes.end(), node) - contact.nodes.begin();
    used.insert(node);
  }
  surface.nodes.assign(used.begin(), used.end());
  fill_sizes(surface, built.simulation.bodies[contact.body]->reference_positions()(contact.nodes, Eigen::all));
  return surface;
}

void warn_nodal(const ContactOptions& options, const BuiltScene& built, const ContactPair& pair, Report& report) {
  std::ostringstream text;
  text.precision(4);
  text << options.source.text() << ": contact " << pair.name
       << ": enforcement: nodal weighs each contact node by the row sum of its body's mass, which is not what the node weighs "
          "against an "
          "impulse; the contact surfaces stand for";
  for (const ContactSurface* surface : {&pair.slave, &pair.master}) {
    const ContactNodes& contact = built.simulation.contact_nodes[surface->body];
    const Body& body = *built.simulation.bodies[contact.body];
    const Points masses = body.nodal_masses(contact.set);
    double sum = 0;  // mean over the three directions
    for (const Index node : surface->nodes) sum += masses.row(node).mean();
    const double total = built.instances[contact.body].mass;
    text << (surface == &pair.slave ? " " : " and ") << sum / total << " of the mass of '" << body.name() << "'";
  }
  text << " (1: a perfectly plastic impact of whole bodies): use enforcement: impulse for a right answer";
  report.warning(text.str());
}

}  // namespace

std::vector<ContactKind> add_contact(const Scene& scene, BuiltScene& built, Report& report) {
  Simulation& sim = built.simulation;
  std::vector<ContactKind> in_contact(sim.bodies.size(), ContactKind::none);
  std::vector<std::pair<ContactSide, ContactSide>> sides;
  std::map<Index, std::set<Index>> nodes;
  for (const ContactOptions& options : scene.contact) {
    if (options.all || options.second.is_wall())
      throw InputError(options.source.text() + ": contact: all and rigid walls are not available yet in this version");
    sides.emplace_back(side_of(scene, built, options.first), side_of(scene, built, options.second));
    for (const ContactSide* side : {&sides.back().first, &sides.back().second}) {
      ContactKind& kind = in_contact[side->instance];
      kind = std::max(kind, options.enforcement == Enforcement::penalty ? ContactKind::penalty : ContactKind::hard);
      const IndexTable& faces = side->faces.faces;
      nodes[side->instance].insert(faces.data(), faces.data() + faces.size());
    }
  }
  std::map<Index, Index> contact_of_instance;
  for (const auto& [instance, set] : nodes) {
    ContactNodes contact;
    contact.body = instance;
    contact.nodes.assign(set.begin(), set.end());
    contact.set = sim.bodies[instance]->track(contact.nodes);
    contact_of_instance[instance] = static_cast<Index>(sim.contact_nodes.size());
    sim.contact_nodes.push_back(std::move(contact));
  }
  for (std::size_t i = 0; i < scene.contact.size(); ++i) {
    const ContactOptions& options = scene.contact[i];
    ContactSurface first = local_surface(sides[i].first, options.first, contact_of_instance, built);
    ContactSurface second = local_surface(sides[i].second, options.second, contact_of_instance, built);
    ContactPair pair;
    pair.name = options.first.text() + " - " + options.second.text();
    pair.enforcement = options.enforcement;
    const bool swap = second.size < first.size * (1 - 1e-6);
    pair.slave = std::move(swap ? second : first);
    pair.master = std::move(swap ? first : second);
    if (pair.enforcement == Enforcement::nodal) warn_nodal(options, built, pair, report);
    sim.pairs.push_back(std::move(pair));
  }
  return in_contact;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/friction_shapes.hpp"

#include <sstream>
#include <vector>

#include "common/linalg/dense.hpp"
#include "common/report.hpp"

namespace cbr {
namespace {

// Directions with less than this share of the largest are none.
constexpr double weakest_shape = 1e-6;

struct Shapes {
  Index found = 0, wanted = 0;
};

// Rank of the interface's rows of a face, and how many rows these are; nothing for bodies of other bases.
Shapes shapes_of(const ContactSurface& surface, const BuiltScene& built) {
  const ContactNodes& contact = built.simulation.contact_nodes[surface.body];
  const BuiltScene::OfInstance& instance = built.instances[contact.body];
  if (instance.parts.size() != 1 || !instance.parts[0].superelement->is_characteristic()) return {};
  const ReducedPart& part = instance.parts[0];
  const Superelement& s = *part.superelement;
  std::vector<char> on_face(static_cast<std::size_t>(built.simulation.bodies[contact.body]->reference_positions().rows()), 0);
  for (const Index node : surface.nodes) on_face[static_cast<std::size_t>(contact.nodes[node])] = 1;
  std::vector<Index> rows;
  for (Index i = 0; i < s.c(); ++i)
    if (on_face[static_cast<std::size_t>(part.node[s.dof_node[i]])] != 0) rows.push_back(i);
  if (s.characteristic.V.rows() != s.c() || rows.empty()) return {};
  const PivotedQr qr(s.characteristic.V(rows, Eigen::all), weakest_shape);
  return {qr.rank(), static_cast<Index>(rows.size())};
}

}  // namespace

void warn_of_few_shapes(const ContactPair& pair, const BuiltScene& built, Report& report) {
  if (pair.law.law != ContactLaw::coulomb) return;
  for (const ContactSurface* surface : {pair.slave.get(), pair.master.get()}) {
    if (surface->nodes.empty()) continue;  // a wall
    const Shapes shapes = shapes_of(*surface, built);
    if (shapes.found == shapes.wanted) continue;
    std::ostringstream text;
    text << pair.source->text() << ": contact " << pair.name << ": friction on " << surface->name << ", whose " << shapes.wanted
         << " directions move in " << shapes.found
         << " shapes only (basis: characteristic), takes up to several times the energy that it should: keep the face's nodes "
            "(characteristic.keep), or take it without friction";
    report.warning(text.str());
  }
}

}  // namespace cbr

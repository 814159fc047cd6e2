// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_sides.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"
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

const IndexTable& ContactSides::faces(const SideName& name, const SourceLine& source) {
  const auto [at, is_new] = faces_.try_emplace(&name);
  if (!is_new) return at->second;
  const auto& of = built_.instances[name.instance];
  at->second = name.whole
                   ? all_faces(*of.geometry)
                   : contact_faces(find_surface(*of.geometry, of.name, name.surface, source));
  if (is_mirrored(name)) turn_over(at->second);
  return at->second;
}

std::shared_ptr<const ContactSurface> ContactSides::surface(
    const SideName& name, bool whole, const ContactNumbers& contact_of_instance) {
  const auto [at, is_new] = (whole ? whole_ : cut_).try_emplace(&name);
  if (!is_new) return at->second;
  ContactSurface surface;
  surface.name = built_.instances[name.instance].name + "." + name.surface;
  surface.body = contact_of_instance.at(name.instance);
  const ContactNodes& contact = built_.simulation.contact_nodes[surface.body];
  const auto local = [&](Index node) {
    return node < 0 ? node
                    : std::lower_bound(contact.nodes.begin(), contact.nodes.end(), node) -
                          contact.nodes.begin();
  };
  const IndexTable faces = (whole ? whole_faces_of(name) : faces_.at(&name)).unaryExpr(local);
  surface.nodes = nodes_of(faces);
  if (surface.nodes.front() < 0) surface.nodes.erase(surface.nodes.begin());
  surface.faces = faces.leftCols(4);
  if (whole && faces.rightCols(5).maxCoeff() >= 0) surface.middle = faces.rightCols(5);
  measure({}, surface);
  return at->second = std::make_shared<const ContactSurface>(std::move(surface));
}

// tied: nodes that are not tested. Faces may have them, but not all of their nodes.
void ContactSides::measure(const std::set<Index>& tied, ContactSurface& surface) const {
  const ContactNodes& contact = built_.simulation.contact_nodes[surface.body];
  Body& body = *built_.simulation.bodies[contact.body];
  const Points points = body.reference_positions()(contact.nodes, Eigen::all);
  fill_sizes(surface, points);
  if (!tied.empty()) {
    std::vector<Index> kept;
    for (std::size_t slot = 0; slot < surface.nodes.size(); ++slot)
      if (tied.count(surface.nodes[slot]) == 0) kept.push_back(static_cast<Index>(slot));
    surface.areas = surface.areas(kept).eval();
    surface.area_vectors = surface.area_vectors(kept, Eigen::all).eval();
    std::erase_if(surface.nodes, [&](Index node) { return tied.count(node) != 0; });
  }
  // With large rotation a massless interface gains energy where edge contacts begin and end
  if (!body.facts().kicks_at_end || !body.turns()) fill_edges(surface, points);
  if (body.turns()) surface.extent.setConstant(surface.extent.norm());
}

std::shared_ptr<const ContactSurface> ContactSides::untied(const ContactSurface& surface,
                                                           const std::set<Index>& tied,
                                                           bool by_nodes) const {
  ContactSurface rest = surface;
  std::vector<Index> kept;
  for (Index f = 0; f < surface.faces.rows(); ++f)
    if (std::any_of(surface.faces.row(f).begin(), surface.faces.row(f).end(),
                    [&](Index node) { return tied.count(node) == 0; }))
      kept.push_back(f);
  rest.faces = surface.faces(kept, Eigen::all);
  if (surface.middle.rows() > 0) rest.middle = surface.middle(kept, Eigen::all);
  measure(by_nodes ? tied : std::set<Index>(), rest);
  return std::make_shared<const ContactSurface>(std::move(rest));
}

std::shared_ptr<const PressureFunctions> ContactSides::functions(const SideName& name,
                                                                 Index wanted) {
  const auto [at, is_new] = functions_.try_emplace({&name, wanted});
  if (!is_new) return at->second;
  at->second = std::make_shared<const PressureFunctions>(
      pressure_functions(distinct_surfaces(surfaces(name)),
                         built_.instances[name.instance].geometry->coordinates, wanted));
  return at->second;
}

std::vector<const Surface*> ContactSides::surfaces(const SideName& name) const {
  const auto& of = built_.instances[name.instance];
  if (name.whole) return all_surfaces(*of.geometry);
  return {&find_surface(*of.geometry, of.name, name.surface, {})};
}

namespace {

std::vector<Surface> of_second_order(std::vector<Surface> surfaces) {
  std::erase_if(surfaces, [](const Surface& surface) { return !is_second_order(surface); });
  return surfaces;
}

// Moves rows of `matrix` from nodes `from` to nodes `to`, a superset.
SparseMatrix on_nodes(const SparseMatrix& matrix, const std::vector<Index>& from,
                      const std::vector<Index>& to) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index a = 0; a < matrix.cols(); ++a)
    for (SparseMatrix::InnerIterator it(matrix, a); it; ++it) {
      const Index node = from[it.row()];
      entries.emplace_back(std::lower_bound(to.begin(), to.end(), node) - to.begin(), a,
                           it.value());
    }
  SparseMatrix moved(static_cast<Index>(to.size()), matrix.cols());
  moved.setFromTriplets(entries.begin(), entries.end());
  return moved;
}

}  // namespace

std::shared_ptr<const PressureFunctions> ContactSides::corners(const SideName& name) {
  const auto [at, is_new] = corners_.try_emplace(&name);
  if (!is_new) return at->second;
  const std::vector<Surface> second = of_second_order(distinct_surfaces(surfaces(name)));
  if (second.empty()) return {};
  PressureFunctions of =
      corner_functions(second, built_.instances[name.instance].geometry->coordinates);
  std::vector<Index> nodes = nodes_of(faces_.at(&name));
  if (nodes.front() < 0) nodes.erase(nodes.begin());
  of.N = on_nodes(of.N, of.nodes, nodes);
  of.Psi = on_nodes(of.Psi, of.nodes, nodes);
  of.nodes = std::move(nodes);
  return at->second = std::make_shared<const PressureFunctions>(std::move(of));
}

IndexTable ContactSides::whole_faces_of(const SideName& name) const {
  const auto& of = built_.instances[name.instance];
  IndexTable faces = name.whole
                         ? all_whole_faces(*of.geometry)
                         : whole_faces(find_surface(*of.geometry, of.name, name.surface, {}));
  if (is_mirrored(name)) turn_over(faces);
  return faces;
}

bool ContactSides::is_mirrored(const SideName& name) const {
  return built_.instances[name.instance].placement.T.determinant() < 0;
}

// Two parts of one body may touch (prongs of a fork), unless they share nodes.
void refuse_shared_nodes(const ContactEntry& entry, ContactSides& sides) {
  if (entry.wall || entry.first->instance != entry.second->instance) return;
  const ContactOptions& options = *entry.options;
  const auto first = nodes_of(sides.faces(*entry.first, options.first.source));
  const auto second = nodes_of(sides.faces(*entry.second, options.second.source));
  std::vector<Index> shared;
  std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                        std::back_inserter(shared));
  if (shared.empty()) return;
  throw InputError(options.source.text() + ": contact between " + options.first.text() + " and " +
                   options.second.text() + ": the surfaces share " + std::to_string(shared.size()) +
                   " nodes of one instance, and a surface cannot be in contact with itself: name "
                   "surfaces without common nodes");
}

SidesOfInstances sides_of_instances(const std::vector<ContactEntry>& entries) {
  SidesOfInstances names;
  const auto add = [&](const SideName* side) {
    std::vector<const SideName*>& list = names[side->instance];
    if (std::find(list.begin(), list.end(), side) == list.end()) list.push_back(side);
  };
  for (const ContactEntry& entry : entries) {
    add(entry.first);
    if (!entry.wall) add(entry.second);
  }
  return names;
}

ContactNumbers add_contact_nodes(SidesOfInstances names,
                                 const std::map<Index, std::set<Index>>& linked,
                                 ContactSides& sides, Simulation& sim) {
  ContactNumbers contact_of_instance;
  for (const auto& [instance, nodes] : linked) names.try_emplace(instance);
  for (const auto& [instance, of_instance] : names) {
    std::set<Index> nodes;
    if (const auto of = linked.find(instance); of != linked.end()) nodes = of->second;
    for (const SideName* side : of_instance) {
      const IndexTable& faces = sides.faces(*side, {});
      nodes.insert(faces.data(), faces.data() + faces.size());
    }
    ContactNodes contact;
    contact.body = instance;
    contact.nodes.assign(nodes.begin(), nodes.end());
    contact.set = sim.bodies[instance]->track(contact.nodes);
    contact_of_instance[instance] = static_cast<Index>(sim.contact_nodes.size());
    sim.contact_nodes.push_back(std::move(contact));
  }
  return contact_of_instance;
}

void fill_areas(const SidesOfInstances& names, const ContactNumbers& contact_of_instance,
                ContactSides& sides, Simulation& sim) {
  for (const auto& [instance, of_instance] : names) {
    IndexTable table;
    for (const SideName* side : of_instance) join_faces(sides.faces(*side, {}), table);
    ContactNodes& contact = sim.contact_nodes[contact_of_instance.at(instance)];
    const Points X = sim.bodies[instance]->reference_positions();
    contact.area_vectors.setZero(static_cast<Index>(contact.nodes.size()), 3);
    contact.areas.setZero(contact.area_vectors.rows());
    for (Index f = 0; f < table.rows(); ++f) {
      const int n = table(f, 2) == table(f, 3) ? 3 : 4;
      const Vector3 d1 = X.row(table(f, 2)) - X.row(table(f, 0)),
                    d2 = X.row(table(f, 3)) - X.row(table(f, 1));
      const Vector3 share = d1.cross(d2) / (2 * n);
      for (int a = 0; a < n; ++a) {
        const Index slot =
            std::lower_bound(contact.nodes.begin(), contact.nodes.end(), table(f, a)) -
            contact.nodes.begin();
        contact.area_vectors.row(slot) += share.transpose();
        contact.areas[slot] += share.norm();
      }
    }
    contact.pressure.setZero(contact.areas.size());
    std::vector<const Surface*> surfaces;
    for (const SideName* side : of_instance)
      for (const Surface* surface : sides.surfaces(*side)) surfaces.push_back(surface);
    const std::vector<Surface> second = of_second_order(distinct_surfaces(surfaces));
    if (second.empty()) continue;
    const PressureFunctions of = corner_functions(second, X);
    contact.corner_values = on_nodes(of.Psi, of.nodes, contact.nodes);
    contact.corner_normals = sides.is_mirrored(*of_instance.front()) ? -of.normals : of.normals;
    for (const Index node : of.nodes) {
      const Index slot = std::lower_bound(contact.nodes.begin(), contact.nodes.end(), node) -
                         contact.nodes.begin();
      contact.areas[slot] = 0;
      contact.area_vectors.row(slot).setZero();
    }
  }
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_setup.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"
#include "dynamics/setup/components/contact_faces.hpp"
#include "dynamics/setup/contact/friction_shapes.hpp"
#include "dynamics/setup/contact/links.hpp"

namespace cbr {
namespace {

// A surface of an instance that takes part, by the instance's index and the surface's name; "all"
// with `whole`: all of them joined.
struct SideName {
  Index instance = 0;
  std::string surface;
  bool whole = false;
  bool operator==(const SideName& other) const = default;
  bool operator<(const SideName& other) const {
    return std::tie(instance, whole, surface) <
           std::tie(other.instance, other.whole, other.surface);
  }
};

// One pair to be: `all` makes many of one entry of the scene.
struct Entry {
  const ContactOptions* options = nullptr;
  SideName first, second;
  const WallOptions* wall = nullptr;  // then there is no second
};

// What explicit entries name: two instances, or an instance and a wall.
struct Named {
  std::set<std::pair<Index, Index>> instances;
  std::set<std::pair<Index, const WallOptions*>> walls;
};

Named named_by(const std::vector<Entry>& entries) {
  Named named;
  for (const Entry& entry : entries) {
    if (entry.wall) named.walls.emplace(entry.first.instance, entry.wall);
    if (!entry.wall)
      named.instances.insert(std::minmax(entry.first.instance, entry.second.instance));
  }
  return named;
}

std::vector<Entry> explicit_entries(const SceneIndex& index) {
  std::vector<Entry> entries;
  std::unordered_map<std::string, const WallOptions*> walls;
  for (const WallOptions& wall : index.scene().walls) walls[wall.name] = &wall;
  for (const ContactOptions& options : index.scene().contact) {
    if (options.all) continue;
    Entry entry;
    entry.options = &options;
    entry.first = {index.place(options.first.instance), options.first.surface, false};
    if (options.second.is_wall()) {
      entry.wall = walls.at(options.second.surface);
    } else {
      entry.second = {index.place(options.second.instance), options.second.surface, false};
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

// Every two instances, and every instance with every wall, that no explicit entry names.
void add_all(const Scene& scene, const BuiltScene& built, const ContactOptions& options,
             const Named& named, Report& report, std::vector<Entry>& entries) {
  std::vector<SideName> sides;
  for (Index i = 0; i < static_cast<Index>(built.instances.size()); ++i) {
    if (has_faces(*built.instances[i].geometry)) {
      sides.push_back({i, "all", true});
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
      if (!named.instances.count({sides[a].instance, sides[b].instance}))
        entries.push_back({&options, sides[a], sides[b], nullptr});
    }
    for (const WallOptions& wall : scene.walls) {
      if (options.tied) continue;
      any = true;
      if (!named.walls.count({sides[a].instance, &wall}))
        entries.push_back({&options, sides[a], {}, &wall});
    }
  }
  if (any) return;
  throw InputError(
      options.source.text() + ": contact: all finds no pair: " + std::to_string(sides.size()) +
      " instances with surfaces and " + std::to_string(options.tied ? 0 : scene.walls.size()) +
      " rigid walls, expected two instances" + (options.tied ? "" : ", or one and a wall"));
}

std::vector<Entry> entries_of(const SceneIndex& index, const BuiltScene& built, Report& report) {
  const Scene& scene = index.scene();
  std::vector<Entry> entries = explicit_entries(index);
  const Named named = named_by(entries);
  for (const ContactOptions& options : scene.contact)
    if (options.all) add_all(scene, built, options, named, report, entries);
  return entries;
}

// By instance: its place in Simulation::contact_nodes.
using ContactNumbers = std::map<Index, Index>;

// Sides by name, made once however many pairs they are in.
class Sides {
 public:
  explicit Sides(const BuiltScene& built) : built_(built) {}

  // Faces in the instance's nodes, outward in the scene.
  const IndexTable& faces(const SideName& name, const SourceLine& source) {
    const auto [at, is_new] = faces_.try_emplace(name);
    if (!is_new) return at->second;
    const auto& of = built_.instances[name.instance];
    at->second = name.whole
                     ? all_faces(*of.geometry)
                     : contact_faces(find_surface(*of.geometry, of.name, name.surface, source));
    if (of.placement.T.determinant() < 0) turn_over(at->second);
    return at->second;
  }

  // In the contact nodes of its body, which are known by now. `whole`: faces of second order are
  // not cut into linear ones.
  std::shared_ptr<const ContactSurface> surface(const SideName& name, bool whole,
                                                const ContactNumbers& contact_of_instance) {
    const auto [at, is_new] = surfaces_.try_emplace({name, whole});
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
    const IndexTable faces = (whole ? whole_faces_of(name) : faces_.at(name)).unaryExpr(local);
    surface.nodes = nodes_of(faces);
    if (surface.nodes.front() < 0) surface.nodes.erase(surface.nodes.begin());
    surface.faces = faces.leftCols(4);
    if (whole && faces.rightCols(4).maxCoeff() >= 0) surface.middle = faces.rightCols(4);
    Body& body = *built_.simulation.bodies[contact.body];
    fill_sizes(surface, body.reference_positions()(contact.nodes, Eigen::all));
    if (body.turning() != nullptr) surface.extent.setConstant(surface.extent.norm());
    return at->second = std::make_shared<const ContactSurface>(std::move(surface));
  }

 private:
  IndexTable whole_faces_of(const SideName& name) const {
    const auto& of = built_.instances[name.instance];
    IndexTable faces = name.whole
                           ? all_whole_faces(*of.geometry)
                           : whole_faces(find_surface(*of.geometry, of.name, name.surface, {}));
    if (of.placement.T.determinant() < 0) turn_over(faces);
    return faces;
  }

  const BuiltScene& built_;
  std::map<SideName, IndexTable> faces_;
  std::map<std::pair<SideName, bool>, std::shared_ptr<const ContactSurface>> surfaces_;
};

// Two parts of one body may meet (the prongs of a fork), but not where they hang together.
void refuse_shared_nodes(const Entry& entry, Sides& sides) {
  if (entry.wall || entry.first.instance != entry.second.instance) return;
  const ContactOptions& options = *entry.options;
  const auto first = nodes_of(sides.faces(entry.first, options.first.source));
  const auto second = nodes_of(sides.faces(entry.second, options.second.source));
  std::vector<Index> shared;
  std::set_intersection(first.begin(), first.end(), second.begin(), second.end(),
                        std::back_inserter(shared));
  if (shared.empty()) return;
  throw InputError(options.source.text() + ": contact between " + options.first.text() + " and " +
                   options.second.text() + ": the surfaces share " + std::to_string(shared.size()) +
                   " nodes of one instance, and a surface cannot be in contact with itself: name "
                   "surfaces without common nodes");
}

// Which instances take part, with which sides: few each, however many pairs they are in.
using SidesOfInstances = std::map<Index, std::vector<SideName>>;

SidesOfInstances sides_of_instances(const std::vector<Entry>& entries) {
  SidesOfInstances names;
  const auto add = [&](const SideName& name) {
    std::vector<SideName>& list = names[name.instance];
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  };
  for (const Entry& entry : entries) {
    add(entry.first);
    if (!entry.wall) add(entry.second);
  }
  return names;
}

// The nodes with which instances take part.
ContactNumbers add_contact_nodes(SidesOfInstances names,
                                 const std::map<Index, std::set<Index>>& linked, Sides& sides,
                                 Simulation& sim) {
  ContactNumbers contact_of_instance;
  for (const auto& [instance, nodes] : linked) names.try_emplace(instance);
  for (const auto& [instance, of_instance] : names) {
    std::set<Index> nodes;
    if (const auto of = linked.find(instance); of != linked.end()) nodes = of->second;
    for (const SideName& name : of_instance) {
      const IndexTable& faces = sides.faces(name, {});
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

// What nodal pressures are measured by.
void fill_areas(const SidesOfInstances& names, const ContactNumbers& contact_of_instance,
                Sides& sides, Simulation& sim) {
  for (const auto& [instance, of_instance] : names) {
    IndexTable table;
    for (const SideName& name : of_instance) join_faces(sides.faces(name, {}), table);
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
  }
}

PointLaw law_of(const ContactOptions& options) {
  if (options.tied) return {ContactLaw::tied, 0};
  if (options.friction > 0) return {ContactLaw::coulomb, options.friction};
  return {};
}

// What pairs of one entry or one wall share.
class SharedByPairs {
 public:
  SharedByPairs(Simulation& simulation, double end) : sim_(simulation), end_(end) {}
  std::shared_ptr<const SourceLine> source(const ContactOptions& options) {
    auto& source = sources_[&options];
    if (!source) source = std::make_shared<const SourceLine>(options.source);
    return source;
  }
  std::shared_ptr<const RigidWall> wall(const WallOptions& options) {
    auto& wall = walls_[&options];
    if (wall) return wall;
    wall = std::make_shared<RigidWall>(options);
    if (options.motion != SupportMotion::none)
      sim_.moving_walls.push_back({wall, motion_of(options)});
    return wall;
  }

 private:
  DrivenMotion motion_of(const WallOptions& options) const {
    DrivenMotion motion;
    for (int axis = 0; axis < 3; ++axis)
      if (options.value[axis] != 0)
        motion.axes[static_cast<std::size_t>(axis)].emplace_back(
            options.motion, options.value[axis], options.history, 0, end_);
    return motion;
  }

  Simulation& sim_;
  double end_;
  std::unordered_map<const ContactOptions*, std::shared_ptr<const SourceLine>> sources_;
  std::unordered_map<const WallOptions*, std::shared_ptr<RigidWall>> walls_;
};

// Whose nodes are looked at: those of the finer surface; of equal ones the first. Mortar pushes
// along the master's normals: of a coarse ball's faces they would send it sideways off a plate, so
// that the flatter surface is the master where one clearly is.
bool first_is_slave(const ContactSurface& first, const ContactSurface& second, bool by_bend) {
  constexpr double flat = 1e-3;  // 5 degrees from face to face
  const double a = bend(first), b = bend(second);
  if (by_bend && std::max(a, b) > flat && std::max(a, b) > 2 * std::min(a, b)) return a > b;
  return !(second.size < first.size * (1 - 1e-6));
}

ContactPair pair_of(const Entry& entry, const ContactNumbers& contact_of_instance,
                    SharedByPairs& shared, Sides& sides) {
  const ContactOptions& options = *entry.options;
  ContactPair pair;
  pair.source = shared.source(options), pair.of_all = options.all;
  pair.enforcement = options.enforcement;
  pair.formulation = entry.wall ? Formulation::node_face : options.formulation;
  pair.law = law_of(options);
  pair.damping = options.damping;
  pair.adjust = options.adjust;
  pair.resolves_overlap = options.resolves_overlap;
  if (options.pretension_force || options.shortening)
    pair.pretension = Pretension{options.pretension_force, options.shortening};
  const bool whole = pair.formulation == Formulation::mortar && pair.law.law != ContactLaw::tied;
  const auto first = sides.surface(entry.first, whole, contact_of_instance);
  if (entry.wall) {
    ContactSurface of_wall;
    of_wall.name = entry.wall->name, of_wall.body = first->body, of_wall.size = first->size;
    pair.name = first->name + " - " + entry.wall->name;
    pair.wall = shared.wall(*entry.wall);
    pair.slave = first, pair.master = std::make_shared<const ContactSurface>(std::move(of_wall));
    return pair;
  }
  const auto second = sides.surface(entry.second, whole, contact_of_instance);
  pair.name = first->name + " - " + second->name;
  pair.slave_is_first = first_is_slave(*first, *second, whole);
  pair.slave = pair.slave_is_first ? first : second;
  pair.master = pair.slave_is_first ? second : first;
  return pair;
}

// Whether the body starts deeper in the wall than a face of its surface: on the wrong side, which
// no contact can mend.
bool starts_in_wall(const ContactPair& pair, const Simulation& sim, double& depth) {
  const ContactNodes& contact = sim.contact_nodes[pair.slave->body];
  const Points& x = sim.bodies[contact.body]->reference_positions();
  depth = 0;
  for (const Index node : pair.slave->nodes)
    depth = std::max(depth, -pair.wall->distance(x.row(contact.nodes[node]).transpose()));
  return depth > pair.slave->sizes.maxCoeff();
}

void refuse_in_wall(const ContactPair& pair, double depth) {
  std::ostringstream message;
  message << pair.source->text() << ": contact " << pair.name << ": the surface starts " << depth
          << " deep in the wall, more than a face (" << pair.slave->sizes.maxCoeff()
          << "): is the wall's normal, or inside, the wrong way round?";
  throw InputError(message.str());
}

void warn_nodal(const ContactOptions& options, const BuiltScene& built, const ContactPair& pair,
                Report& report) {
  std::ostringstream text;
  text.precision(4);
  text << options.source.text() << ": contact " << pair.name
       << ": enforcement: nodal weighs each contact node by the row sum of its body's mass, which "
          "is not what the node weighs "
          "against an impulse; the contact surfaces stand for";
  for (const ContactSurface* surface : {pair.slave.get(), pair.master.get()}) {
    if (surface->nodes.empty()) continue;  // a wall
    const ContactNodes& contact = built.simulation.contact_nodes[surface->body];
    Body& body = *built.simulation.bodies[contact.body];
    const Points masses = nodal_of(body).nodal_masses(contact.set);
    double sum = 0;  // mean over the three directions
    for (const Index node : surface->nodes) sum += masses.row(node).mean();
    const double total = built.instances[contact.body].mass;
    text << (surface == pair.slave.get() ? " " : " and ") << sum / total << " of the mass of '"
         << body.name() << "'";
  }
  text << " (1: a perfectly plastic impact of whole bodies): use enforcement: impulse for a right "
          "answer";
  report.warning(text.str());
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

std::vector<ContactKind> add_contact(const SceneIndex& index, BuiltScene& built, Report& report) {
  Simulation& sim = built.simulation;
  std::vector<ContactKind> in_contact(sim.bodies.size(), ContactKind::none);
  const std::vector<Entry> entries = entries_of(index, built, report);
  Sides sides(built);
  for (const Entry& entry : entries) {
    const ContactOptions& options = *entry.options;
    sides.faces(entry.first, options.first.source);
    if (!entry.wall) sides.faces(entry.second, options.second.source);
    refuse_shared_nodes(entry, sides);
    if (entry.wall) built.momentum_is_kept = false;
    const ContactKind its =
        options.enforcement == Enforcement::penalty ? ContactKind::penalty : ContactKind::hard;
    for (const Index i :
         {entry.first.instance, entry.wall ? entry.first.instance : entry.second.instance})
      in_contact[i] = std::max(in_contact[i], its);
  }
  const SidesOfInstances names = sides_of_instances(entries);
  const ContactNumbers contact_of_instance =
      add_contact_nodes(names, linked_nodes(index, built), sides, sim);
  const auto& fields = index.scene().output.fields;
  if (std::find(fields.begin(), fields.end(), "contact_pressure") != fields.end())
    fill_areas(names, contact_of_instance, sides, sim);
  sim.pairs.reserve(entries.size());
  SharedByPairs shared(sim, index.scene().time->end);
  const ContactOptions* warned = nullptr;  // once for all pairs of an entry
  for (const Entry& entry : entries) {
    ContactPair pair = pair_of(entry, contact_of_instance, shared, sides);
    double depth = 0;
    if (pair.wall && starts_in_wall(pair, sim, depth)) {
      if (!pair.of_all) refuse_in_wall(pair, depth);
      built.notes.push_back("contact " + pair.name +
                            ": left out of all, as the surface starts deep in the wall");
      continue;
    }
    sim.pairs.push_back(std::move(pair));
    if (entry.options == warned) continue;
    warned = entry.options;
    look_for_friction_shapes(sim.pairs.back(), built, index.scene(), report);
    if (warned->enforcement == Enforcement::nodal)
      warn_nodal(*entry.options, built, sim.pairs.back(), report);
  }
  sim.n_instances = sim.bodies.size();
  add_links(index, contact_of_instance, built);
  const auto is_hard = [&](Index i) { in_contact[i] = std::max(in_contact[i], ContactKind::hard); };
  for (const LinkOptions& link : index.scene().links)
    for (const SurfaceName* end : {&link.first, &link.second})
      if (!end->is_wall()) is_hard(index.place(end->instance));
  for_each_point(index, [&](Index i, const std::string&, const Component::Point& point) {
    if (point.has_mass() || point.rigid) is_hard(i);
  });
  in_contact.resize(sim.bodies.size(), ContactKind::none);
  return in_contact;
}

}  // namespace cbr

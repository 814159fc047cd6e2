// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_setup.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "dynamics/contact/enforce/tie.hpp"
#include "dynamics/setup/contact/contact_sides.hpp"
#include "dynamics/setup/contact/points.hpp"

namespace cbr {
namespace {

PointLaw law_of(const ContactOptions& options) {
  if (options.tied) return {ContactLaw::tied, 0};
  if (options.friction.at_rest > 0) return {ContactLaw::coulomb, options.friction.at_rest};
  return {};
}

// Data shared by the pairs of one entry or one wall.
class SharedByPairs {
 public:
  SharedByPairs(Simulation& simulation, const TimeOptions& time) : sim_(simulation), time_(time) {}
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
        motion.axes[axis].emplace_back(options.motion, options.value[axis], options.history, 0,
                                       time_);
    return motion;
  }

  Simulation& sim_;
  const TimeOptions& time_;
  std::unordered_map<const ContactOptions*, std::shared_ptr<const SourceLine>> sources_;
  std::unordered_map<const WallOptions*, std::shared_ptr<RigidWall>> walls_;
};

// Selects the slave: the finer surface, or the first of equal ones. Mortar impulses act along the
// master's normals. Those of a coarse ball's faces would push it sideways off a plate. So for
// mortar the master is the flatter surface, if one clearly is.
bool first_is_slave(const ContactSurface& first, const ContactSurface& second, bool by_bend) {
  constexpr double flat = 1e-3;  // 5 degrees from face to face
  if (by_bend) {
    const double a = bend(first), b = bend(second);
    if (std::max(a, b) > flat && std::max(a, b) > 2 * std::min(a, b)) return a > b;
  }
  return !(second.size < first.size * (1 - 1e-6));
}

ContactList ties_of(const ContactSurface& slave, const ContactSurface& master,
                    const std::optional<double>& adjust, const Simulation& sim) {
  const auto positions = [&](const ContactSurface& surface) {
    const ContactNodes& nodes = sim.contact_nodes[surface.body];
    return Points(sim.bodies[nodes.body]->reference_positions()(nodes.nodes, Eigen::all));
  };
  ContactList ties;
  Points offsets;
  tie_surfaces(slave, positions(slave), master, positions(master), adjust, ties, offsets);
  return ties;
}

// Nodes by which two bodies are tied. Contact of all their surfaces leaves them out.
class TiedNodes {
 public:
  void add(const ContactPair& pair, const Simulation& sim) {
    const auto add_slave = [&](const ContactSurface& slave, const ContactSurface& master) {
      std::set<Index>& nodes = nodes_[{slave.body, master.body}];
      for (const ContactPoint& point : ties_of(slave, master, pair.adjust, sim).points)
        nodes.insert(slave.nodes[point.slot]);
    };
    add_slave(*pair.slave, *pair.master);
    add_slave(*pair.master, *pair.slave);
  }
  bool leaves_out(const ContactPair& pair) const {
    return pair.of_all && nodes_.count({pair.slave->body, pair.master->body}) != 0;
  }
  void leave_out(const ContactSides& sides, ContactPair& pair) const {
    if (!leaves_out(pair)) return;
    const std::pair<Index, Index> two{pair.slave->body, pair.master->body};
    const bool by_nodes = pair.formulation != Formulation::mortar;
    pair.slave = sides.untied(*pair.slave, nodes_.at(two), by_nodes);
    pair.master = sides.untied(*pair.master, nodes_.at({two.second, two.first}), by_nodes);
  }

 private:
  std::map<std::pair<Index, Index>, std::set<Index>> nodes_;  // of the first body, at the second
};

// Whether faces of second order lie on those of another mesh at the start: all nodes of a slave
// face, and some beside the master's nodes.
bool meets_unlike(const ContactEntry& entry, const ContactPair& pair, const Simulation& sim,
                  ContactSides& sides) {
  constexpr double at_node = 0.99;  // weight in the face
  if (pair.wall || pair.formulation != Formulation::node_face ||
      pair.enforcement != Enforcement::impulse ||
      (!sides.corners(*entry.first) && !sides.corners(*entry.second)))
    return false;
  const ContactSurface& slave = *pair.slave;
  const ContactList ties = ties_of(slave, *pair.master, pair.adjust, sim);
  std::set<Index> met;
  bool any_beside = false;
  for (const ContactPoint& point : ties.points) {
    met.insert(slave.nodes[point.slot]);
    double most = 0;
    for (Index t = point.first_term + 1; t < point.first_term + point.n_terms; ++t)
      most = std::max(most, -ties.terms[t].coefficient);
    any_beside |= most < at_node;
  }
  for (Index f = 0; any_beside && f < slave.faces.rows(); ++f)
    if (std::all_of(slave.faces.row(f).begin(), slave.faces.row(f).end(),
                    [&](Index node) { return met.count(node) != 0; }))
      return true;
  return false;
}

ContactPair pair_of(const ContactEntry& entry, Formulation formulation,
                    const ContactNumbers& contact_of_instance, SharedByPairs& shared,
                    ContactSides& sides) {
  const ContactOptions& options = *entry.options;
  ContactPair pair;
  pair.source = shared.source(options);
  pair.of_all = options.all;
  pair.enforcement = options.enforcement;
  pair.formulation = entry.wall ? Formulation::node_face : formulation;
  pair.law = law_of(options);
  pair.friction = FrictionLaw(options.friction);
  // Two-way contact has springs at the nodes of both sides
  pair.penalty = {options.damping, options.stiffness,
                  formulation == Formulation::two_way ? 0.5 : 1};
  pair.restitution = options.restitution;
  pair.resolves_overlap = options.resolves_overlap;
  pair.interference = options.interference;
  if (options.pretension_force || options.shortening)
    pair.pretension = Pretension{options.pretension_force, options.shortening};
  const bool whole = pair.formulation == Formulation::mortar;
  const auto first = sides.surface(*entry.first, whole, contact_of_instance);
  // An interference or a clearance closes gaps of the meshes, as ties do
  const auto set_adjust = [&](double face) {
    pair.adjust = options.adjust;
    if (!pair.adjust && options.interference != 0) pair.adjust = usual_adjust * face;
  };
  if (entry.wall) {
    ContactSurface of_wall;
    of_wall.name = entry.wall->name;
    of_wall.body = first->body;
    of_wall.size = first->size;
    pair.name = first->name + " - " + entry.wall->name;
    pair.wall = shared.wall(*entry.wall);
    pair.slave = first;
    set_adjust(first->size);
    pair.master = std::make_shared<const ContactSurface>(std::move(of_wall));
    return pair;
  }
  const auto second = sides.surface(*entry.second, whole, contact_of_instance);
  pair.name = first->name + " - " + second->name;
  pair.slave_is_first = first_is_slave(*first, *second, whole && pair.law.law != ContactLaw::tied);
  pair.slave = pair.slave_is_first ? first : second;
  pair.master = pair.slave_is_first ? second : first;
  set_adjust(pair.master->size);
  return pair;
}

// Nodes load unlike faces of second order unevenly. Mortar does not, but bodies that strike pass
// through its means with edges and corners: so it is for faces that meet already and stay.
void note_unlike(const ContactPair& pair, bool takes_mortar, Report& report) {
  const std::string unlike =
      "contact " + pair.name + ": faces of second order meet those of another mesh: ";
  if (takes_mortar) {
    report.line("note: " + unlike + "mortar is taken (formulation: node-face keeps nodes)");
  } else {
    report.warning(pair.source->text() + ": " + unlike +
                   "nodes load them unevenly, by 0 to 1.6 times the right pressure: take "
                   "formulation: mortar, but not where edges or corners strike");
  }
}

// Least nodes of a face with pressure functions, without and with friction, nodes per function, and
// bounds of their number: docs/decisions/pressures.md.
constexpr Index least_nodes = 500, least_nodes_with_friction = 150, nodes_of_function = 12,
                least_functions = 40, most_functions = 160;

Index functions_wanted(const ContactOptions& options, bool friction, Index n_nodes) {
  if (options.pressures) return *options.pressures;
  if (n_nodes < (friction ? least_nodes_with_friction : least_nodes)) return 0;
  return std::clamp(n_nodes / nodes_of_function, least_functions, most_functions);
}

// Lumped meshes keep their nodes, as W is nearly diagonal.
bool moves_in_shapes(const BuiltScene& built, const SideName& side) {
  const auto& of = built.instances[side.instance];
  return of.is_rigid || of.mesh == nullptr;
}

bool turns(const BuiltScene& built, const SideName& side) {
  return built.simulation.bodies[side.instance]->turns();
}

void add_functions(const ContactEntry& entry, const BuiltScene& built, ContactSides& sides,
                   ContactPair& pair) {
  if (pair.enforcement != Enforcement::impulse || pair.law.law == ContactLaw::tied ||
      pair.formulation == Formulation::mortar)
    return;
  const SideName& slave = *(pair.slave_is_first ? entry.first : entry.second);
  const bool in_shapes =
      moves_in_shapes(built, *entry.first) && (entry.wall || moves_in_shapes(built, *entry.second));
  pair.may_stand =
      in_shapes && !turns(built, *entry.first) && (entry.wall || !turns(built, *entry.second));
  const auto n_nodes = static_cast<Index>(pair.slave->nodes.size());
  if (entry.options->pressures.value_or(0) > n_nodes)
    throw InputError(entry.options->source.text() + ": contact[].pressures: found " +
                     std::to_string(*entry.options->pressures) + ", but " + pair.slave->name +
                     " has " + std::to_string(n_nodes) + " nodes: take fewer, 'nodes' or 'auto'");
  const bool friction = pair.law.law == ContactLaw::coulomb;
  // On a mesh W by nodes is dense too, and slow with friction
  const bool on_mesh = !in_shapes && moves_in_shapes(built, slave) &&
                       (friction || entry.options->pressures.has_value());
  const Index wanted =
      in_shapes || on_mesh ? functions_wanted(*entry.options, friction, n_nodes) : 0;
  if (wanted > 0) pair.functions = sides.functions(slave, wanted);
  pair.keeps_functions = entry.options->pressures.has_value();
  // `nodes`: including those beside corners
  if (entry.options->pressures.value_or(1) != 0) pair.corners = sides.corners(slave);
}

// Whether the body starts deeper in the wall than a face of its surface. It is then on the wrong
// side, beyond contact's correction.
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

// Nodes alone meet a wall.
void warn_of_bulge(const ContactPair& pair, Report& report) {
  constexpr double much = 0.05;
  const double size = pair.slave->size, bulge = pair.wall->bulge(size);
  if (!(bulge > much * size)) return;
  const std::string how = std::isfinite(bulge)
                              ? format_text("bulges through them by up to %.2g", bulge)
                              : "passes between them";
  report.warning(pair.source->text() + ": contact " + pair.name +
                 format_text(": nodes alone meet a wall, and with faces of %.3g it ", size) + how +
                 ": take smaller faces there, or mesh the wall as a body (as: rigid), whose faces "
                 "are met too");
}

void warn_nodal(const ContactOptions& options, const BuiltScene& built, const ContactPair& pair,
                Report& report) {
  std::ostringstream text;
  text.precision(4);
  text << options.source.text() << ": contact " << pair.name
       << ": enforcement: nodal weighs each contact node by the row sum of its body's mass, which "
          "is not what the node weighs against an impulse; the contact surfaces stand for";
  for (const ContactSurface* surface : {pair.slave.get(), pair.master.get()}) {
    if (surface->nodes.empty()) continue;  // a wall
    const ContactNodes& contact = built.simulation.contact_nodes[surface->body];
    Body& body = *built.simulation.bodies[contact.body];
    const Points masses = body.nodal_masses(contact.set);
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

std::vector<ContactKind> add_contact(const SceneIndex& index, BuiltScene& built, Report& report) {
  Simulation& sim = built.simulation;
  std::vector<ContactKind> in_contact(sim.bodies.size(), ContactKind::none);
  const ContactEntries entries = contact_entries(index, built, report);
  ContactSides sides(built);
  for (const ContactEntry& entry : entries.list) {
    const ContactOptions& options = *entry.options;
    sides.faces(*entry.first, options.first.source);
    if (!entry.wall) sides.faces(*entry.second, options.second.source);
    refuse_shared_nodes(entry, sides);
    if (entry.wall) built.momentum_is_kept = false;
    const ContactKind its =
        options.enforcement == Enforcement::penalty ? ContactKind::penalty : ContactKind::hard;
    for (const Index i :
         {entry.first->instance, entry.wall ? entry.first->instance : entry.second->instance})
      in_contact[i] = std::max(in_contact[i], its);
  }
  const SidesOfInstances names = sides_of_instances(entries.list);
  const ContactNumbers contact_of_instance =
      add_contact_nodes(names, linked_nodes(index, built), sides, sim);
  const auto& fields = index.scene().output.fields;
  if (std::any_of(fields.begin(), fields.end(),
                  [](const std::string& field) { return field.starts_with("contact_"); }))
    fill_areas(names, contact_of_instance, sides, sim);
  sim.pairs.reserve(entries.list.size());
  SharedByPairs shared(sim, *index.scene().time);
  TiedNodes tied;
  const ContactOptions *warned = nullptr, *unlike = nullptr;  // once for all pairs of an entry
  const bool is_static = index.scene().time->is_static || preload_steps(index.scene()) > 0;
  for (const ContactEntry& entry : entries.list) {
    const auto make = [&](Formulation formulation) {
      ContactPair made = pair_of(entry, formulation, contact_of_instance, shared, sides);
      tied.leave_out(sides, made);
      return made;
    };
    const bool is_chosen = entry.options->formulation != Formulation::automatic;
    ContactPair pair = make(is_chosen ? entry.options->formulation : Formulation::node_face);
    if (meets_unlike(entry, pair, sim, sides)) {
      const bool stays = is_static || pair.law.law == ContactLaw::tied;
      const bool takes_mortar = stays && !is_chosen && !entry.options->pressures;
      if (takes_mortar) pair = make(Formulation::mortar);
      if (std::exchange(unlike, entry.options) != entry.options)
        note_unlike(pair, takes_mortar, report);
    }
    if (!pair.wall && (pair.slave->faces.rows() == 0 || pair.master->faces.rows() == 0)) continue;
    if (pair.law.law == ContactLaw::tied && !pair.of_all) tied.add(pair, sim);
    if (!tied.leaves_out(pair)) add_functions(entry, built, sides, pair);
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
    if (sim.pairs.back().wall) warn_of_bulge(sim.pairs.back(), report);
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

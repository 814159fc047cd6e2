// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_setup.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "common/base/error.hpp"
#include "dynamics/motion/joint_body.hpp"
#include "dynamics/setup/components/geometry.hpp"
#include "dynamics/setup/contact/points.hpp"

namespace cbr {
namespace {

// A node of a point or a joint, by its contact body and index there.
struct Slot {
  Index contact = 0, node = -1;  // -1: none
};

// A pair without faces: a point of three rows, row d along axis d of the frame if `is_on`. No pair
// without rows.
struct PairOptions {
  std::string name;
  SourceLine source;
  SurfaceName first, second;
  Matrix3 axes = Matrix3::Identity();
  std::array<bool, 3> is_on{};
  std::optional<TurningLink> turning = {};
  std::shared_ptr<DrivenLink> driven = {};
};

std::shared_ptr<const ContactSurface> no_faces(const std::string& name, Index contact) {
  auto of = std::make_shared<ContactSurface>();
  of->name = name;
  of->body = contact;
  of->sizes = Vector::Zero(1);
  return of;
}

ContactPair pair_of(const PairOptions& options, Index contact_a, Index contact_b) {
  ContactPair pair;
  pair.source = std::make_shared<const SourceLine>(options.source);
  pair.name = options.name;
  pair.law = {ContactLaw::tied, 0};
  pair.is_link = true;
  pair.slave = no_faces(options.first.text(), contact_a);
  pair.master = no_faces(options.second.text(), contact_b);
  return pair;
}

void add_pair(const PairOptions& options, const Slot& a, const Slot& b, const Slot& joint,
              Simulation& sim) {
  ContactPoint point;
  point.frame = options.axes;
  bool any = false;
  for (std::size_t d = 0; d < 3; ++d) {
    any |= options.is_on[d];
    // A row of zeros constrains nothing
    if (!options.is_on[d]) point.frame.row(static_cast<Index>(d)).setZero();
  }
  if (!any) return;
  ContactPair pair = pair_of(options, a.contact, b.contact);
  PairState& state = pair.state();
  state.tie_offset = Points::Zero(1, 3);
  const auto add = [&](const Slot& slot, double coefficient) {
    if (slot.node < 0) return;
    state.ties.terms.push_back({slot.contact, slot.node, coefficient});
    const ContactNodes& nodes = sim.contact_nodes[slot.contact];
    state.tie_offset +=
        coefficient * sim.bodies[nodes.body]->reference_positions().row(nodes.nodes[slot.node]);
  };
  add(a, 1);
  add(b, -1);
  add(joint, -1);
  if (joint.node >= 0) pair.joint = joint.contact;
  pair.yields = joint.node >= 0;
  pair.driven = options.driven;
  if (options.driven) sim.driven_links.push_back(options.driven);
  if (options.turning) {
    pair.turning = std::make_unique<TurningLink>(*options.turning);
    pair.turning->is_on = options.is_on;
  }
  point.n_terms = static_cast<Index>(state.ties.terms.size());
  state.ties.points.push_back(point);
  sim.pairs.push_back(std::move(pair));
}

// Adds a joint body; returns its contact body.
Index add_joint(Joint joint, const Scene& scene, Simulation& sim) {
  const Scheme scheme =
      scene.time->integrator == Integrator::newmark ? Scheme::newmark : Scheme::exact;
  sim.bodies.push_back(std::make_unique<JointBody>(std::move(joint), scheme));
  ContactNodes contact;
  contact.body = static_cast<Index>(sim.bodies.size()) - 1;
  contact.nodes = {0, 1};
  contact.set = sim.bodies.back()->track(contact.nodes);
  sim.contact_nodes.push_back(std::move(contact));
  return static_cast<Index>(sim.contact_nodes.size()) - 1;
}

// A point of an instance by its contact nodes: translation and rotation.
struct PointSlots {
  Slot translation, rotation;
};

class LinkMaker {
 public:
  LinkMaker(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance,
            BuiltScene& built)
      : index_(index),
        contact_of_instance_(contact_of_instance),
        built_(built),
        sim_(built.simulation) {}

  void add(const LinkOptions& link) {
    const PointSlots a =
        slots(link.first.instance, point_place(index_, link.first.instance, link.first.surface));
    PointSlots b{{a.translation.contact, -1}, {a.rotation.contact, -1}};
    if (link.second.is_wall()) {
      built_.momentum_is_kept = false;
    } else {
      b = slots(link.second.instance, second_place(index_, link));
    }
    const Matrix3 axes = link.follows_line ? along(line(link, a, b), link) : link.axes;
    const std::string name = link.first.text() + " - " + link.second.text();
    std::array<bool, 6> sprung{};
    bool is_sprung = false;
    for (std::size_t m = 0; m < 6; ++m) is_sprung |= sprung[m] = link.is_sprung(m);
    add_two(link, axes, name, name + ", moment", link.fix, a, b, {});
    if (!is_sprung) return;
    Joint joint;
    joint.name = name;
    joint.at = place_of(a.translation);
    joint.axes = axes;
    joint.stiffness = link.stiffness;
    joint.damping = link.damping;
    joint.force = link.force;
    for (std::size_t m = 0; m < 6; ++m) joint.friction[static_cast<Index>(m)] = link.friction[m];
    joint.size = size_of(a.translation);
    for (const Slot& end : {a.translation, b.translation})
      joint.is_late |= sim_.bodies[sim_.contact_nodes[end.contact].body]->facts().kicks_at_end;
    const Index contact = add_joint(std::move(joint), index_.scene(), sim_);
    if (turns(index_, link))
      static_cast<JointBody&>(*sim_.bodies.back()).follow(0, axes.transpose());
    add_two(link, axes, name + ", spring", name + ", spring moment", sprung, a, b,
            {{contact, 0}, {contact, 1}});
  }

  // Adds the mass of a point as a joint that moves with it.
  void add_mass(Index i, const std::string& name, const Component::Point& point) {
    const Instance& instance = index_.scene().instances[i];
    const Index place = point_place(index_, instance.name, name);
    const PointSlots a = slots(instance.name, place);
    const BodyPoints& points = *sim_.bodies[i]->points();
    Joint joint;
    joint.name = instance.name + "." + name;
    joint.at = points.positions().row(points.translation_node(place)).transpose();
    joint.axes = instance.transformation().transpose();
    joint.mass.diagonal().head<3>().setConstant(point.mass);
    joint.mass.bottomRightCorner<3, 3>() = point.inertia;
    Vector3 d, theta, velocity, spin;
    points.point_motion(*sim_.bodies[i], place, d, theta, velocity, spin);
    joint.rates << joint.axes * velocity, joint.axes * spin;
    std::array<bool, 6> is_on{};
    for (Index m = 0; m < 6; ++m) is_on[m] = joint.mass(m, m) > 0;
    for (Index m = 0; m < 6; ++m)
      if (!(joint.mass(m, m) > 0)) joint.rates[m] = 0;
    LinkOptions link;
    link.source = point.source;
    link.first = {instance.name, name, point.source};
    link.second = {"", "mass", point.source};
    link.axes = joint.axes;
    const Index contact = add_joint(std::move(joint), index_.scene(), sim_);
    PairOptions options{
        link.first.text() + " - mass", link.source, link.first, link.second, link.axes,
        {is_on[0], is_on[1], is_on[2]}};
    add_pair(options, a.translation, {contact, 0}, {}, sim_);
    options.name += ", moment";
    options.is_on = {is_on[3], is_on[4], is_on[5]};
    add_pair(options, a.rotation, {contact, 1}, {}, sim_);
  }

  // Constrains all motions of the set's nodes except rigid ones.
  void add_rigid(Index i, const std::string& name, const Component::Point& point) {
    const std::string& instance = index_.scene().instances[i].name;
    // it is rigid by itself
    if (node_of_point(*built_.instances[i].geometry, name, point.nodes) >= 0) return;
    refuse_what_is_held(i, name, point);
    const BodyPoints& points = *sim_.bodies[i]->points();
    const Index contact = contact_of_instance_.at(i);
    PairOptions options;
    options.name = instance + "." + name + ", rigid";
    options.source = point.source;
    options.first = options.second = {instance, name, point.source};
    ContactPair pair = pair_of(options, contact, contact);
    PairState& state = pair.state();
    const std::vector<Index> nodes = points.deformation_nodes(point_place(index_, instance, name));
    state.tie_offset.resize(static_cast<Index>(nodes.size()), 3);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      ContactPoint held;
      held.slot = held.first_term = static_cast<Index>(k);
      held.n_terms = 1;
      state.ties.terms.push_back({contact, slot(contact, nodes[k]).node, 1});
      state.ties.points.push_back(held);
      state.tie_offset.row(static_cast<Index>(k)) = points.positions().row(nodes[k]);
    }
    if (!nodes.empty()) sim_.pairs.push_back(std::move(pair));
  }

 private:
  std::set<Index> nodes_of(Index i, const std::string& set, const SourceLine& source) const {
    const std::vector<Index> nodes =
        find_nodes(*built_.instances[i].geometry, index_.scene().instances[i].name, set, source);
    return {nodes.begin(), nodes.end()};
  }

  // Rejects doubly constrained nodes, whose forces would be undetermined.
  void refuse_what_is_held(Index i, const std::string& name, const Component::Point& point) const {
    const Instance& instance = index_.scene().instances[i];
    const std::set<Index> rigid = nodes_of(i, point.nodes, point.source);
    const auto refuse = [&](const std::set<Index>& held, const std::string& by) {
      if (std::none_of(held.begin(), held.end(), [&](Index node) { return rigid.count(node) > 0; }))
        return;
      throw InputError(point.source.text() + ": coupling: rigid of '" + instance.name + "." + name +
                       "' shares nodes with " + by +
                       ", which is over-determined: take sets without common nodes, coupling: "
                       "average, or a link to the ground");
    };
    std::set<Index> fixed;
    for (const auto& [node, axis] : built_.instances[i].geometry->fixed) fixed.insert(node);
    refuse(fixed, "'reduction.fixed'");
    for (const BoundaryCondition* condition : index_.plan(instance).boundary)
      refuse(nodes_of(i, condition->nodes, condition->source),
             "'" + condition->nodes + "' under 'boundary'");
    for (const auto& [other, of] : component_of(index_.scene(), instance).points)
      if (of.rigid && other < name &&
          node_of_point(*built_.instances[i].geometry, other, of.nodes) < 0)
        refuse(nodes_of(i, of.nodes, of.source), "the rigid point '" + other + "'");
  }

  Slot slot(Index contact, Index node) const {
    const auto& nodes = sim_.contact_nodes[contact].nodes;
    return {contact,
            static_cast<Index>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin())};
  }

  PointSlots slots(const std::string& instance, Index place) const {
    const Index i = index_.place(instance), contact = contact_of_instance_.at(i);
    const BodyPoints& points = *sim_.bodies[i]->points();
    return {slot(contact, points.translation_node(place)),
            slot(contact, points.rotation_node(place))};
  }

  // Undeformed
  Vector3 place_of(const Slot& slot) const {
    const ContactNodes& nodes = sim_.contact_nodes[slot.contact];
    return sim_.bodies[nodes.body]->reference_positions().row(nodes.nodes[slot.node]).transpose();
  }

  // From the second end to the first.
  Vector3 line(const LinkOptions& link, const PointSlots& a, const PointSlots& b) const {
    return place_of(a.translation) - (link.ground ? *link.ground : place_of(b.translation));
  }

  // Axes of which x is along the line.
  static Matrix3 along(const Vector3& line, const LinkOptions& link) {
    if (!(line.norm() > 0))
      throw InputError(link.source.text() +
                       ": links[]: the ends are at one place, and no line is between them: leave "
                       "out axes: line, or move one");
    return axes_along(line);
  }

  // Rotation of a link's rows with its ends.
  TurningLink turning_link(const LinkOptions& link, const PointSlots& a,
                           const PointSlots& b) const {
    TurningLink of;
    of.first = {a.translation.contact, a.translation.node, a.rotation.node};
    if (!link.second.is_wall())
      of.second = {b.translation.contact, b.translation.node, b.rotation.node};
    of.is_fixed = {link.fix[3], link.fix[4], link.fix[5]};
    of.axes = link.axes;
    of.at = link.ground.value_or(place_of(a.translation));
    if (link.follows_line) of.length = line(link, a, b).norm();
    of.size = size_of(a.translation);
    return of;
  }

  // Of the body; 1: of a single point.
  double size_of(const Slot& slot) const {
    const Points& X = sim_.bodies[sim_.contact_nodes[slot.contact].body]->reference_positions();
    const double size = (X.colwise().maxCoeff() - X.colwise().minCoeff()).norm();
    return size > 0 ? size : 1;
  }

  // The prescribed motion along or about the axes; null: none.
  std::shared_ptr<DrivenLink> driven(const LinkOptions& link, const Vector3& value) const {
    if (link.motion == SupportMotion::none || value.isZero(0)) return nullptr;
    auto of = std::make_shared<DrivenLink>();
    for (Index axis = 0; axis < 3; ++axis)
      if (value[axis] != 0)
        of->motion.axes[axis].emplace_back(link.motion, value[axis], link.history, 0,
                                           *index_.scene().time);
    return of;
  }

  // Adds forces along `axes`, and moments about them.
  void add_two(const LinkOptions& link, const Matrix3& axes, const std::string& force,
               const std::string& moment, const std::array<bool, 6>& is_on, const PointSlots& a,
               const PointSlots& b, const PointSlots& joint) {
    PairOptions options{force,       link.source, link.first,
                        link.second, axes,        {is_on[0], is_on[1], is_on[2]}};
    Slot first = a.translation;
    if (turns(index_, link)) {
      if ((link.turn.array() != 0).count() > 1)
        throw InputError(link.source.text() +
                         ": links[]: its ends have large rotation, and the prescribed one is about "
                         "several axes: give one axis, or time: {rotations: small}");
      options.turning = turning_link(link, a, b);
    }
    if (slides(index_, link)) {
      const Index i = sim_.contact_nodes[first.contact].body;
      options.turning->slides = sliding_place(index_, link);
      first =
          slot(first.contact, sim_.bodies[i]->points()->translation_node(options.turning->slides));
    }
    const bool is_spring = joint.translation.node >= 0;
    if (!is_spring) options.driven = driven(link, link.value);
    add_pair(options, first, b.translation, joint.translation, sim_);
    const bool is_angle = link.motion == SupportMotion::displacement;
    options.driven =
        is_spring ? nullptr : driven(link, (is_angle ? std::numbers::pi / 180 : 1) * link.turn);
    options.name = moment;
    options.is_on = {is_on[3], is_on[4], is_on[5]};
    if (options.turning) {
      options.turning->of_rotations = true;
      options.turning->slides = -1;
    }
    add_pair(options, a.rotation, b.rotation, joint.rotation, sim_);
  }

  const SceneIndex& index_;
  const std::map<Index, Index>& contact_of_instance_;
  BuiltScene& built_;
  Simulation& sim_;
};

}  // namespace

void add_links(const SceneIndex& index, const std::map<Index, Index>& contact_of_instance,
               BuiltScene& built) {
  LinkMaker maker(index, contact_of_instance, built);
  for (const LinkOptions& link : index.scene().links) maker.add(link);
  for_each_point(index, [&](Index i, const std::string& name, const Component::Point& point) {
    if (point.rigid && index.scene().instances[i].as != InstanceKind::rigid)
      maker.add_rigid(i, name, point);
    if (point.has_mass()) maker.add_mass(i, name, point);
  });
}

}  // namespace cbr

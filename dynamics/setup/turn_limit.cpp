// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build_steps.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "common/base/format_text.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/setup/bodies/turning.hpp"
#include "dynamics/setup/built/instance_elements.hpp"

namespace cbr {
namespace {

// Relative loss of the restoring moment of the weight, at the limit. The loss is 1 at an angle of
// width over height.
constexpr double weight_share = 0.05;

// The vertical axis is the one nearest to gravity.
double limit_of_weight(const Box& box, const Vector3& gravity) {
  const Vector3 edges = box.upper - box.lower;
  Index up = 0;
  gravity.cwiseAbs().maxCoeff(&up);
  const double wide = std::min(edges[(up + 1) % 3], edges[(up + 2) % 3]);
  return edges[up] > 0 ? weight_share * wide / edges[up] : HUGE_VAL;
}

std::set<std::string> linked_instances(const Scene& scene) {
  std::set<std::string> linked;
  for (const LinkOptions& link : scene.links) {
    linked.insert(link.first.instance);
    linked.insert(link.second.instance);
  }
  return linked;
}

// Those whose path depends on more than their velocity and a constant weight.
std::set<std::string> carried_instances(const Scene& scene) {
  std::set<std::string> carried;
  for (const Load& load : scene.loads) carried.insert(load.instance);
  for (const BoundaryCondition& condition : scene.boundary)
    if (condition.motion != SupportMotion::none) carried.insert(condition.instance);
  return carried;
}

// Across a direction of motion.
using Patch = Eigen::AlignedBox2d;
using Across = Eigen::Matrix<double, 2, 3>;

// How far points are ahead along e, and where they touch first: all points that a rotation by less
// than `small_rotation` brings there too, as a body that lands nearly flat does not go on to turn.
struct Front {
  double reach = -HUGE_VAL;
  Patch patch;
};

Front front_of(const Points& x, const Vector3& e, const Across& across, const Patch& within) {
  Front front;
  Eigen::Vector2d first = within.center();
  const auto inside = [&](Index i) { return within.contains(across * x.row(i).transpose()); };
  for (Index i = 0; i < x.rows(); ++i)
    if (const double ahead = x.row(i).dot(e); ahead > front.reach && inside(i)) {
      front.reach = ahead;
      first = across * x.row(i).transpose();
    }
  for (Index i = 0; i < x.rows(); ++i) {
    const Eigen::Vector2d at = across * x.row(i).transpose();
    if (inside(i) && front.reach - x.row(i).dot(e) <= small_rotation * (at - first).norm())
      front.patch.extend(at);
  }
  if (std::isfinite(front.reach)) return front;
  return {(x * e).maxCoeff(), within};  // of faces without a node there
}

// The first meeting of two surfaces, or of one with a plane, on straight or falling paths.
struct Strike {
  double t = 0, speed = 0, acceleration = 0;  // of the approach along e
  Vector3 e;                                  // motion of the first one
  Across across;
  Patch patch;
};

class Strikes {
 public:
  Strikes(const SceneIndex& index, const BuiltScene& built) : built_(built) {
    const Load* gravity = gravity_of(index.scene());
    end_ = index.scene().time->end;
    const std::set<std::string> linked = linked_instances(index.scene()),
                                carried = carried_instances(index.scene());
    for (std::size_t i = 0; i < built.instances.size(); ++i) {
      const Instance& instance = index.scene().instances[i];
      const Body& body = *built.simulation.bodies[i];
      Flying of;
      of.is_free = !index.plan(instance).is_held() && !index.plan(instance).is_fixed &&
                   linked.count(instance.name) == 0;
      of.is_carried = carried.count(instance.name) > 0;
      if (of.is_free) of.mass = built.instances[i].mass;
      if (of.is_free) of.velocity = instance.velocity;
      if (of.is_free && gravity != nullptr) of.gravity = gravity->value;
      of.center = body.state().center_of_mass;
      of.box = extents(body, built.instances[i]);
      flying_.push_back(std::move(of));
    }
    if (gravity != nullptr && !gravity->history.time.empty()) return;
    for (const ContactPair& pair : built.simulation.pairs)
      if (pair.law.law != ContactLaw::tied) add(pair);
  }

  // Whether the instance's first strike turns it beyond the limit before anything else meets it.
  std::string turning(std::size_t i, double limit) const {
    const Flying& of = flying_[i];
    const auto first = std::min_element(of.hits.begin(), of.hits.end(),
                                        [](const Hit& a, const Hit& b) { return a.t < b.t; });
    if (!of.is_free || first == of.hits.end()) return {};
    const double root = std::sqrt(first->spin * first->spin + 2 * first->torque * limit),
                 until = first->t + 2 * limit / (first->spin + root);
    const auto is_next = [&](const Hit& hit) { return &hit != &*first && hit.t < until; };
    if (!(until < end_) || std::any_of(of.hits.begin(), of.hits.end(), is_next)) return {};
    return "instance '" + built_.instances[i].name + "' meets the other in contact " +
           first->pair->name + " at t = " + number_text(first->t) + " s, " +
           number_text(first->arm) +
           " beside its centre of mass: the run begins with bodies that turn (time: {rotations: "
           "small} keeps them linear)";
  }

 private:
  struct Hit {
    double t, arm, spin, torque;  // spin: just after it; torque: of the weight, per inertia
    const ContactPair* pair;
  };
  struct Flying {
    bool is_free = false, is_carried = false;
    double mass = HUGE_VAL;  // of what is held
    Vector3 velocity = Vector3::Zero(), gravity = Vector3::Zero(), center;
    Box box;
    std::vector<Hit> hits;
    // about an axis, as of a solid box
    double square_of_gyration(const Vector3& axis) const {
      const Vector3 edges = box.upper - box.lower;
      return (edges.array().square() * (1 - axis.array().square())).sum() / 12;
    }
  };

  // Points of a surface at the start.
  Points points_of(const ContactSurface& surface) const {
    const ContactNodes& contact = built_.simulation.contact_nodes[surface.body];
    const Points& x = built_.simulation.bodies[contact.body]->reference_positions();
    Points points(static_cast<Index>(surface.nodes.size()), 3);
    for (Index i = 0; i < points.rows(); ++i)
      points.row(i) = x.row(contact.nodes[surface.nodes[i]]);
    return points;
  }

  // Notes a strike of the pair at both of its bodies.
  void add(const ContactPair& pair) {
    const Index a = built_.simulation.contact_nodes[pair.slave->body].body,
                b = built_.simulation.contact_nodes[pair.master->body].body;
    Flying &first = flying_[a], &second = flying_[b];
    if (first.is_carried || second.is_carried) return;
    if (!first.is_free && (pair.wall || !second.is_free)) return;
    const std::optional<Strike> strike =
        pair.wall ? strike_on(*pair.wall, first, *pair.slave) : strike_of(pair, first, second);
    if (!strike) return;
    const Turn turn = turn_of(first, *strike),
               other = pair.wall ? Turn() : turn_of(second, *strike);
    const double impulse = strike->speed / (turn.mobility + other.mobility);
    const auto note = [&](Flying& of, const Turn& its) {
      of.hits.push_back({strike->t, its.arm, impulse * its.per_impulse,
                         strike->acceleration * its.per_length, &pair});
    };
    note(first, turn);
    if (!pair.wall) note(second, other);
  }

  // Of a body under an impulse along e: its arm, velocity there and spin per impulse, spin per
  // velocity there.
  struct Turn {
    double arm = 0, mobility = 0, per_impulse = 0, per_length = 0;
  };
  static Turn turn_of(const Flying& of, const Strike& strike) {
    constexpr double least_share = 0.05;  // of the radius of gyration
    const Eigen::Vector2d center = strike.across * of.center;
    Turn turn;
    turn.mobility = 1 / of.mass;
    const Eigen::Vector2d nearest =
        center.cwiseMax(strike.patch.min()).cwiseMin(strike.patch.max());
    const double arm = (nearest - center).norm();
    if (!of.is_free || !(arm > 0)) return turn;
    const Vector3 axis = strike.across.transpose() * (nearest - center).unitOrthogonal();
    const double square = of.square_of_gyration(axis);
    if (!(arm > least_share * std::sqrt(square))) return turn;
    turn.arm = arm;
    turn.per_impulse = arm / (of.mass * square);
    turn.mobility += arm * turn.per_impulse;
    turn.per_length = arm / (square + arm * arm);
    return turn;
  }

  // Fills when and how fast a gap closes; none: not before the end.
  std::optional<Strike> closed(Strike strike, double gap, double size, double v, double a) const {
    constexpr double touching = 1e-3;  // of the size
    if (gap < -touching * size) return {};
    const double root = v * v + 2 * a * std::max(0.0, gap);
    strike.t = gap > touching * size ? 2 * gap / (v + std::sqrt(std::max(0.0, root))) : 0;
    if (root < 0 || !(strike.t >= 0 && strike.t < end_)) return {};
    strike.speed = v + a * strike.t;
    strike.acceleration = std::max(0.0, a);
    return strike.speed > 0 || strike.acceleration > 0 ? std::optional(strike) : std::nullopt;
  }

  static Across axes_across(const Vector3& e) {
    Across axes;
    axes << e.unitOrthogonal().transpose(), e.cross(e.unitOrthogonal()).transpose();
    return axes;
  }

  static Patch box_across(const Points& x, const Across& across) {
    const Eigen::Matrix<double, Eigen::Dynamic, 2> flat = x * across.transpose();
    return {Eigen::Vector2d(flat.colwise().minCoeff()), Eigen::Vector2d(flat.colwise().maxCoeff())};
  }

  std::optional<Strike> strike_on(const RigidWall& wall, const Flying& of,
                                  const ContactSurface& surface) const {
    if (!wall.is_plane() || wall.moves()) return {};
    const Points x = points_of(surface);
    const Vector3 n = wall.normal(x.row(0).transpose());
    Strike strike{.e = -n, .across = axes_across(n), .patch = {}};
    const Front front = front_of(x, strike.e, strike.across, box_across(x, strike.across));
    strike.patch = front.patch;
    const double gap = wall.distance(x.row(0).transpose()) + x.row(0).dot(strike.e) - front.reach;
    return closed(strike, gap, surface.size, of.velocity.dot(strike.e), of.gravity.dot(strike.e));
  }

  std::optional<Strike> strike_of(const ContactPair& pair, const Flying& first,
                                  const Flying& second) const {
    const Vector3 v = first.velocity - second.velocity, g = first.gravity - second.gravity;
    const double apart = (first.center - second.center).norm(),
                 about = std::min(end_, apart / (v.norm() + std::sqrt(g.norm() * apart)));
    const Vector3 way = v + 0.5 * about * g;
    if (!(way.norm() > 0) || !std::isfinite(way.norm())) return {};
    Strike strike{.e = way.normalized(), .across = axes_across(way.normalized()), .patch = {}};
    const Points x = points_of(*pair.slave), y = points_of(*pair.master);
    const Patch common = box_across(x, strike.across).intersection(box_across(y, strike.across));
    const double size = std::min(pair.slave->size, pair.master->size);
    if (common.isEmpty() || !(common.sizes().minCoeff() > 1e-6 * size)) return {};
    const Front ahead = front_of(x, strike.e, strike.across, common),
                behind = front_of(y, -strike.e, strike.across, common);
    strike.patch = ahead.patch.intersection(behind.patch);
    if (strike.patch.isEmpty()) strike.patch = common;
    return closed(strike, -behind.reach - ahead.reach, size, v.dot(strike.e), g.dot(strike.e));
  }

  const BuiltScene& built_;
  double end_ = 0;
  std::vector<Flying> flying_;
};

}  // namespace

std::string first_turning_strike(const SceneIndex& index, const BuiltScene& built) {
  const auto may_turn = [](double limit) { return limit < HUGE_VAL; };
  if (std::none_of(built.turn_limit.begin(), built.turn_limit.end(), may_turn)) return {};
  const Strikes strikes(index, built);
  for (std::size_t i = 0; i < built.turn_limit.size(); ++i)
    if (may_turn(built.turn_limit[i]))
      if (std::string text = strikes.turning(i, built.turn_limit[i]); !text.empty()) return text;
  return {};
}

std::vector<double> turn_limits(const SceneIndex& index, const BuiltScene& built) {
  const Scene& scene = index.scene();
  const Load* gravity = gravity_of(scene);
  const std::set<std::string> linked = linked_instances(scene);
  std::vector<double> limits;
  for (std::size_t i = 0; i < built.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const bool could = built.instances[i].why_linear.empty() && !index.plan(instance).turns;
    limits.push_back(could ? small_rotation : HUGE_VAL);
    const bool stands = index.plan(instance).may_touch || linked.count(instance.name) > 0;
    if (!could || gravity == nullptr || !stands) continue;
    const Box box = extents(*built.simulation.bodies[i], built.instances[i]);
    limits.back() = std::min(limits.back(), limit_of_weight(box, gravity->value));
  }
  return limits;
}

}  // namespace cbr

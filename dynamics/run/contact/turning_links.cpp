// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/contact_group.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "common/base/error.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/motion/joint_body.hpp"

namespace cbr {
namespace {

// Position of an end of a link, and its rotation since the start.
struct Place {
  Vector3 x;
  Matrix3 S = Matrix3::Identity();
};

Place place_of(const Simulation& sim, const TurningLink& link, const TurningLink::End& end,
               bool at_end, const ContactState& state) {
  if (end.is_ground()) return {link.at};
  const ContactNodes& nodes = sim.contact_nodes[end.contact];
  Body& body = *sim.bodies[nodes.body];
  const ContactBody& contact = state.bodies[end.contact];
  const Points& x = at_end ? contact.end : contact.start;
  const Vector3 theta =
      (x.row(end.rotation) - body.reference_positions().row(nodes.nodes[end.rotation])).transpose();
  Place place{x.row(end.translation).transpose(), rotation_of(theta)};
  if (body.turns()) place.S *= (at_end ? body.turn_at_end() : body.turn_now()).R;
  return place;
}

// Both ends, and the carrier of the link's axes: the first end, or the ground.
struct Ends {
  Place first, second;
  Matrix3 C, D;     // rotations of the carrier and of the other end
  double side = 1;  // sign of the first end's rotation in the relative one of the other end
};

Ends ends_of(const Simulation& sim, const TurningLink& link, bool at_end,
             const ContactState& state) {
  Ends ends{place_of(sim, link, link.first, at_end, state),
            place_of(sim, link, link.second, at_end, state),
            {},
            {}};
  const bool on_ground = link.second.is_ground();
  ends.C = on_ground ? Matrix3::Identity() : ends.first.S;
  ends.D = on_ground ? ends.first.S : ends.second.S;
  ends.side = on_ground ? 1 : -1;
  return ends;
}

int n_fixed(const TurningLink& link) {
  return static_cast<int>(std::count(link.is_fixed.begin(), link.is_fixed.end(), true));
}

// Relative rotation for a row, and its rate per relative angular velocity, axes of the link.
struct Turned {
  Vector3 value = Vector3::Zero();
  Matrix3 rows = Matrix3::Zero();
};

// Angle of the free rotation if two are constrained, with the number of whole turns of `before`.
Turned twist(const Matrix3& Q, int k, double before) {
  const Eigen::Quaterniond q(Q);
  const double turn = 2 * std::numbers::pi;
  double angle = 2 * std::atan2(q.vec()[k], q.w());
  angle += turn * std::round((before - angle) / turn);
  Turned of;
  of.value[k] = angle;
  of.rows(k, k) = 1;
  return of;
}

// log Q with the number of whole turns of `before`, and d log Q / d omega = 1 - phi x / 2 + c phi x
// phi x.
Turned logarithm(const Matrix3& Q, const Vector3& before) {
  const double turn = 2 * std::numbers::pi;
  const Eigen::AngleAxisd of(Q);
  Vector3 axis = of.axis();
  double angle = of.angle();
  // After a whole turn the axis is undefined: keep the previous one
  if (angle < 1e-7 && before.norm() > std::numbers::pi) axis = before.normalized();
  angle += turn * std::round((before.dot(axis) - angle) / turn);
  const Vector3 phi = angle * axis;
  const double sine = std::sin(angle);
  const double c = std::abs(angle) < 1e-3 ? 1.0 / 12 + angle * angle / 720
                   : std::abs(sine) < 1e-12
                       ? 1 / (angle * angle)
                       : 1 / (angle * angle) - (1 + std::cos(angle)) / (2 * angle * sine);
  Matrix3 X;
  X << 0, -phi[2], phi[1], phi[2], 0, -phi[0], -phi[1], phi[0], 0;
  return {phi, Matrix3::Identity() - 0.5 * X + c * X * X};
}

// Constraint rows by the number of constrained rotations. Three: no relative rotation. Two:
// rotation about axis k only. One, a universal joint: axes j of the carrier and k of the other end
// stay orthogonal.
Turned held(const TurningLink& link, const Matrix3& Q) {
  if (n_fixed(link) == 3) return logarithm(Q, Vector3::Zero());
  const bool two = n_fixed(link) == 2;
  const int odd = static_cast<int>(std::find(link.is_fixed.begin(), link.is_fixed.end(), !two) -
                                   link.is_fixed.begin());
  Turned of;
  if (two) {
    const Vector3 e = Vector3::Unit(odd), b = Q * e;
    of.value = e.cross(b);
    of.rows = e.dot(b) * Matrix3::Identity() - b * e.transpose();
    return of;
  }
  const Vector3 e = Vector3::Unit((odd + 1) % 3), b = Q * Vector3::Unit((odd + 2) % 3);
  of.value[odd] = -e.dot(b);
  of.rows.row(odd) = e.cross(b).transpose();
  return of;
}

// Relative rotation in the pair's rows, first end to the other, axes of the link. before: of a
// spring, its rotation so far; given: the prescribed one.
Turned turned_by(const ContactPair& pair, const Ends& ends, const Vector3& before,
                 const Vector3& given) {
  const TurningLink& link = *pair.turning;
  // Rotation of the other end relative to the carrier, in axes of the link, beyond the given one
  const Matrix3 Q = link.axes * ends.C.transpose() * ends.D * link.axes.transpose() *
                    rotation_of(ends.side * given).transpose();
  Turned of;
  if (!pair.yields) {
    of = held(link, Q);
  } else if (n_fixed(link) == 2) {
    const auto k = std::find(link.is_fixed.begin(), link.is_fixed.end(), false);
    const int axis = static_cast<int>(k - link.is_fixed.begin());
    of = twist(Q, axis, ends.side * before[axis]);
  } else {
    of = logarithm(Q, ends.side * before);
  }
  of.value *= ends.side;
  return of;
}

Matrix3 only(const TurningLink& link, Matrix3 rows) {
  for (std::size_t d = 0; d < 3; ++d)
    if (!link.is_on[d]) rows.row(static_cast<Index>(d)).setZero();
  return rows;
}

// A with rows A = 1 on rows that are not 0, else 0: A = rows^T (rows rows^T)^-1
Matrix3 inverse_of_rows(const Matrix3& rows) {
  Matrix3 square = rows * rows.transpose();
  for (Index d = 0; d < 3; ++d)
    if (rows.row(d).isZero(0)) square(d, d) = 1;
  return rows.transpose() * square.inverse();
}

// For a spring: the node of its contact body in the pair's rows.
Index joint_node(const TurningLink& link) { return link.of_rotations ? 1 : 0; }

JointBody& joint_of(const Simulation& sim, const ContactPair& pair) {
  return static_cast<JointBody&>(*sim.bodies[sim.contact_nodes[pair.joint].body]);
}

// Extension of the spring, axes of the link.
Vector3 stretch(const Simulation& sim, const ContactPair& pair) {
  if (pair.joint < 0) return Vector3::Zero();
  return joint_of(sim, pair).stretch().segment<3>(3 * joint_node(*pair.turning));
}

Vector3 stretch_at_end(const Simulation& sim, const ContactPair& pair) {
  if (pair.joint < 0) return Vector3::Zero();
  return joint_of(sim, pair).stretch_at_end().segment<3>(3 * joint_node(*pair.turning));
}

void locate_joint(const Simulation& sim, const ContactPair& pair, ContactState& state) {
  const ContactNodes& nodes = sim.contact_nodes[pair.joint];
  ContactBody& contact = state.bodies[pair.joint];
  sim.bodies[nodes.body]->positions(nodes.set, contact.start);
  sim.bodies[nodes.body]->predicted_positions(nodes.set, contact.end);
  contact.response_h = 0;  // its rotation has changed
  sweep(contact);
}

Vector3 link_separation(const Simulation& sim, const ContactPair& pair, const ContactState& state) {
  const TurningLink& link = *pair.turning;
  const Ends ends = ends_of(sim, link, true, state);
  const Vector3 given = pair.driven ? pair.driven->shift.end : Vector3(Vector3::Zero());
  const Vector3 apart = ends.first.x - ends.second.x;
  Vector3 value = link.of_rotations ? turned_by(pair, ends, stretch(sim, pair), given).value
                  : link.length > 0
                      ? Vector3((apart.norm() - link.length) * Vector3::UnitX() - given)
                      : Vector3(link.axes * ends.C.transpose() * apart - given);
  value -= stretch_at_end(sim, pair);
  for (std::size_t d = 0; d < 3; ++d)
    if (!link.is_on[d]) value[static_cast<Index>(d)] = 0;
  return value;
}

}  // namespace

Matrix3 aim_link(Simulation& sim, const ContactPair& pair, ContactState& state) {
  const TurningLink& link = *pair.turning;
  const Ends ends = ends_of(sim, link, false, state);
  const Vector3 apart = ends.first.x - ends.second.x;
  if (link.length > 0 && !(apart.norm() > 1e-9 * link.length))
    throw RunError("the ends of link '" + pair.name +
                   "' meet, and no line is between them: a stop (links[].force) keeps them apart");
  const Matrix3 axes =
      link.length > 0 ? axes_along(apart) : Matrix3(link.axes * ends.C.transpose());
  Matrix3 rows = axes;
  const Vector3 given = pair.driven ? pair.driven->shift.start : Vector3(Vector3::Zero());
  if (link.of_rotations) rows = turned_by(pair, ends, stretch(sim, pair), given).rows * axes;
  if (link.slides >= 0) {
    const ContactNodes& nodes = sim.contact_nodes[link.first.contact];
    sim.bodies[nodes.body]->points()->slide(
        link.slides, ends.first.S.transpose() * (ends.second.x - ends.first.x));
    state.bodies[link.first.contact].response_h = 0;
  }
  rows = only(link, rows);
  if (pair.joint >= 0) {
    const Matrix3 to_scene = link.of_rotations ? inverse_of_rows(rows) : Matrix3(axes.transpose());
    joint_of(sim, pair).follow(joint_node(link), to_scene);
    locate_joint(sim, pair, state);
  }
  return rows;
}

Matrix3 tie_frame(const Simulation& sim, const ContactPair& pair, const ContactPoint& point) {
  if (pair.is_link || point.frame == Matrix3::Identity()) return point.frame;  // all directions
  const Body& master = *sim.bodies[sim.contact_nodes[pair.master->body].body];
  return point.frame * master.turn_now().R.transpose();
}

Vector3 separation(const Simulation& sim, const ContactPair& pair, std::size_t i,
                   const ContactState& state) {
  if (pair.turning) return link_separation(sim, pair, state);
  const PairState& of = pair.seen();
  const ContactPoint& point = of.ties.points[i];
  Vector3 offset = of.tie_offset.row(static_cast<Index>(i)).transpose();
  // The offset between tied surfaces rotates with the master
  Body& master = *sim.bodies[sim.contact_nodes[pair.master->body].body];
  if (!pair.is_link && master.turns()) offset = master.turn_at_end().R * offset;
  const Matrix3 frame = tie_frame(sim, pair, point);
  Vector3 r = -offset;
  for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
    const ContactTerm& term = of.ties.terms[t];
    r += term.coefficient * state.bodies[term.body].end.row(term.node).transpose();
  }
  return pair.driven ? Vector3(frame * r - pair.driven->shift.end) : frame * r;
}

bool renew_springs(const Simulation& sim, const ContactGroup& group, ContactState& state) {
  bool any = false;
  for (const Index b : group.bodies) {
    const Body& body = *sim.bodies[sim.contact_nodes[b].body];
    if (!body.facts().bends || !static_cast<const JointBody&>(body).has_new_response()) continue;
    state.bodies[b].response_h = 0;
    any = true;
  }
  return any;
}

void balance_moments(const Simulation& sim, const ContactGroup& group, const Points& p,
                     ContactState& state) {
  const auto turns = [&](Index b) { return state.bodies[b].turn.has_value(); };
  if (std::none_of(group.bodies.begin(), group.bodies.end(), turns)) return;
  std::vector<char> is_link(group.list.points.size(), 0);
  for (const ContactSearch& of : group.searches)
    std::fill(is_link.begin() + static_cast<std::ptrdiff_t>(of.first),
              is_link.begin() + static_cast<std::ptrdiff_t>(of.last), sim.pairs[of.pair].is_link);
  for (std::size_t i = 0; i < group.list.points.size(); ++i) {
    if (is_link[i]) continue;  // acts on both sides at one position
    const ContactPoint& point = group.list.points[i];
    const Vector3 of = p.row(static_cast<Index>(i)).transpose();
    const ContactTerm* terms = group.list.terms.data() + point.first_term;
    const Index slave = terms[0].body, master = terms[point.n_terms - 1].body;
    if (of.isZero(0) || slave == master) continue;
    Vector3 apart = Vector3::Zero();
    for (Index t = 0; t < point.n_terms; ++t)
      apart +=
          terms[t].coefficient * state.bodies[terms[t].body].start.row(terms[t].node).transpose();
    const Vector3 moment = apart.cross(Vector3(point.frame.transpose() * of));
    for (const Index b : {slave, master}) state.bodies[b].moment -= 0.5 * moment;
  }
}

bool does_not_close(const Simulation& sim, const ContactGroup& group) {
  const bool holds = std::any_of(
      group.searches.begin(), group.searches.end(),
      [&](const ContactSearch& of) { return sim.pairs[of.pair].law.law == ContactLaw::tied; });
  return holds && std::any_of(group.bodies.begin(), group.bodies.end(), [&](Index b) {
           const Body& body = *sim.bodies[sim.contact_nodes[b].body];
           return body.turns() || body.facts().bends;
         });
}

namespace {

// Tied points of a group, as a separate list.
struct Holds {
  ContactList list;
  std::vector<PointLaw> laws;
  std::vector<Index> points;  // of the group
  std::vector<Index> pairs;
  std::vector<std::size_t> places;  // in the pair's ties
  Vector sizes;                     // reference lengths of separations
};

double size_of(const Simulation& sim, const ContactPair& pair) {
  if (pair.turning) return pair.turning->of_rotations ? 1 : pair.turning->size;
  const Points& X = sim.bodies[sim.contact_nodes[pair.slave->body].body]->reference_positions();
  return (X.colwise().maxCoeff() - X.colwise().minCoeff()).norm();
}

Holds holds_of(const Simulation& sim, const ContactGroup& group) {
  Holds holds;
  std::vector<double> sizes;
  for (const ContactSearch& of : group.searches) {
    const ContactPair& pair = sim.pairs[of.pair];
    if (pair.law.law != ContactLaw::tied) continue;
    for (std::size_t i = of.first; i < of.last; ++i) {
      ContactPoint point = group.list.points[i];
      const auto first = group.list.terms.begin() + point.first_term;
      point.first_term = static_cast<Index>(holds.list.terms.size());
      holds.list.terms.insert(holds.list.terms.end(), first, first + point.n_terms);
      holds.list.points.push_back(point);
      holds.laws.push_back(group.laws[i]);
      holds.points.push_back(static_cast<Index>(i));
      holds.pairs.push_back(of.pair);
      holds.places.push_back(i - of.first);
      sizes.push_back(size_of(sim, pair));
    }
  }
  holds.sizes = Eigen::Map<const Vector>(sizes.data(), static_cast<Index>(sizes.size()));
  return holds;
}

// Largest relative separation, with springs that bend about their present ends; fills the gaps of
// the list.
double separate(const Simulation& sim, const ContactGroup& group, double h, Holds& holds,
                ContactState& state) {
  for (const Index b : group.bodies) {
    const ContactNodes& nodes = sim.contact_nodes[b];
    Body& body = *sim.bodies[nodes.body];
    if (body.facts().bends) {
      static_cast<JointBody&>(body).linearise_again();
      state.bodies[b].response = body.response(nodes.set, h);
      state.bodies[b].response_h = 0;
    }
    body.predicted_positions(nodes.set, state.bodies[b].end);
  }
  double worst = 0;
  for (std::size_t i = 0; i < holds.points.size(); ++i) {
    Vector3& gap = holds.list.points[i].gap;
    gap = separation(sim, sim.pairs[holds.pairs[i]], holds.places[i], state);
    worst = std::max(worst, gap.norm() / holds.sizes[static_cast<Index>(i)]);
  }
  return worst;
}

void push(Simulation& sim, const ContactGroup& group, ContactState& state) {
  for (const Index b : group.bodies) {
    ContactBody& contact = state.bodies[b];
    if (contact.impulses.isZero(0)) continue;
    const ContactNodes& nodes = sim.contact_nodes[b];
    Body& body = *sim.bodies[nodes.body];
    body.add_impulses(nodes.set, contact.impulses);
    if (contact.turn) body.add_moment(contact.moment);
    state.impulses_since_output[b] += contact.impulses;
  }
}

}  // namespace

void close_links(Simulation& sim, const ContactGroup& group, double h, ContactState& state,
                 EnforcementResult& result) {
  // Relative separations: round-off, and the limit of a solution
  constexpr double closed = 1e-13, open = 1e-7;
  constexpr int most = 40, most_stalls = 4;
  Holds holds = holds_of(sim, group);
  // Newton's method need not come nearer at once where springs pass a corner of their tables
  const bool bends = std::any_of(group.bodies.begin(), group.bodies.end(), [&](Index b) {
    return sim.bodies[sim.contact_nodes[b].body]->facts().bends;
  });
  const int patience = bends ? 12 : 0;
  ImpulseMemory memory;
  const Points guess = Points::Zero(static_cast<Index>(holds.points.size()), 3);
  double before = HUGE_VAL, separated = separate(sim, group, h, holds, state);
  // Mechanisms close by factors that vary: open ones go on after a step that gained little
  int stalls = 0;
  const auto goes_on = [&](int k) {
    return separated > closed && (separated < 0.5 * before || k < patience ||
                                  (separated > open && ++stalls <= most_stalls));
  };
  for (int k = 0; k < most && goes_on(k); ++k) {
    if (bends) memory = ImpulseMemory();
    for (const Index b : group.bodies) {
      ContactBody& contact = state.bodies[b];
      contact.impulses.setZero();
      contact.friction.setZero();
      contact.moment.setZero();
      contact.has_move = false;
    }
    const EnforcementResult more =
        enforce_impulse(holds.list, holds.laws, guess, h, state.bodies, memory);
    if (!more.p.allFinite()) break;
    Points p = Points::Zero(result.p.rows(), 3);
    for (std::size_t i = 0; i < holds.points.size(); ++i)
      p.row(holds.points[i]) = more.p.row(static_cast<Index>(i));
    balance_moments(sim, group, p, state);
    push(sim, group, state);
    result.p += p;
    before = separated;
    separated = separate(sim, group, h, holds, state);
  }
  for (const Index b : group.bodies) sweep(state.bodies[b]);
  // The first solution had the rows of the start; without other laws what remains open counts
  if (holds.points.size() == group.list.points.size()) result.residual = separated;
  if (separated <= open) return;
  std::ostringstream message;
  message.precision(3);
  message << "links or ties of '"
          << sim.bodies[sim.contact_nodes[group.bodies.front()].body]->name() << "' come apart by "
          << separated
          << " of their size in a step: the bodies turn too far in it, or springs change too much: "
             "take a smaller time.step";
  throw RunError(message.str());
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/lasting_forces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/run/contact/contact_booking.hpp"

namespace cbr {
namespace {

// The point of the segment from a to b nearest to 0.
Vector3 common(const Vector3& a, const Vector3& b) {
  // Squares of forces may overflow
  const double size = std::max(a.lpNorm<Eigen::Infinity>(), b.lpNorm<Eigen::Infinity>());
  if (!(size > 0) || !std::isfinite(size)) return a;
  const Vector3 from = a / size, way = b / size - from;
  const double square = way.squaredNorm();
  if (!(square > 0)) return a;
  return size * (from + std::clamp(-from.dot(way) / square, 0.0, 1.0) * way);
}

// Common part of the forces of the last three steps, by slot or point: the impulses of a landing
// body act in two steps only. Extrapolated forces added energy to damped bodies. Advances `memory`
// by a step.
Points lasting_part(Points now, PairMemory& memory) {
  if (memory.force.rows() != now.rows()) {
    memory.force = memory.begins_in_equilibrium ? now : Points(Points::Zero(now.rows(), 3));
    memory.force_before = memory.force;
  }
  Points part = now;
  for (Index i = 0; i < now.rows(); ++i) {
    const Vector3 last = memory.force.row(i), before = memory.force_before.row(i);
    part.row(i) = common(common(now.row(i), last), before);
  }
  memory.force_before.swap(memory.force);
  memory.force.swap(now);
  return part;
}

// Adds the lasting part of a search's forces, in the points' frames.
void add_part(const ContactGroup& group, const ContactSearch& of, bool by_slots,
              const Points& impulses, double h, Points& lasting) {
  const Index first = static_cast<Index>(of.first), n = static_cast<Index>(of.last) - first;
  const auto point = [&](Index i) -> const ContactPoint& { return group.list.points[first + i]; };
  const auto row = [&](Index i) { return by_slots ? point(i).slot : i; };
  Points now = Points::Zero(by_slots ? of.memory->offset.size() : n, 3);
  Vector sizes = Vector::Zero(now.rows());
  for (Index i = 0; i < n; ++i) {
    now.row(row(i)) += impulses.row(first + i) * point(i).frame / h;
    sizes[row(i)] += impulses.row(first + i).lpNorm<Eigen::Infinity>();
  }
  const Points part = lasting_part(std::move(now), *of.memory);
  for (Index i = 0; i < n; ++i) {
    const double size = impulses.row(first + i).lpNorm<Eigen::Infinity>();
    if (!(size > 0)) continue;
    lasting.row(first + i) = size / sizes[row(i)] * part.row(row(i)) * point(i).frame.transpose();
  }
}

// With one massless body, the impulses of the two bodies differ by a step. Lasting forces would
// then violate the sum of momenta, unless they act from the start of the run.
bool takes_lasting_forces(const Simulation& sim, const ContactPair& pair,
                          const PairMemory& memory) {
  if (pair.joint >= 0) return false;  // forces of its springs act in the middle of steps
  const auto body = [&](const ContactSurface& surface) -> Body& {
    return *sim.bodies[sim.contact_nodes[surface.body].body];
  };
  // The lever arms of its moments change
  if (body(*pair.slave).turns() || body(*pair.master).turns()) return false;
  const auto share = [&](const ContactSurface& surface) { return body(surface).lasting_share(); };
  const double slave = share(*pair.slave), master = share(*pair.master);
  // Masses of points do not support lasting forces
  return slave == master || (memory.begins_in_equilibrium && slave * master < 0);
}

// Adds the forces to lasting_next, by a temporary swap with the step's impulses.
void spread(const ContactGroup& group, const Points& lasting, ContactState& state) {
  for (const Index b : group.bodies) {
    ContactBody& body = state.bodies[b];
    ContactBody::Lasting& next = body.lasting_next;
    if (next.empty()) {
      next.contact.setZero(body.impulses.rows(), 3);
      next.friction = next.contact;
    }
    body.impulses.swap(next.contact);
    body.friction.swap(next.friction);
  }
  spread_impulses(group.list, group.laws, lasting, state.bodies);
  for (const Index b : group.bodies) {
    ContactBody& body = state.bodies[b];
    body.impulses.swap(body.lasting_next.contact);
    body.friction.swap(body.lasting_next.friction);
  }
}

}  // namespace

void find_lasting_forces(Simulation& sim, const ContactGroup& group,
                         const EnforcementResult& result, double h, ContactState& state) {
  Points lasting = Points::Zero(static_cast<Index>(group.list.points.size()), 3);
  for (const ContactSearch& of : group.searches) {
    const ContactPair& pair = sim.pairs[of.pair];
    if (state.has_springs || !takes_lasting_forces(sim, pair, *of.memory)) continue;
    add_part(group, of, pair.law.law != ContactLaw::tied, result.p, h, lasting);
  }
  if (!lasting.isZero(0)) spread(group, lasting, state);
  book_lasting_forces_of_walls(sim, group, lasting, h);
}

void hand_lasting_forces(Simulation& sim, double h, ContactState& state, ContactOutcome& outcome) {
  end_lasting_forces_of_walls(sim, outcome, h);
  for (std::size_t c = 0; c < state.bodies.size(); ++c) {
    ContactBody& contact = state.bodies[c];
    if (contact.lasting.empty() && contact.lasting_next.empty()) continue;
    outcome.touched[c] = 1;
    const ContactNodes& nodes = sim.contact_nodes[c];
    Body& body = *sim.bodies[nodes.body];
    const ContactBody::Lasting& next = contact.lasting_next;
    body.expect_forces(nodes.set, {next.contact, next.friction});
    Points& ahead = state.ahead_since_output[c];
    const double share = body.lasting_share() * h;
    if (ahead.rows() == 0) ahead.setZero(contact.impulses.rows(), 3);
    if (!next.empty()) ahead += share * (next.contact + next.friction);
    if (!contact.lasting.empty())
      ahead -= share * (contact.lasting.contact + contact.lasting.friction);
    std::swap(contact.lasting, contact.lasting_next);
    contact.lasting_next = {};
  }
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/run/contact/contact_group.hpp"

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

// Forces in the middle of the next step, by slot or point, on the least-squares line through the
// last five. Their difference from the common part of the five is at most half of it: the impulses
// of a landing body act in two steps only. The line through two added energy to damped bodies, that
// through three in cycles of strong damping. Advances `memory` by a step.
Points lasting_part(Points now, PairMemory& memory) {
  constexpr std::array<double, 4> weight{0.55, 0.2, -0.15, -0.5};  // and 0.9 of `now`
  if (memory.forces[0].rows() != now.rows())
    memory.forces.fill(memory.begins_in_equilibrium ? now : Points(Points::Zero(now.rows(), 3)));
  Points part = now;
  for (Index i = 0; i < now.rows(); ++i) {
    Vector3 lasts = now.row(i), line = 0.9 * lasts;
    if (lasts.isZero(0)) continue;  // common() is 0, as at most nodes near a wall
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const Vector3 before = memory.forces[k].row(i);
      lasts = common(lasts, before);
      line += weight[k] * before;
    }
    const Vector3 change = line - lasts;  // its square may underflow or overflow
    const double size = change.stableNorm(), most = 0.5 * lasts.stableNorm();
    part.row(i) = lasts + (size > most ? most / size : 1.0) * change;
  }
  std::rotate(memory.forces.begin(), memory.forces.end() - 1, memory.forces.end());
  memory.forces[0].swap(now);
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
    if (impulses.row(first + i).isZero(0)) continue;
    now.row(row(i)) += impulses.row(first + i) * point(i).frame / h;
    sizes[row(i)] += impulses.row(first + i).lpNorm<Eigen::Infinity>();
  }
  const Points part = lasting_part(std::move(now), *of.memory);
  for (Index i = 0; i < n; ++i) {
    const double size = impulses.row(first + i).lpNorm<Eigen::Infinity>();
    if (!(size > 0)) continue;
    lasting.row(first + i) = size / sizes[row(i)] * part.row(row(i)) * point(i).frame.transpose();
    if (group.laws[first + i].law == ContactLaw::frictionless)
      lasting.row(first + i).tail<2>().setZero();
  }
}

// With one massless body, the impulses of the two bodies differ by a step. Lasting forces would
// then violate the sum of momenta, unless they act from the start of the run.
bool takes_lasting_forces(const Simulation& sim, const ContactPair& pair,
                          const PairMemory& memory) {
  // Forces of its springs act in the middle of steps
  if (pair.joint >= 0 || pair.driven) return false;
  const auto body = [&](const ContactSurface& surface) -> Body& {
    return *sim.bodies[sim.contact_nodes[surface.body].body];
  };
  const Body &slave_body = body(*pair.slave), &master_body = body(*pair.master);
  if (slave_body.turns() || master_body.turns()) return false;  // its lever arms change
  const double slave = slave_body.lasting_share(), master = master_body.lasting_share();
  // Masses of points do not support lasting forces
  return slave == master || (memory.begins_in_equilibrium && slave * master < 0);
}

// Adds the forces to lasting_next.
void spread(const ContactGroup& group, const Points& lasting, ContactState& state) {
  for (const Index b : group.bodies) {
    ContactBody& body = state.bodies[b];
    if (body.lasting_next.rows() == 0) body.lasting_next.setZero(body.impulses.rows(), 3);
  }
  for (std::size_t i = 0; i < group.list.points.size(); ++i) {
    const ContactPoint& point = group.list.points[i];
    const Vector3 force = point.frame.transpose() * lasting.row(static_cast<Index>(i)).transpose();
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = group.list.terms[t];
      state.bodies[term.body].lasting_next.row(term.node) += term.coefficient * force.transpose();
    }
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
    if (contact.lasting.rows() == 0 && contact.lasting_next.rows() == 0) continue;
    outcome.touched[c] = 1;
    const ContactNodes& nodes = sim.contact_nodes[c];
    Body& body = *sim.bodies[nodes.body];
    body.expect_forces(nodes.set, contact.lasting_next);
    Points& ahead = state.ahead_since_output[c];
    const double share = body.lasting_share() * h;
    if (ahead.rows() == 0) ahead.setZero(contact.impulses.rows(), 3);
    if (contact.lasting_next.rows() > 0) ahead += share * contact.lasting_next;
    if (contact.lasting.rows() > 0) ahead -= share * contact.lasting;
    contact.lasting = std::move(contact.lasting_next);
    contact.lasting_next.resize(0, 3);
  }
}

}  // namespace cbr

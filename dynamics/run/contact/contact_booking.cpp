// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/contact_group.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "dynamics/contact/search/closeness.hpp"

namespace cbr {
namespace {

// Books the results of one search of the pair: resultants, extremes.
void book_pair(const ContactGroup& group, const ContactSearch& of, const EnforcementResult& result,
               const ContactState& state, const ContactPair& pair, PairState& now, Index& active) {
  const bool tied = pair.law.law == ContactLaw::tied;
  const double side = of.memory == &now.back ? -1 : 1;
  // each side has its own search
  const double share = pair.formulation == Formulation::two_way ? 0.5 : 1;
  Index counted = -1;  // a node at two faces counts with the larger area only
  double counted_area = 0;
  for (auto i = of.first; i < of.last; ++i) {
    const ContactPoint& point = group.list.points[i];
    const auto p = result.p.row(static_cast<Index>(i));
    const double normal = p[0];
    const bool acts = tied ? !p.isZero(0) : result.pushes(static_cast<Index>(i));
    // Penalty uses gaps at the start of a step
    const double gap = pair.enforcement == Enforcement::penalty
                           ? point.start_gap
                           : result.gap(static_cast<Index>(i), 0);
    if (!tied) now.recent_penetration = std::max(now.recent_penetration, -gap);
    if (!acts) continue;
    ++active;
    now.has_touched = true;
    if (point.slot != counted) counted_area = 0;
    const Index row = static_cast<Index>(i);
    const double area = result.is_held(row) ? result.held.area[row] : point.area;
    now.step.area += share * std::max(0.0, area - counted_area);
    counted = point.slot;
    counted_area = std::max(counted_area, area);
    now.step.impulse += side * (point.frame.transpose() * p.transpose());
    if (tied) continue;
    now.step.normal_impulse += normal;
    now.step.moment += normal * slave_position(group.list, point, state.bodies);
  }
}

void book_unknowns(const EnforcementResult& result, std::size_t search, PairState& now) {
  if (search >= result.n_unknowns.size() || result.n_unknowns[search] == 0) return;
  ++now.n_function_steps;
  now.n_unknowns += result.n_unknowns[search];
  now.most_unknowns = std::max(now.most_unknowns, result.n_unknowns[search]);
}

// Adds pressures at the corners of a surface, and their means at the other nodes of the loaded
// faces.
void spread_over_faces(const ContactSurface& surface, const ContactBody& body,
                       const Points& at_corners, Points& sum) {
  for (Index slot = 0; slot < at_corners.rows(); ++slot)
    sum.row(surface.nodes[slot]) += at_corners.row(slot);
  std::vector<char> is_done(static_cast<std::size_t>(sum.rows()), 0);
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const int n = n_corners(surface, f);
    const Vector3 normal = mean_normal(corners(surface, f, body.end));
    const auto at = [&](int a) -> Vector3 {
      return at_corners.row(slot_of(surface, f, a)).transpose();
    };
    Vector3 all = Vector3::Zero();
    for (int a = 0; a < n; ++a) all += at(a) / n;
    if (!(-all.dot(normal) > same_side * all.norm())) continue;
    for (Index m = 0; m < surface.middle.cols(); ++m) {
      const Index node = surface.middle(f, m);
      if (node < 0 || is_done[node] != 0) continue;
      is_done[node] = 1;
      const int a = static_cast<int>(m);
      sum.row(node) += (m < 4 ? Vector3(0.5 * (at(a) + at((a + 1) % n))) : all).transpose();
    }
  }
}

// Adds the way of this step along the other surface to that of the slave nodes that touch it. Of a
// rigid body few of these need an impulse.
void book_slip(const ContactGroup& group, const ContactSearch& of, const EnforcementResult& result,
               double size, Vector& slip) {
  constexpr double closed = 1e-9;  // times the size of a face
  Index counted = -1;              // a node at two faces counts once
  for (auto i = of.first; i < of.last; ++i) {
    const auto row = static_cast<Index>(i);
    const Index node = group.list.terms[group.list.points[i].first_term].node;
    const bool touches = result.pushes(row) || result.gap(row, 0) <= closed * size;
    if (group.laws[i].law != ContactLaw::coulomb || !touches || node == counted) continue;
    slip[node] += result.gap.row(row).tail<2>().norm();
    counted = node;
  }
}

// Books normal impulses at slave and master nodes, or pressures where these are known.
void book_pressure(const ContactGroup& group, const ContactSearch& of, const ContactPair& pair,
                   const EnforcementResult& result, ContactState& state) {
  const bool of_mortar = pair.formulation == Formulation::mortar && pair.slave->middle.rows() > 0;
  const bool is_wanted = state.pressure_since_output[pair.slave->body].rows() > 0;
  Points at_corners;
  if (of_mortar && is_wanted) at_corners.setZero(static_cast<Index>(pair.slave->nodes.size()), 3);
  for (auto i = of.first; i < of.last; ++i) {
    const ContactPoint& point = group.list.points[i];
    const Index row = static_cast<Index>(i);
    const Vector3 impulse = result.p(row, 0) * point.normal();
    const bool is_known = of_mortar || result.is_held(row);
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = group.list.terms[t];
      if (is_known && t < point.first_term + point.n_slave_terms) continue;
      Points& sum = state.normal_since_output[term.body];
      if (sum.rows() > 0) sum.row(term.node) += term.coefficient * impulse.transpose();
    }
    if (!is_known || !is_wanted) continue;
    if (of_mortar) {
      at_corners.row(point.slot) += impulse.transpose() / point.area;
    } else {
      state.pressure_since_output[pair.slave->body].row(group.list.terms[point.first_term].node) +=
          result.held.pressure[row] * point.normal().transpose();
    }
  }
  if (at_corners.size() > 0 && !at_corners.isZero(0))
    spread_over_faces(*pair.slave, state.bodies[pair.slave->body], at_corners,
                      state.pressure_since_output[pair.slave->body]);
}

}  // namespace

void book(Simulation& sim, const ContactGroup& group, const EnforcementResult& result,
          ContactState& state, ContactOutcome& outcome) {
  for (const ContactSearch& of : group.searches) sim.pairs[of.pair].state().step = {};
  for (const ContactSearch& of : group.searches) {
    ContactPair& pair = sim.pairs[of.pair];
    PairState& now = pair.state();
    outcome.near[of.pair] |= of.last > of.first;
    book_pair(group, of, result, state, pair, now, outcome.active[of.pair]);
    now.largest_area = std::max(now.largest_area, now.step.area);
    now.recent_residual = std::max(now.recent_residual, result.residual);
    now.n_fallbacks += result.fallback;
    book_unknowns(result, static_cast<std::size_t>(&of - group.searches.data()), now);
    if (pair.law.law != ContactLaw::tied) book_pressure(group, of, pair, result, state);
    Vector& slip = sim.contact_nodes[pair.slave->body].slip;
    if (slip.size() > 0 && of.memory == &now.memory)
      book_slip(group, of, result, pair.slave->size, slip);
  }
}

namespace {

struct WallImpulse {
  Vector3 normal = Vector3::Zero(), friction = Vector3::Zero();  // scene axes, or rows of a link
};

WallImpulse wall_impulse(const Simulation& sim, const ContactGroup& group, const ContactSearch& of,
                         const Points& impulses) {
  WallImpulse sum;
  const bool is_link = sim.pairs[of.pair].driven != nullptr;  // its rows
  for (auto i = of.first; i < of.last; ++i) {
    const ContactPoint& point = group.list.points[i];
    const Vector3 p = impulses.row(static_cast<Index>(i)).transpose();
    if (is_link) sum.normal += p;
    if (is_link) continue;
    sum.normal += p[0] * point.normal();
    sum.friction += point.frame.bottomRows<2>().transpose() * p.tail<2>();
  }
  return sum;
}

void add_wall_work(const WallImpulse& impulse, const Vector3& way, PairState& state) {
  state.wall_work += impulse.normal.dot(way);
  state.wall_friction_work += impulse.friction.dot(way);
}

// Whether impulses on the contact body act between two steps whose motions are known.
bool acts_between(const Simulation& sim, Index contact, const ContactState& state) {
  const BodyFacts& body = facts_of(sim, contact);
  return body.scheme != Scheme::newmark && !body.kicks_at_end &&
         state.bodies[contact].velocity_before.rows() > 0;
}

}  // namespace

// Friction as in book_friction().
void book_walls(Simulation& sim, const ContactGroup& group, const EnforcementResult& result,
                double h, const ContactState& state) {
  for (const ContactSearch& of : group.searches) {
    ContactPair& pair = sim.pairs[of.pair];
    if (pair.shift() == nullptr) continue;
    PairState& now = pair.state();
    const RigidWall::Shift& shift = *pair.shift();
    const WallImpulse impulse = wall_impulse(sim, group, of, result.p);
    const Vector3 velocity = shift.way() / h;
    const Index body = pair.slave->body;
    const bool between =
        facts_of(sim, body).scheme != Scheme::newmark && !facts_of(sim, body).kicks_at_end;
    // Impulses of links last, and so act between two steps
    now.wall_work += impulse.normal.dot(
        pair.driven && between ? Vector3(0.5 * (velocity + shift.way_before / h)) : velocity);
    if (facts_of(sim, body).kicks_at_end) {
      now.wall_friction_work += 0.5 * (impulse.friction + h * now.wall_friction).dot(velocity);
      now.wall_friction = impulse.friction / h;
    } else {
      const Vector3 before =
          acts_between(sim, body, state) ? shift.way_before / h : Vector3(velocity);
      now.wall_friction_work += 0.5 * impulse.friction.dot(velocity + before);
    }
  }
}

// Impulses between two steps work at the mean of the velocities in them. Those of newmark are
// forces of a step. What acts at the ends of steps does the mean work of both over a step.
void book_friction(const Simulation& sim, double h, bool is_static, ContactState& state) {
  for (std::size_t c = 0; c < sim.contact_nodes.size(); ++c) {
    ContactBody& contact = state.bodies[c];
    if (!contact.rubs) continue;
    Points &now = contact.rubbed, &last = contact.rubbed_before;
    const Index body = static_cast<Index>(c);
    const bool lasts = is_static || facts_of(sim, body).kicks_at_end,
               between = !lasts && acts_between(sim, body, state);
    if (!lasts) {
      const ContactNodes& nodes = sim.contact_nodes[c];
      state.friction_work += sim.bodies[nodes.body]->residual_friction(nodes.set, now, between);
    }
    if (now.rows() == 0 && last.rows() == 0) continue;
    const auto book = [&](const Points& impulses, const Points& velocity, double share) {
      if (impulses.rows() > 0) state.friction_work += share * impulses.cwiseProduct(velocity).sum();
    };
    const Points velocity = (contact.end - contact.start) / h;
    if (lasts) {
      book(now, velocity, 0.5);
      book(last, velocity, 0.5);
    } else if (between) {
      book(now, velocity, 0.5);
      book(now, contact.velocity_before, 0.5);
    } else {
      book(now, velocity, 1);
    }
    last = lasts ? std::move(now) : Points(0, 3);
    now.resize(0, 3);
  }
}

// Work of the mean force over a load step: half by the force at its start, half by that at its end.
void book_last_forces_of_walls(Simulation& sim) {
  for (ContactPair& pair : sim.pairs) {
    if (pair.shift() == nullptr) continue;
    PairState& state = pair.state();
    add_wall_work({state.wall_force, state.wall_friction}, 0.5 * pair.shift()->way(), state);
    state.wall_force.setZero();
    state.wall_friction.setZero();
  }
}

static void change_force_of_wall(const Simulation& sim, ContactPair& pair, const WallImpulse& force,
                                 double h) {
  PairState& state = pair.state();
  const Body& body = *sim.bodies[sim.contact_nodes[pair.slave->body].body];
  // In central differences impulses do work with the mean of the adjacent rates
  const double ahead = body.is_exact() ? body.lasting_share() * h : 0;
  const Vector3 all = force.normal + force.friction;
  state.wall_work += ahead * (all - state.wall_force).dot(pair.shift()->way()) / h;
  state.wall_force = all;
}

void book_lasting_forces_of_walls(Simulation& sim, const ContactGroup& group, const Points& p,
                                  double h) {
  for (const ContactSearch& of : group.searches)
    if (ContactPair& pair = sim.pairs[of.pair]; pair.shift() != nullptr && !pair.driven)
      change_force_of_wall(sim, pair, wall_impulse(sim, group, of, p), h);
}

void end_lasting_forces_of_walls(Simulation& sim, const ContactOutcome& outcome, double h) {
  for (const Index p : outcome.searched)
    if (ContactPair& pair = sim.pairs[p];
        pair.shift() != nullptr && !pair.driven && !outcome.near[p] && pair.has_state()) {
      change_force_of_wall(sim, pair, {}, h);
      PairState& state = pair.state();
      if (facts_of(sim, pair.slave->body).kicks_at_end)
        state.wall_friction_work += 0.5 * state.wall_friction.dot(pair.shift()->way());
      state.wall_friction.setZero();
    }
}

void book_walls_in_statics(Simulation& sim, const ContactGroup& group,
                           const EnforcementResult& result) {
  for (const ContactSearch& of : group.searches) {
    ContactPair& pair = sim.pairs[of.pair];
    if (pair.shift() == nullptr) continue;
    const WallImpulse force = wall_impulse(sim, group, of, result.p);
    add_wall_work(force, 0.5 * pair.shift()->way(), pair.state());
    pair.state().wall_force = force.normal;
    pair.state().wall_friction = force.friction;
  }
}

// Relative velocities over the step; and by how much of itself mu would change, with what it has
// changed of the slip speed.
static void remember_slip(const ContactGroup& group, const ContactSearch& of,
                          const EnforcementResult& result, double h, const ContactState& state,
                          ContactPair& pair) {
  // Of a face: slips of bodies at rest are round-off
  constexpr double at_rest = 1e-10;
  const bool may_take_functions =
      pair.functions && of.memory->begins_in_equilibrium && pair.law.law == ContactLaw::coulomb;
  if (!pair.friction.varies() && !may_take_functions) return;
  of.memory->velocity.setConstant(of.memory->offset.size(), 3, HUGE_VAL);
  for (auto i = of.first; i < of.last; ++i) {
    const ContactPoint& point = group.list.points[i];
    Vector3 velocity = Vector3::Zero();
    if (h > 0) velocity = motion_of(pair, group.list, point, state) / h;
    if (velocity.norm() * h < at_rest * pair.master->size) velocity.setZero();
    of.memory->velocity.row(point.slot) = velocity.transpose();
    const Vector3 p = result.p.row(static_cast<Index>(i));
    const double mu = group.laws[i].friction;
    if (!(h > 0) || !(mu * p[0] > 0) || !slides(p, mu)) continue;
    const Eigen::Vector2d slip = point.frame.bottomRows<2>() * velocity;
    const double change = (slip - point.gap.tail<2>() / h).norm();
    PairState& now = pair.state();
    now.friction_change =
        std::max(now.friction_change, std::abs(pair.friction.slope(slip.norm())) * change / mu);
  }
}

void remember(Simulation& sim, const ContactGroup& group, const EnforcementResult& result, double h,
              const ContactState& state) {
  for (const ContactSearch& of : group.searches) {
    ContactPair& pair = sim.pairs[of.pair];
    if (pair.law.law == ContactLaw::tied) continue;
    remember_slip(group, of, result, h, state, pair);
    remember(group.list, of.first, of.last, result.gap, result.p, 1e-6 * pair.master->size,
             *of.memory, [&](std::size_t i) { return result.pushes(static_cast<Index>(i)); });
  }
}

namespace {

// Current position of its contact nodes.
ContactBody standing_body(const Simulation& sim, Index contact) {
  const ContactNodes& nodes = sim.contact_nodes[contact];
  Body& body = *sim.bodies[nodes.body];
  ContactBody at;
  body.positions(nodes.set, at.start);
  at.end = at.start;
  if (body.turns()) at.turn = body.turn_of_step();
  return at;
}

Box box_of_nodes(const ContactSurface& surface, const Points& x, double margin) {
  Box box{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
  for (const Index node : surface.nodes) {
    box.lower = box.lower.cwiseMin(x.row(node).transpose());
    box.upper = box.upper.cwiseMax(x.row(node).transpose());
  }
  return {box.lower.array() - margin, box.upper.array() + margin};
}

}  // namespace

void look_at_depths(Simulation& sim, const ContactOutcome& outcome) {
  std::vector<Index> pairs = outcome.met;
  pairs.insert(pairs.end(), outcome.searched.begin(), outcome.searched.end());
  sort_uniquely(pairs);
  std::map<Index, ContactBody> bodies;
  for (const Index p : pairs) {
    ContactPair& pair = sim.pairs[p];
    if (pair.wall || pair.is_link || pair.law.law == ContactLaw::tied || pair.resolves_overlap ||
        pair.interference != 0)
      continue;
    for (const Index b : {pair.slave->body, pair.master->body})
      if (bodies.find(b) == bodies.end()) bodies.emplace(b, standing_body(sim, b));
    const ContactBody &slave = bodies.at(pair.slave->body), &master = bodies.at(pair.master->body);
    const double reach = std::max(pair.slave->size, pair.master->size);
    if (!box_of_nodes(*pair.slave, slave.start, reach)
             .meets(box_of_nodes(*pair.master, master.start, 0)))
      continue;
    PairState& state = pair.state();
    const double known = std::max(0.0, state.recent_penetration + state.memory.initial_overlap);
    const Closeness of = closeness(*pair.slave, slave, *pair.master, master, reach, sim.detection,
                                   known, state.look);
    if (of.depth > known) state.recent_penetration = of.depth - state.memory.initial_overlap;
    state.penetration = std::max(state.penetration, state.recent_penetration);
  }
}

}  // namespace cbr

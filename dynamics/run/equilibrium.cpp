// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

#include "common/base/error.hpp"
#include "dynamics/run/contact/contact_booking.hpp"

namespace cbr {
namespace {

// Of the energy norm of the displacements: what an iteration changes at the end of a load step;
// what is good enough when round-off or a node at the edge of a face lets no iteration do better,
// and after how many of them.
constexpr double aim = 1e-8, enough = 1e-5;
constexpr Index patience = 40, most_iterations = 200;
// Of the largest change in a load step: round-off where nothing is strained.
constexpr double nothing = 1e-12;
// Of positions: what moves by less, rms over the mass, moves by round-off.
constexpr double round_off = 4e-15;
// A body that goes on by more than this share of its last move is let go faster, by this factor at
// a time.
constexpr double goes_on = 0.5, let_go = 0.1, least_hold = 1e-6;
// Bodies on springs, which are far softer than they, would be slow to follow; without contact that
// opens nothing else has to be held.
constexpr double sprung_hold = 1e-3;
// Of its own size, the way in one load step by which a body is not held.
constexpr double lost = 10;

double extent_of(const Body& body) {
  const Points& X = body.reference_positions();
  const double extent = (X.colwise().maxCoeff() - X.colwise().minCoeff()).norm();
  // Of one point alone the part is as long as it is away from the point
  return extent > 0 ? extent : (body.state().center_of_mass - X.row(0).transpose()).norm();
}

}  // namespace

Equilibrium::Equilibrium(Simulation& simulation, ContactState& state, ContactOutcome& outcome)
    : sim_(simulation),
      state_(state),
      outcome_(outcome),
      pairs_(simulation.pairs.size()),
      known_(simulation.pairs.size()) {
  std::iota(pairs_.begin(), pairs_.end(), Index{0});
  for (const auto& body : sim_.bodies) {
    extent_.push_back(extent_of(*body));
    const Points& X = body->reference_positions();
    reach_ = std::max(reach_, X.size() > 0 ? X.cwiseAbs().maxCoeff() : 0.0);
  }
  for (const ContactNodes& nodes : sim_.contact_nodes)
    forces_.push_back(Points::Zero(static_cast<Index>(nodes.nodes.size()), 3));
  moved_ = forces_;
  is_pushed_.assign(forces_.size(), 0);
  state_.islands.clear();
  const auto any = [&](const auto& is) {
    return std::any_of(sim_.pairs.begin(), sim_.pairs.end(), is);
  };
  if (any([](const ContactPair& pair) { return pair.yields; }))
    full_hold_ = any([](const ContactPair& pair) { return pair.law.law != ContactLaw::tied; })
                     ? sprung_hold
                     : least_hold;
}

void Equilibrium::preload(Index steps) {
  for (const Index p : pairs_)
    if (sim_.pairs[p].law.law != ContactLaw::tied) sim_.pairs[p].state().memory.lets_jump = true;
  add_bolts();
  sim_.shift_walls(0, 0);
  for (Index i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(steps);
    resolve_overlaps(share);
    iterate({0, share, full_hold_});
  }
  lock_bolts();
}

void Equilibrium::step(double t) {
  sim_.shift_walls(last_t_, t);
  last_t_ = t;
  iterate({t, 1, full_hold_});
}

void Equilibrium::iterate(const Rest& loads) {
  outcome_.next_step();
  outcome_.searched = pairs_;
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->positions(nodes.set, state_.bodies[c].start);
  }
  keep_known();
  way_.assign(sim_.bodies.size(), 0);
  last_way_ = way_;
  hold_ = full_hold_;
  most_change_ = 0;
  for (iteration_ = 1;; ++iteration_) {
    ++n_iterations_;
    Rest rest = loads;
    rest.hold = hold_;
    for (auto& body : sim_.bodies) statics_of(*body).relax(rest);
    predict_bolts(loads.share);
    locate(hold_);
    solve(hold_);
    double change = change_of_bolts(), energy = 0, way = 0;
    std::vector<Settled> settled;
    for (auto& body : sim_.bodies) {
      settled.push_back(statics_of(*body).settle());
      change += settled.back().change;
      energy += settled.back().energy;
      way = std::max(way, settled.back().way);
    }
    if (!std::isfinite(change + energy))
      throw RunError(
          "statics: the equilibrium is no longer finite: are loads or units beyond a double's "
          "reach?");
    if (is_done(change, energy, way)) break;
    watch(settled, loads.t);
    recall();
  }
  for (auto& body : sim_.bodies) statics_of(*body).end_load_step();
  book();
  initial_ = false;
}

bool Equilibrium::is_done(double change, double energy, double way) {
  most_change_ = std::max(most_change_, change);
  const double scale = energy + nothing * most_change_;
  // What moves without strain has no energy to compare with
  const bool stands = change <= aim * aim * scale || way <= round_off * reach_;
  if (stands && missing_pull_ <= aim && hold_ == full_hold_ && iteration_ > 1) return true;
  if (change == 0 && missing_pull_ == 0) return true;
  if (iteration_ >= patience && change <= enough * enough * scale) return true;
  if (iteration_ < most_iterations) return false;
  std::ostringstream text;
  text.precision(3);
  text << "statics: no equilibrium was found in " << most_iterations
       << " iterations; the last one changed the displacements by "
       << std::sqrt(change / std::max(scale, 1e-300))
       << " of themselves (energy norm): take smaller load steps (time.step, "
       << "time.preload), or hold what hardly anything holds";
  throw RunError(text.str());
}

// What contact is to stop and does not goes on and on: faster, so that it arrives, or is seen to be
// lost.
void Equilibrium::watch(const std::vector<Settled>& settled, double t) {
  bool any = false;
  for (std::size_t b = 0; b < settled.size(); ++b) {
    way_[b] += settled[b].way;
    if (way_[b] > lost * extent_[b]) refuse_unheld(static_cast<Index>(b), t);
    any |= iteration_ > 3 && settled[b].way > goes_on * last_way_[b] &&
           settled[b].change > 1e-6 * most_change_;
    last_way_[b] = settled[b].way;
  }
  hold_ = any ? std::max(least_hold, let_go * hold_) : std::min(full_hold_, hold_ / let_go);
}

void Equilibrium::refuse_unheld(Index b, double t) const {
  const Body& body = *sim_.bodies[b];
  Points u, v;
  body.displacements(u, v);
  const Vector3 mean = u.colwise().mean().transpose();
  std::ostringstream text;
  text.precision(3);
  text << "statics: instance '" << body.name() << "' is not held: under its loads at t = " << t
       << " s it ";
  if (mean.norm() > 0.2 * u.rowwise().norm().mean()) {
    const Vector3 way = mean.normalized();
    text << "moves along [" << way[0] << ", " << way[1] << ", " << way[2] << "]";
  } else {
    text << "turns";
  }
  text << " without end: hold it by boundary, tied surfaces, contact that it is pressed into, or "
          "friction";
  throw InputError(text.str());
}

// Where the last forces of contact take the nodes; without them the ends are where contact is
// solved from.
void Equilibrium::locate(double hold) {
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    ContactBody& contact = state_.bodies[c];
    Body& body = *sim_.bodies[nodes.body];
    if (contact.response_h != -hold) {
      contact.response = statics_of(body).static_response(nodes.set, hold);
      contact.response_h = -hold;
    }
    body.predicted_positions(nodes.set, contact.end);
    moved_[c].setZero();
    if (is_pushed_[c]) contact.response.add_product(forces_[c], moved_[c]);
    contact.end += moved_[c];
    sweep(contact);
  }
}

void Equilibrium::solve(double hold) {
  solved_.clear();
  for (Points& force : forces_) force.setZero();
  std::fill(is_pushed_.begin(), is_pushed_.end(), 0);
  for (const auto& pairs : islands(sim_, pairs_, Enforcement::impulse)) solve_group(pairs, hold);
}

void Equilibrium::solve_group(const std::vector<Index>& pairs, double hold) {
  Solved solved{collect(sim_, pairs, initial_, state_), {}};
  ContactGroup& group = solved.group;
  if (group.list.empty()) {
    for (const ContactSearch& of : group.searches) forget(*of.memory);
    return;
  }
  for (ContactPoint& point : group.list.points) {
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = group.list.terms[t];
      if (term.body < static_cast<Index>(moved_.size()))
        point.gap -=
            term.coefficient * (point.frame * moved_[term.body].row(term.node).transpose());
    }
  }
  for (const Index b : group.bodies) {
    state_.bodies[b].impulses.setZero();
    state_.bodies[b].friction.setZero();
    state_.bodies[b].has_move = false;
  }
  ImpulseMemory& memory = state_.islands[pairs.front()];
  solved.result = enforce_impulse(group.list, group.laws, group.guess, hold, state_.bodies, memory);
  for (const Index b : group.bodies) give(b);
  remember(sim_, group, solved.result);
  solved_.push_back(std::move(solved));
}

// Hands a contact body's forces to its body.
void Equilibrium::give(Index b) {
  ContactBody& contact = state_.bodies[b];
  if (b >= static_cast<Index>(sim_.contact_nodes.size())) {
    for (Bolt& bolt : bolts_)
      if (bolt.body == b) bolt.force = -bolt.normal.dot(contact.impulses.row(0).transpose());
    return;
  }
  const ContactNodes& nodes = sim_.contact_nodes[b];
  StaticsAbility& body = statics_of(*sim_.bodies[nodes.body]);
  forces_[b] = contact.impulses + contact.friction;
  is_pushed_[b] = !forces_[b].isZero(0);
  outcome_.touched[b] |= is_pushed_[b];
  if (!contact.impulses.isZero(0))
    body.add_static_forces(nodes.set, contact.impulses, ImpulseKind::contact);
  if (!contact.friction.isZero(0))
    body.add_static_forces(nodes.set, contact.friction, ImpulseKind::friction);
}

// Forces of this load step stand for those since the last output.
void Equilibrium::book() {
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    pair.impulse = pair.moment = Vector3::Zero();
    pair.normal_impulse = pair.area = 0;
  }
  book_last_forces_of_walls(sim_);
  for (std::size_t c = 0; c < forces_.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->positions(nodes.set, state_.bodies[c].end);
    state_.impulses_since_output[c] = forces_[c];
    if (state_.normal_since_output[c].rows() > 0) state_.normal_since_output[c].setZero();
  }
  for (const Solved& solved : solved_) {
    cbr::book(sim_, solved.group, solved.result, state_, outcome_);
    book_walls_in_statics(sim_, solved.group, solved.result);
  }
  for (const Index p : pairs_) {
    if (!outcome_.near[p] || outcome_.has_met[p]) continue;
    outcome_.has_met[p] = 1;
    outcome_.met.push_back(p);
  }
}

void Equilibrium::keep_known() {
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    known_[p].clear();
    for (const PairMemory* memory : {&pair.memory, &pair.back})
      known_[p].push_back({memory->face, memory->known_face, memory->further_faces, memory->offset,
                           memory->has_points, memory->depth});
  }
}

// What is searched for anew is searched from the start of the load step; forces to start the
// solution from stay.
void Equilibrium::recall() {
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    std::size_t side = 0;
    for (PairMemory* memory : {&pair.memory, &pair.back}) {
      const Known& known = known_[p][side++];
      if (known.face.size() != memory->face.size()) {  // it was not searched before this load step
        std::fill(memory->face.begin(), memory->face.end(), -1);
        std::fill(memory->known_face.begin(), memory->known_face.end(), -1);
        std::fill(memory->further_faces.begin(), memory->further_faces.end(), -1);
        memory->offset.setZero();
        memory->has_points = false;
        memory->depth = 0;
        continue;
      }
      memory->face = known.face;
      memory->known_face = known.known_face;
      memory->further_faces = known.further_faces;
      memory->offset = known.offset;
      memory->has_points = known.has_points;
      memory->depth = known.depth;
    }
  }
}

// Overlaps that are left as they are become less with each load step.
void Equilibrium::resolve_overlaps(double share) {
  const double left = resolved_ < 1 ? (1 - share) / (1 - resolved_) : 0;
  for (const Index p : pairs_) {
    if (!sim_.pairs[p].resolves_overlap) continue;
    PairMemory& memory = sim_.pairs[p].state().memory;
    memory.kept_share = 1 - share;
    for (double& offset : memory.offset)
      if (offset < 0) offset *= left;
  }
  resolved_ = share;
}

void Equilibrium::start_motion(double h) {
  for (auto& body : sim_.bodies) statics_of(*body).start_motion(h, {});
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    if (forces_[c].isZero(0)) continue;
    ContactBody::Lasting& lasting = state_.bodies[c].lasting;
    lasting.friction = state_.bodies[c].friction;
    lasting.contact = forces_[c] - lasting.friction;
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->expect_forces(nodes.set, {lasting.contact, lasting.friction});
  }
  for (const Index p : pairs_) {
    const bool is_penalty = sim_.pairs[p].enforcement == Enforcement::penalty;
    PairState& pair = sim_.pairs[p].state();
    for (PairMemory* memory : {&pair.memory, &pair.back}) {
      memory->lets_jump = is_penalty;
      memory->kept_share = 1;
      memory->impulse *= h;
      memory->begins_in_equilibrium = true;
    }
    pair.impulse = pair.moment = Vector3::Zero();
    pair.normal_impulse = 0;
  }
  for (ContactBody& contact : state_.bodies) contact.response_h = 0;
  for (Points& impulses : state_.impulses_since_output) impulses.setZero();
  for (Points& impulses : state_.normal_since_output) impulses.setZero();
  state_.islands.clear();
}

}  // namespace cbr

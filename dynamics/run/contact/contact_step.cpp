// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/contact_step.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "dynamics/contact/surfaces/shared_area.hpp"
#include "dynamics/run/contact/contact_group.hpp"
#include "dynamics/run/simulation/run_result.hpp"

namespace cbr {
namespace {

// Applies the group's impulses to the bodies; nodal: as velocities of the nodes only.
void deliver(Simulation& sim, const ContactGroup& group, bool nodal, double h, ContactState& state,
             ContactOutcome& outcome) {
  for (const Index b : group.bodies) {
    ContactBody& contact = state.bodies[b];
    const ContactNodes& nodes = sim.contact_nodes[b];
    Body& body = *sim.bodies[nodes.body];
    const bool pushed = !contact.impulses.isZero(0), rubbed = !contact.friction.isZero(0);
    outcome.touched[b] |= pushed || rubbed;
    if (pushed && nodal) {
      const Points velocities = contact.impulses.cwiseQuotient(state.masses[b]);
      const Vector3 momentum = contact.impulses.colwise().sum().transpose();
      const Vector3 extra = body.add_velocities(nodes.set, velocities, momentum);
      contact.end += h * (velocities.rowwise() + extra.transpose());
    } else if (pushed || rubbed) {
      const Points sum = rubbed ? Points(contact.impulses + contact.friction) : Points();
      const Points& all = rubbed ? sum : contact.impulses;
      if (contact.has_move) {
        body.take_impulses(nodes.set, {all, &contact.move, &contact.still});
        contact.end += contact.move;
      } else {
        body.add_impulses(nodes.set, all);
        contact.response.add_product(all, contact.end);
      }
    }
    if (contact.turn) body.add_moment(contact.moment);
    if (pushed || rubbed) sweep(contact);
    if (pushed) state.impulses_since_output[b] += contact.impulses;
    if (!rubbed) continue;
    state.impulses_since_output[b] += contact.friction;
    if (contact.rubbed.rows() == 0) contact.rubbed.setZero(contact.friction.rows(), 3);
    contact.rubbed += contact.friction;
  }
}

// mu at the slip speed of the last step; of a point that was not there, at that of this step
// without contact.
void evaluate_friction(const Simulation& sim, double h, ContactGroup& group) {
  for (const ContactSearch& of : group.searches) {
    const FrictionLaw& friction = sim.pairs[of.pair].friction;
    const Points& velocity = of.memory->velocity;
    for (auto i = of.first; friction.varies() && i < of.last; ++i) {
      const ContactPoint& point = group.list.points[i];
      const bool is_known = velocity.rows() > 0 && std::isfinite(velocity(point.slot, 0));
      const double speed =
          is_known ? (point.frame.bottomRows<2>() * velocity.row(point.slot).transpose()).norm()
                   : point.gap.tail<2>().norm() / h;
      group.laws[i].friction = friction.coefficient(speed);
    }
  }
}

void prepare(const Simulation& sim, double h, ContactGroup& group, ContactState& state) {
  evaluate_friction(sim, h, group);
  for (const Index b : group.bodies) {
    ContactBody& body = state.bodies[b];
    clear_impulses(body);
    body.moment.setZero();
    if (body.response_h == h && !body.turn) continue;
    body.response = sim.bodies[sim.contact_nodes[b].body]->response(sim.contact_nodes[b].set, h);
    body.response_h = h;
  }
}

double largest_frequency(const Simulation& sim, const ContactGroup& group) {
  double omega = 0;
  for (const Index b : group.bodies)
    omega = std::max(omega, sim.bodies[sim.contact_nodes[b].body]->largest_frequency());
  return omega;
}

// Extension of the springs at the start of the step, per point.
Points elastic_slips(const ContactGroup& group) {
  Points slip = Points::Zero(static_cast<Index>(group.list.points.size()), 3);
  for (const ContactSearch& of : group.searches) {
    if (of.memory->elastic_slip.rows() == 0) continue;
    for (auto i = of.first; i < of.last; ++i)
      slip.row(static_cast<Index>(i)) = of.memory->elastic_slip.row(group.list.points[i].slot);
  }
  return slip;
}

// Adds the step's motion to the extension of springs in contact; resets the others.
void stretch_springs(const Simulation& sim, const ContactGroup& group,
                     const EnforcementResult& result, const Points& slip,
                     const ContactState& state) {
  for (const ContactSearch& of : group.searches) {
    of.memory->elastic_slip.setZero(of.memory->offset.size(), 3);
    for (auto i = of.first; i < of.last; ++i) {
      const ContactPoint& point = group.list.points[i];
      if (group.laws[i].law != ContactLaw::coulomb || !(result.p(static_cast<Index>(i), 0) > 0))
        continue;
      const Vector3 motion = motion_of(sim.pairs[of.pair], group.list, point, state);
      of.memory->elastic_slip.row(point.slot) =
          slip.row(static_cast<Index>(i)) +
          (motion - point.normal() * point.normal().dot(motion)).transpose();
    }
  }
}

// memory: null for nodal contact, which has no state.
EnforcementResult enforce(Simulation& sim, ContactGroup& group, double h, ContactState& state,
                          ImpulseMemory* memory, ContactOutcome& outcome) {
  const bool nodal = memory == nullptr;
  EnforcementResult result =
      nodal ? enforce_nodal(group.list, group.guess, h, state.masses, state.bodies)
            : enforce_and_rebound(sim, group, h, state, *memory);
  balance_moments(sim, group, result.p, state);
  deliver(sim, group, nodal, h, state, outcome);
  if (does_not_close(sim, group)) close_links(sim, group, h, state, result);
  return result;
}

// Residual displacement under the last step's forces, scene axes. The predictor excludes it; it is
// a good guess for this step. Empty: none.
Points last_statics(const ContactBody& body) {
  const auto& thin = body.response.thin;
  if (!thin || thin->A->rows() == 0 || thin->rows->size() == 0 ||
      body.still.size() != thin->rows->size())
    return {};
  Matrix moved = Matrix::Zero(thin->n_dofs(), 1);
  thin->rows->add_spread(body.still, moved);
  Points statics(thin->n_dofs() / 3, 3);
  for (Index i = 0; i < statics.rows(); ++i)
    statics.row(i) = (body.response.axes * moved.col(0).segment<3>(3 * i)).transpose();
  return statics;
}

// Searches with the residual displacement under the last forces, which does not count in the motion
// of the step. The gaps of the points exclude it.
ContactGroup collect_with_statics(Simulation& sim, const std::vector<Index>& pairs, bool initial,
                                  ContactState& state) {
  std::map<Index, Points> statics;
  for (const Index p : pairs)
    for (const Index b : {sim.pairs[p].slave->body, sim.pairs[p].master->body})
      if (const auto [at, is_new] = statics.try_emplace(b); is_new)
        at->second = last_statics(state.bodies[b]);
  std::erase_if(statics, [](const auto& of) { return of.second.rows() == 0; });
  for (const auto& [b, moved] : statics) {
    state.bodies[b].end += moved;
    sweep(state.bodies[b]);
  }
  ContactGroup group = collect(sim, pairs, initial, state);
  for (const auto& [b, moved] : statics) {
    state.bodies[b].end -= moved;
    sweep(state.bodies[b]);
  }
  if (statics.empty()) return group;
  for (ContactPoint& point : group.list.points) {
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = group.list.terms[t];
      if (const auto of = statics.find(term.body); of != statics.end())
        point.gap -= term.coefficient * (point.frame * of->second.row(term.node).transpose());
    }
  }
  return group;
}

// Points of several pairs, ready to be solved. Without points it resets the state of the pairs.
ContactGroup start_group(Simulation& sim, const std::vector<Index>& pairs, double h, bool initial,
                         ContactState& state, StepSeconds& seconds) {
  ContactGroup group = [&] {
    const Stopwatch watch(seconds.search);
    return collect_with_statics(sim, pairs, initial, state);
  }();
  if (group.list.empty()) {
    for (const ContactSearch& of : group.searches) forget(*of.memory);
    return group;
  }
  const Stopwatch watch(seconds.response);
  prepare(sim, h, group, state);
  return group;
}

// Number of islands per batch, as the points of a batch are kept until all are searched.
constexpr std::size_t islands_at_once = 256;
// A larger island is solved alone, with all threads.
constexpr std::size_t many_points = 256;

// Islands of one enforcement, which share no body.
class Islands {
 public:
  Islands(Simulation& sim, double h, bool initial, ContactState& state, ContactOutcome& outcome)
      : sim_(sim), h_(h), initial_(initial), state_(state), outcome_(outcome) {}

  void solve(const std::vector<std::vector<Index>>& all, StepSeconds& seconds) {
    for (std::size_t first = 0; first < all.size(); first += islands_at_once)
      solve(all, first, std::min(first + islands_at_once, all.size()), seconds);
  }

 private:
  struct Island {
    const std::vector<Index>* pairs = nullptr;
    bool alone = false;  // see BodyFacts::steps_alone
    ContactGroup group;
    ImpulseMemory* memory = nullptr;
  };

  void solve(const std::vector<std::vector<Index>>& all, std::size_t first, std::size_t last,
             StepSeconds& seconds) {
    islands_.clear();
    for (std::size_t i = first; i < last; ++i)
      islands_.push_back({&all[i], steps_alone(all[i]), {}, nullptr});
    {
      const Stopwatch watch(seconds.search);
      for_each([](const Island& island) { return island.alone; },
               [&](Island& island) {
                 island.group = collect_with_statics(sim_, *island.pairs, initial_, state_);
                 if (!island.group.list.empty()) return;
                 for (const ContactSearch& of : island.group.searches) forget(*of.memory);
               });
    }
    std::erase_if(islands_, [](const Island& island) { return island.group.list.empty(); });
    {
      const Stopwatch watch(seconds.response);
      for (Island& island : islands_) get_ready(island);
    }
    const Stopwatch watch(seconds.contact);
    for_each(
        [](const Island& island) {
          return island.alone && island.group.list.points.size() <= many_points;
        },
        [&](Island& island) { push(island); });
  }

  bool steps_alone(const std::vector<Index>& pairs) const {
    return std::all_of(pairs.begin(), pairs.end(), [&](Index p) {
      const ContactPair& pair = sim_.pairs[p];
      if (pair.enforcement != Enforcement::impulse || pair.joint >= 0) return false;
      return body(pair.slave->body).facts().steps_alone &&
             body(pair.master->body).facts().steps_alone;
    });
  }
  const Body& body(Index contact) const { return *sim_.bodies[sim_.contact_nodes[contact].body]; }

  // Computes data shared by bodies, in one thread.
  void get_ready(Island& island) {
    const bool is_new = renew_springs(sim_, island.group, state_);
    prepare(sim_, h_, island.group, state_);
    const Index p = island.pairs->front();
    if (sim_.pairs[p].enforcement != Enforcement::nodal) island.memory = &state_.islands[p];
    // W is of other springs; pairs that come and go change the memory of an island
    if (!is_new) return;
    for (auto& [pair, memory] : state_.islands) memory.h = 0;
  }

  void push(Island& island) {
    ContactGroup& group = island.group;
    EnforcementResult result = enforce(sim_, group, h_, state_, island.memory, outcome_);
    if (is_newmark(sim_, group)) settle(sim_, group, island.memory, state_, result);
    book(sim_, group, result, state_, outcome_);
    book_walls(sim_, group, result, h_, state_);
    remember(sim_, group, result, h_, state_);
    if (island.memory != nullptr) find_lasting_forces(sim_, group, result, h_, state_);
  }

  // work() for islands with `shared`, by several threads, then for the others.
  template <typename Shared, typename Work>
  void for_each(const Shared& shared, const Work& work) {
    order_.clear();
    for (Island& island : islands_)
      if (shared(island)) order_.push_back(&island);
    share_among_threads(static_cast<Index>(order_.size()), n_threads(),
                        [&](Index i) { work(*order_[i]); });
    for (Island& island : islands_)
      if (!shared(island)) work(island);
  }

  Simulation& sim_;
  const double h_;
  const bool initial_;
  ContactState& state_;
  ContactOutcome& outcome_;
  std::vector<Island> islands_;
  std::vector<Island*> order_;
};

// Normal motion of the points in the step, as predicted so far.
Vector normal_motions(const ContactGroup& group, const ContactState& state) {
  Vector motion(static_cast<Index>(group.list.points.size()));
  for (Index i = 0; i < motion.size(); ++i) {
    const ContactPoint& point = group.list.points[i];
    motion[i] = point.normal().dot(relative_motion(group.list, point, state.bodies));
  }
  return motion;
}

// A penalty pair with applied impulses.
struct PushedSprings {
  ContactGroup group;
  EnforcementResult result;  // gaps without impulses of the step
  Points slip;               // of elastic_slips()
  Vector motion;             // normal motion of the points included in the gaps
};

// A pressure acts on the area that both surfaces share. Nodes beside an edge of the other would
// count with all of theirs.
void share_areas(const ContactPair& pair, const ContactState& state, ContactGroup& group) {
  for (const ContactSearch& of : group.searches) {
    const bool is_back = of.memory == &pair.seen().back;
    const bool at_nodes =
        is_back ? pair.formulation == Formulation::two_way : of.memory == &pair.seen().memory;
    if (pair.wall || of.first == of.last || !at_nodes) continue;
    const ContactSurface &slave = is_back ? *pair.master : *pair.slave,
                         &master = is_back ? *pair.slave : *pair.master;
    std::vector<char> has_point(slave.nodes.size(), 0);
    for (auto i = of.first; i < of.last; ++i) has_point[group.list.points[i].slot] = 1;
    const Points shared = shared_areas(slave, state.bodies[slave.body].start, master,
                                       state.bodies[master.body].start, has_point);
    for (auto i = of.first; i < of.last; ++i) {
      ContactPoint& point = group.list.points[i];
      point.area = std::max(0.0, -shared.row(point.slot).dot(point.normal()));
    }
  }
}

void refuse_stiffness(const ContactGroup& group, ContactPair& pair) {
  double area = 0;
  for (const ContactPoint& point : group.list.points) area = std::max(area, point.area);
  const double most = pair.state().penalty.most_stiffness / (pair.penalty.share * area);
  throw RunError(
      pair.source->text() + ": contact " + pair.name +
      format_text(": its 'stiffness' is too high for the step: found %.3g, and with the %zu points "
                  "that are near now at most %.3g is stable: take a smaller time.step, or "
                  "'impulse' for hard surfaces",
                  pair.penalty.pressure.steepest(), group.list.points.size(), most));
}

void push_springs(Simulation& sim, Index p, double h, bool initial, ContactState& state,
                  ContactOutcome& outcome, StepSeconds& seconds,
                  std::vector<PushedSprings>& pushed) {
  PushedSprings springs{start_group(sim, {p}, h, initial, state, seconds), {}, {}, {}};
  const ContactGroup& group = springs.group;
  if (group.list.empty()) return;
  const Stopwatch watch(seconds.contact);
  ContactPair& pair = sim.pairs[p];
  if (!pair.penalty.pressure.empty()) share_areas(pair, state, springs.group);
  springs.slip = elastic_slips(group);
  springs.motion = normal_motions(group, state);
  springs.result = enforce_penalty(group.list, group.laws, h, largest_frequency(sim, group) * h,
                                   pair.penalty, state.bodies, pair.state().penalty, springs.slip);
  if (!pair.penalty.pressure.empty() && std::isinf(springs.result.residual) &&
      std::isfinite(pair.state().penalty.most_stiffness))
    refuse_stiffness(group, pair);
  deliver(sim, group, false, h, state, outcome);
  book(sim, group, springs.result, state, outcome);
  book_walls(sim, group, springs.result, h, state);
  pushed.push_back(std::move(springs));
}

// Updates gaps when all impulses of the step are known. Nodes that impulses elsewhere press into a
// face then count as touching. Otherwise the next step would find them behind the face and keep
// their penetration, which would grow with every step.
void finish_springs(Simulation& sim, double h, const ContactState& state, PushedSprings& springs) {
  springs.result.gap.col(0) += normal_motions(springs.group, state) - springs.motion;
  stretch_springs(sim, springs.group, springs.result, springs.slip, state);
  remember(sim, springs.group, springs.result, h, state);
}

}  // namespace

void ContactOutcome::start(const Simulation& simulation) {
  touched.assign(simulation.contact_nodes.size(), 0);
  near.assign(simulation.pairs.size(), 0);
  has_met = near;
  active.assign(simulation.pairs.size(), 0);
  // pairs named in the scene are recorded even if they never meet
  for (std::size_t p = 0; p < simulation.pairs.size(); ++p) {
    if (simulation.pairs[p].of_all) continue;
    has_met[p] = 1;
    met.push_back(static_cast<Index>(p));
  }
}

void ContactOutcome::next_step() {
  std::fill(touched.begin(), touched.end(), 0);
  for (const Index p : searched) {
    near[p] = 0;
    active[p] = 0;
  }
  searched.clear();
}

void contact_step(Simulation& sim, const std::vector<Index>& due, double h, bool initial,
                  ContactState& state, ContactOutcome& outcome, StepSeconds& seconds) {
  outcome.next_step();
  outcome.searched = due;
  // Penalty depends on the start only. Impulses include its effect on the end. Nodal corrects the
  // remaining gaps.
  std::vector<PushedSprings> pushed;
  for (const Index p : due)
    if (sim.pairs[p].enforcement == Enforcement::penalty)
      push_springs(sim, p, h, initial, state, outcome, seconds, pushed);
  for (const Enforcement enforcement : {Enforcement::impulse, Enforcement::nodal})
    Islands(sim, h, initial, state, outcome).solve(islands(sim, due, enforcement), seconds);
  for (PushedSprings& springs : pushed) finish_springs(sim, h, state, springs);
  for (std::size_t b = 0; b < state.bodies.size(); ++b)
    if (outcome.touched[b] == 0) state.bodies[b].still.resize(0);
  book_friction(sim, h, false, state);
  hand_lasting_forces(sim, h, state, outcome);
  for (const Index p : due) {
    if (!sim.pairs[p].has_state()) continue;
    PairState& now = sim.pairs[p].state();
    const bool was_active = std::exchange(now.is_active, outcome.active[p] > 0);
    if (!now.is_active) continue;
    now.step.h = h;
    now.step.begins = !was_active;
    add_step(now.step, now.kept);
  }
  for (const Index p : due) {
    if (!outcome.near[p] || outcome.has_met[p]) continue;
    outcome.has_met[p] = 1;
    outcome.met.push_back(p);
  }
}

}  // namespace cbr

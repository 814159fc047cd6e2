// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/contact/pair_schedule.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace cbr {
namespace {

constexpr Index longest_wait = 8;
constexpr double many_steps = 8;       // steps apart from which a better bound does not pay
constexpr Index of_walls = -1;         // body of a partner that is a wall
constexpr double closed_share = 2e-6;  // of a face: more than what remember() takes for closed
// Steps before the first with possible contact: velocities before it are then known.
constexpr double steps_ahead = 1;

// Largest reach of a search, relative to the largest face. More at the start, where surfaces may
// overlap by a face.
double face_share(Index step) { return step == 0 ? 1.5 : 0.5; }

// Lower bound of the time of contact: until then the surfaces are separate on some axis.
double time_apart(const MotionBound& a, const MotionBound& b, const Vector3& margin) {
  double apart = 0;
  for (int c = 0; c < 3; ++c) {
    const double growth = a.growth[c] + b.growth[c],
                 acceleration = a.acceleration[c] + b.acceleration[c];
    const double above = b.lower[c] - a.upper[c] - margin[c],
                 below = a.lower[c] - b.upper[c] - margin[c];
    apart = std::max(apart,
                     first_root(above, b.lower_speed[c] - a.upper_speed[c], growth, acceleration));
    apart = std::max(apart,
                     first_root(below, a.lower_speed[c] - b.upper_speed[c], growth, acceleration));
  }
  return apart;
}

MotionBound standing(const Points& x) {
  MotionBound bound;
  bound.lower = x.colwise().minCoeff().transpose();
  bound.upper = x.colwise().maxCoeff().transpose();
  bound.lower_speed = bound.upper_speed = bound.growth = bound.acceleration = Vector3::Zero();
  return bound;
}

}  // namespace

PairSchedule::PairSchedule(Simulation& simulation, bool jumps, const std::vector<char>& resting,
                           std::function<void(Index, Index)> bring, WorkCounts& counts)
    : sim_(simulation),
      jumps_(jumps),
      resting_(resting),
      bring_(std::move(bring)),
      counts_(counts) {
  const std::size_t n = sim_.pairs.size();
  known_.resize(sim_.contact_nodes.size());
  partners_.resize(sim_.contact_nodes.size());
  stamp_.assign(n, 0);
  taken_at_.assign(n, -1);
  wait_.assign(n, 1);
  backoff_.assign(n, 1);
  kind_.reserve(n);
  largest_face_.reserve(n);
  std::unordered_map<const ContactSurface*, double> largest;  // of all pairs that share a surface
  const auto largest_face = [&](const ContactSurface& surface) {
    const auto [at, is_new] = largest.try_emplace(&surface, 0);
    return is_new ? at->second = surface.sizes.maxCoeff() : at->second;
  };
  for (std::size_t p = 0; p < n; ++p) {
    const ContactPair& pair = sim_.pairs[p];
    kind_.push_back(kind_of(pair));
    largest_face_.push_back(
        pair.wall ? 0 : std::max(largest_face(*pair.slave), largest_face(*pair.master)));
    if (kind_.back() == Kind::always) always_.push_back(static_cast<Index>(p));
    if (kind_.back() != Kind::timed) continue;
    const Index slave = pair.slave->body, master = pair.wall ? of_walls : pair.master->body;
    partners_[slave].push_back({master, static_cast<Index>(p)});
    if (pair.wall) continue;
    partners_[master].push_back({slave, static_cast<Index>(p)});
    face_of_any_ = std::max(face_of_any_, largest_face_.back());
    adjust_of_any_ = std::max(adjust_of_any_, pair.closed_reach());
  }
  for (std::size_t c = 0; c < partners_.size(); ++c) {
    std::sort(partners_[c].begin(), partners_[c].end());
    if (!partners_[c].empty() && partners_[c].back().body != of_walls)
      meeting_.push_back(static_cast<Index>(c));
  }
}

// Tied surfaces without ties are pairs of `all` that are apart.
PairSchedule::Kind PairSchedule::kind_of(const ContactPair& pair) const {
  if (pair.law.law == ContactLaw::tied)
    return pair.seen().ties.empty() ? Kind::never : Kind::always;
  const bool itself = !pair.wall && pair.slave->body == pair.master->body;
  return jumps_ && !itself ? Kind::timed : Kind::always;
}

bool PairSchedule::is_free(Index p) const {
  return !known_[sim_.pairs[p].slave->body].loose && !known_[sim_.pairs[p].master->body].loose;
}

// Whether jumps may begin and end within the reach of a search, down to contact. The sign of its
// distance says on which side of a wall a node is. Faces need the margin of steps_apart(). Large
// rotation is exact to the order of its steps alone. A pair of `contact: all` has results once it
// is near.
bool PairSchedule::may_jump_near(Index p) const {
  const ContactPair& pair = sim_.pairs[p];
  if (!pair.wall || (pair.of_all && !pair.seen().has_touched)) return false;
  if (sim_.bodies[sim_.contact_nodes[pair.slave->body].body]->turns()) return false;
  const PairMemory& memory = pair.seen().memory;  // overlaps open step by step
  return memory.offset.size() == 0 || memory.offset.minCoeff() >= memory.rest;
}

void PairSchedule::start() {
  for (std::size_t c = 0; c < known_.size(); ++c) {
    const Index body = sim_.contact_nodes[c].body;
    known_[c].can_settle = sim_.bodies[body]->is_exact();
    if (partners_[c].empty()) continue;
    if (known_[c].can_settle || resting_[body]) {
      form(static_cast<Index>(c), 0, false);
    } else {
      loosen(static_cast<Index>(c));
    }
  }
  for (Index p = 0; p < static_cast<Index>(kind_.size()); ++p)
    if (kind_[p] == Kind::timed && is_free(p)) first_look(p);
}

// Penalty springs are fitted to the points within reach at the first step. Their existence must not
// depend on boxes, which depend on the axes.
void PairSchedule::first_look(Index p) {
  if (sim_.pairs[p].enforcement == Enforcement::penalty) return enqueue(p, 0);
  schedule(p, 0);
}

Index PairSchedule::next(Index step) const {
  if (!always_.empty() || !loose_.empty()) return step;
  return queue_.empty() ? plan().n_steps() + 1 : std::max(step, queue_.front().step);
}

void PairSchedule::enqueue(Index pair, Index step) {
  ++stamp_[pair];
  if (step > plan().n_steps()) return;
  queue_.push_back({step, pair, stamp_[pair]});
  std::push_heap(queue_.begin(), queue_.end());
}

void PairSchedule::take(Index pair, Index step, std::vector<Index>& pairs) {
  if (taken_at_[pair] == step) return;
  if (sim_.pairs[pair].has_state() && taken_at_[pair] >= 0)
    pass_without_force(step - taken_at_[pair] - 1, sim_.pairs[pair].state().memory);
  taken_at_[pair] = step;
  ++stamp_[pair];
  taken_.push_back(pair);
  pairs.push_back(pair);
}

void PairSchedule::due(Index step, std::vector<Index>& pairs) {
  pairs = always_;
  taken_.clear();
  while (!queue_.empty() && queue_.front().step <= step) {
    const Entry entry = queue_.front();
    std::pop_heap(queue_.begin(), queue_.end());
    queue_.pop_back();
    if (entry.stamp == stamp_[entry.pair]) take(entry.pair, step, pairs);
  }
  for (const Index c : loose_)
    for (auto partner = partners_[c].begin();
         partner != partners_[c].end() && partner->body == of_walls; ++partner)
      take(partner->pair, step, pairs);
  std::sort(pairs.begin(), pairs.end());
}

bool PairSchedule::is_far(Index p, bool initial, const ContactState& state) const {
  const ContactPair& pair = sim_.pairs[p];
  if (pair.wall || kind_[p] == Kind::always) return false;
  const ContactBody &a = state.bodies[pair.slave->body], &b = state.bodies[pair.master->body];
  // Above every reach of a search: contact_reach() for faces of either side, with relative motions
  const Vector3 reach =
      Vector3::Constant(face_share(initial ? 0 : 1) * largest_face_[p] +
                        2 * (a.longest_way + b.longest_way) + pair.closed_reach());
  return !Box{a.swept.lower - reach, a.swept.upper + reach}.meets(b.swept);
}

const Box& PairSchedule::box_of(Index c, Index step) {
  Known& known = known_[c];
  if (known.box_step == step) return known.box;
  const MotionBound start = bound_at(c, step), end = later(start, plan().step_length(step));
  known.box = {start.lower.cwiseMin(end.lower), start.upper.cwiseMax(end.upper)};
  known.box_step = step;
  return known.box;
}

// Longest path of a node in the step. For a free body it bounds its box, as in is_far().
double PairSchedule::longest_way(Index c, Index step, const ContactState& state) const {
  if (known_[c].loose) return state.bodies[c].longest_way;
  const MotionBound& bound = known_[c].bound;
  const double since = plan().time(step + 1) - plan().time(std::max<Index>(known_[c].step, 0));
  const Vector3 speed =
      bound.lower_speed.cwiseAbs().cwiseMax(bound.upper_speed.cwiseAbs()) + bound.growth;
  return (speed + bound.acceleration * since).norm() * plan().step_length(step);
}

// Boxes of loose bodies against those of all bodies, each grown by its part of the largest reach of
// a pair. Candidates are then compared pair by pair.
void PairSchedule::find_near(Index step, const ContactState& state) {
  const auto grown = [](const Box& box, double by) {
    return Box{box.lower.array() - by, box.upper.array() + by};
  };
  const double reach = face_share(step) * face_of_any_ + adjust_of_any_;
  targets_.clear();
  queries_.clear();
  ways_.clear();
  for (const Index d : meeting_) {
    ways_.push_back(longest_way(d, step, state));
    targets_.push_back(
        grown(known_[d].loose ? state.bodies[d].swept : box_of(d, step), 2 * ways_.back()));
  }
  for (const Index c : loose_)
    queries_.push_back(grown(state.bodies[c].swept, reach + 2 * state.bodies[c].longest_way));
  find_candidates(queries_, targets_, grid_);
}

void PairSchedule::add_meetings(Index step, const ContactState& state, std::vector<Index>& pairs) {
  if (loose_.empty()) return;
  const std::size_t before = pairs.size();
  find_near(step, state);
  const CandidateList& near = grid_.candidates;
  for (std::size_t i = 0; i < loose_.size(); ++i) {
    const Index c = loose_[i];
    const ContactBody& body = state.bodies[c];
    for (Index k = near.first[i]; k < near.first[i + 1]; ++k) {
      const Index d = meeting_[near.target[k]];
      const double way = body.longest_way + ways_[near.target[k]];
      const Box& other = known_[d].loose ? state.bodies[d].swept : box_of(d, step);
      for (auto partner = std::lower_bound(partners_[c].begin(), partners_[c].end(), Partner{d, 0});
           partner != partners_[c].end() && partner->body == d; ++partner) {
        const Index p = partner->pair;
        if (taken_at_[p] == step) continue;
        ++counts_.pair_looks;
        const Vector3 reach = Vector3::Constant(face_share(step) * largest_face_[p] + 2 * way +
                                                sim_.pairs[p].closed_reach());
        if (Box{body.swept.lower - reach, body.swept.upper + reach}.meets(other))
          take(p, step, pairs);
      }
    }
  }
  if (pairs.size() > before) std::sort(pairs.begin(), pairs.end());
}

// A quick bound is less sharp, and suffices while bodies are distant.
void PairSchedule::form(Index c, Index step, bool fine) {
  Known& known = known_[c];
  const ContactNodes& nodes = sim_.contact_nodes[c];
  if (resting_[nodes.body]) {
    Points x;
    if (known.step < 0) {
      sim_.bodies[nodes.body]->positions(nodes.set, x);
      known.bound = standing(x);
    }
    known.fine = true;
  } else {
    bring_(nodes.body, step);
    known.bound = sim_.bodies[nodes.body]->motion_bound(nodes.set, !fine);
    known.fine = fine;
    ++counts_.bounds;
  }
  known.step = step;
  known.box_step = -1;
}

MotionBound PairSchedule::bound_at(Index c, Index step) const {
  const Known& known = known_[c];
  return known.step == step ? known.bound
                            : later(known.bound, plan().time(step) - plan().time(known.step));
}

// For a moving wall: the bound relative to it, with its largest speed added.
MotionBound PairSchedule::seen_from_wall(Index p, MotionBound bound, Index step) const {
  for (const MovingWall& moving : sim_.moving_walls) {
    if (moving.wall != sim_.pairs[p].wall) continue;
    const Vector3 shift = moving.motion.displacement(plan().time(step)),
                  speed = moving.motion.largest_speed();
    bound.lower -= shift;
    bound.upper -= shift;
    bound.lower_speed -= speed;
    bound.upper_speed += speed;
  }
  return bound;
}

double PairSchedule::steps_apart(Index p, Index step) const {
  const ContactPair& pair = sim_.pairs[p];
  // Initially surfaces may overlap by a face, in which case flat ones seem apart. Later by the
  // recorded depths, or nodes are found late. Adjusted gaps are closed at a distance
  const PairState& state = pair.seen();
  double overlap = 0;
  for (const PairMemory* of : {&state.memory, &state.back, &state.edges})
    overlap = std::max({overlap, of->initial_overlap, of->depth});
  const double margin =
      (step == 0
           ? face_share(0) * largest_face_[p]
           : sim_.detection.late_depth * std::max(pair.master->size, pair.slave->size) + overlap) +
      pair.closed_reach();
  const MotionBound slave = bound_at(pair.slave->body, step);
  if (step > 0 && may_jump_near(p)) {
    const double closed = pair.closed_reach() + closed_share * pair.slave->size;
    const double apart = pair.wall->time_apart(seen_from_wall(p, slave, step), closed);
    return std::max(0.0, std::floor(apart / plan().h) - steps_ahead);
  }
  if (pair.wall)
    return std::floor(pair.wall->time_apart(seen_from_wall(p, slave, step), margin) / plan().h);
  // Nodes of both sides may be constrained beyond the edges of faces
  const Vector3 beside =
      sim_.detection.overhang() * pair.master->extent.cwiseMax(pair.slave->extent);
  const double apart =
      time_apart(slave, bound_at(pair.master->body, step), beside.array() + margin);
  return std::floor(apart / plan().h);
}

// Schedules the next check of a pair of free bodies. A bound is expensive compared with a step.
void PairSchedule::schedule(Index p, Index step) {
  if (step > 0 && --wait_[p] > 0) return enqueue(p, step);
  ++counts_.pair_looks;
  const Index bodies[2] = {sim_.pairs[p].slave->body, sim_.pairs[p].master->body};
  double apart = steps_apart(p, step);
  for (const bool fine : {false, true}) {
    if (apart >= many_steps) break;
    bool formed = false;
    for (const Index c : bodies) {
      if (resting_[sim_.contact_nodes[c].body] ||
          (known_[c].step == step && (known_[c].fine || !fine)))
        continue;
      form(c, step, fine);
      formed = true;
    }
    if (formed) apart = steps_apart(p, step);
  }
  backoff_[p] = apart >= 1 ? 1 : std::min(2 * backoff_[p], longest_wait);
  wait_[p] = backoff_[p];
  enqueue(p, step + static_cast<Index>(std::min(apart, static_cast<double>(plan().n_steps() + 1))));
}

void PairSchedule::loosen(Index c) {
  Known& known = known_[c];
  if (known.loose || partners_[c].empty()) return;
  known.loose = true;
  known.step = -1;
  loose_.push_back(c);
  // Its bound is no longer valid
  for (const Partner& partner : partners_[c]) ++stamp_[partner.pair];
}

void PairSchedule::update(Index step, const ContactOutcome& outcome) {
  for (const Index p : outcome.searched) {
    const ContactPair& pair = sim_.pairs[p];
    for (const Index c : {pair.slave->body, pair.master->body}) {
      if (outcome.touched[c]) loosen(c);
      if (outcome.touched[c] || (outcome.near[p] && !may_jump_near(p))) known_[c].busy_at = step;
    }
  }
  settled_.clear();
  std::erase_if(loose_, [&](Index c) {
    Known& known = known_[c];
    const bool settles = known.can_settle && known.busy_at != step;
    if (settles) {
      known.loose = false;
      settled_.push_back(c);
    }
    return settles;
  });
  for (const Index c : settled_) form(c, step, false);
  for (const Index p : taken_) {
    if (outcome.near[p] && !(is_free(p) && may_jump_near(p))) {
      wait_[p] = backoff_[p] = 1;
      enqueue(p, step);
    } else if (is_free(p)) {
      schedule(p, step);
    }
  }
  for (const Index c : settled_)
    for (const Partner& partner : partners_[c])
      if (is_free(partner.pair) && taken_at_[partner.pair] != step - 1)
        schedule(partner.pair, step);
  taken_.clear();
}

}  // namespace cbr

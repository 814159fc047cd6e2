// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/run/contact/contact_group.hpp"

namespace cbr {
namespace {

// Tolerances of an iteration at the end of a load step: change relative to the energy norm of the
// displacements, and to displacements without strain. `enough` applies after `patience` iterations,
// if round-off or a node at the edge of a face prevents further convergence.
constexpr double aim = 1e-8, enough = 1e-5;
constexpr Index patience = 20;
// Iterations that search anew from the start of the load step. Later ones reuse a search:
// projections that alternate between facets would change normals, and forces, without end.
constexpr Index new_searches = 10;
// Relative to the largest change in a load step: round-off of displacements without strain.
constexpr double nothing = 1e-12;
// Relative to positions: smaller motions are round-off.
constexpr double round_off = 1e-14;
// The same after `patience` iterations, for bodies that a link moves without a force.
constexpr double still = 1e-12;
// Relative to the smallest motion worth a search: allowed drift of unconstrained motions.
constexpr double drift = 1e-9;
// Relative to the acting forces: largest imbalance of a floating body.
constexpr double balanced = 1e-10;
// Motion of an unconstrained body before a new search, relative to the face; it doubles each time.
constexpr double first_share = 0.3;
// Motion in one load step that shows an unconstrained body, relative to its size.
constexpr double lost = 10;
// The last load step before a motion is repeated until it moves less, relative to positions. A
// point that slides in a load step keeps the place on its face at which it began, and the motion
// that follows would not be in equilibrium.
constexpr double at_rest = 1e-11;
constexpr int most_repeats = 5;

double largest(const Vector& x) { return x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0; }

// Ends the terms of every tie with that of a bolt; without one takes it away.
void end_terms(ContactList& ties, std::optional<Index> bolt) {
  ContactList list;
  for (ContactPoint point : ties.points) {
    const auto first = ties.terms.begin() + point.first_term;
    point.first_term = static_cast<Index>(list.terms.size());
    list.terms.insert(list.terms.end(), first, first + point.n_terms - (bolt ? 0 : 1));
    if (bolt) list.terms.push_back({*bolt, 0, -1});
    point.n_terms += bolt ? 1 : -1;
    list.points.push_back(point);
  }
  ties = std::move(list);
}

}  // namespace

double extent_of(const Body& body) {
  const Points& X = body.reference_positions();
  const double extent = (X.colwise().maxCoeff() - X.colwise().minCoeff()).norm();
  // A body with a single point: its distance from the centre of mass
  return extent > 0 ? extent : (body.state().center_of_mass - X.row(0).transpose()).norm();
}

Equilibrium::Equilibrium(Simulation& simulation, ContactState& state, ContactOutcome& outcome)
    : sim_(simulation),
      state_(state),
      outcome_(outcome),
      pairs_(simulation.pairs.size()),
      known_(simulation.pairs.size()),
      closed_(simulation.pairs.size()) {
  std::iota(pairs_.begin(), pairs_.end(), Index{0});
  for (const auto& body : sim_.bodies) {
    const Points& X = body->reference_positions();
    reach_ = std::max(reach_, X.size() > 0 ? X.cwiseAbs().maxCoeff() : 0.0);
  }
  for (const ContactNodes& nodes : sim_.contact_nodes)
    forces_.push_back(Points::Zero(static_cast<Index>(nodes.nodes.size()), 3));
  moved_ = here_ = forces_;
  is_pushed_.assign(forces_.size(), 0);
}

bool Equilibrium::preload(Index steps, RunResult& result,
                          const std::function<void(Index step)>& on_step) {
  for (const Index p : pairs_)
    if (sim_.pairs[p].law.law != ContactLaw::tied) sim_.pairs[p].state().memory.lets_jump = true;
  add_bolts();
  sim_.shift_walls(0, 0);
  n_preload_ = steps;
  StateArchive found;
  for (preload_ = 1; preload_ <= steps; ++preload_) {
    const double share = static_cast<double>(preload_) / static_cast<double>(steps);
    try {
      resolve_overlaps(share);
      double motion = iterate(0, share);
      for (int i = 0; preload_ == steps && i < most_repeats && motion > at_rest * reach_; ++i)
        motion = iterate(0, share);
    } catch (const std::runtime_error& error) {
      if (preload_ == 1) throw;
      result.failure = error.what();
      result.ended_at = 0;
      result.preload_reached = preload_ - 1;
      state_.bodies.resize(forces_.size());  // without bolts
      StateArchive restored(found.words(), "the load step before");
      keep_found(restored);
      break;
    }
    if (on_step) on_step(preload_);
    if (preload_ < steps) found = saved();
  }
  preload_ = 0;
  lock_bolts();
  return result.failure.empty();
}

// Saves the state while the bodies of bolts follow those of contact.
StateArchive Equilibrium::saved() {
  const auto first = state_.bodies.begin() + static_cast<std::ptrdiff_t>(forces_.size());
  std::vector<ContactBody> bolts(std::make_move_iterator(first),
                                 std::make_move_iterator(state_.bodies.end()));
  state_.bodies.erase(first, state_.bodies.end());
  StateArchive archive = StateArchive::saved([this](StateArchive& state) { keep_found(state); });
  std::move(bolts.begin(), bolts.end(), std::back_inserter(state_.bodies));
  return archive;
}

void Equilibrium::keep_found(StateArchive& archive) {
  for (auto& body : sim_.bodies) body->keep_state(archive);
  state_.keep_state(archive, sim_);
  archive(outcome_, *this);
  for (Bolt& bolt : bolts_) archive(bolt.length);
}

void Equilibrium::step(double t) {
  sim_.shift_walls(last_t_, t);
  last_t_ = t;
  iterate(t, 1);
}

double Equilibrium::iterate(double t, double share) {
  outcome_.next_step();
  outcome_.searched = pairs_;
  // Load steps begin without loads: what these do at once is no overlap
  for (std::size_t b = 0; initial_ && b < sim_.bodies.size(); ++b) sim_.bodies[b]->relax(t, 0);
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->positions(nodes.set, state_.bodies[c].start);
  }
  for (const Bolt& bolt : bolts_)
    state_.bodies[bolt.body].start = bolt.length * bolt.normal.transpose();
  keep_known();
  most_way_ = first_way();
  most_change_ = 0;
  moves_.resize(0);
  for (auto& [pair, memory] : memories_) memory.gap = 0;
  slides_.assign(sim_.bodies.size(), {});
  for (std::size_t c = 0; c < here_.size(); ++c) here_[c] = state_.bodies[c].start;
  Change change;
  for (iteration_ = 1;; ++iteration_) {
    start_iteration(t, share);
    locate();
    change = {};
    solve(change);
    double most = 0;
    for (std::size_t b = 0; b < sim_.bodies.size(); ++b) {
      const Settled settled = sim_.bodies[b]->settle();
      change.change += settled.change;
      change.energy += settled.energy;
      if (settled.change <= most) continue;
      most = settled.change;
      change.body = b;
    }
    look_at_nodes(change);
    if (!std::isfinite(change.change + change.energy + change.moved))
      throw RunError("statics: " + load_step() +
                     ": the equilibrium is no longer finite: are loads or units beyond a double's "
                     "reach?");
    note_closed();
    if (is_done(change)) break;
    if (on_iteration) on_iteration(iteration_);
    if (iteration_ < new_searches) recall();
  }
  for (auto& body : sim_.bodies) body->end_load_step();
  book();
  initial_ = false;
  return change.displaced;
}

void Equilibrium::start_iteration(double t, double share) {
  std::vector<FloatingForces> forces;
  for (auto& body : sim_.bodies) {
    body->relax(t, share);
    forces.push_back(body->floating_forces());
  }
  if (first_.empty()) number_floating(forces);
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c)
    if (const ContactNodes& nodes = sim_.contact_nodes[c]; bends(c))
      state_.bodies[c].response = sim_.bodies[nodes.body]->static_response(nodes.set);
  loads_.setZero(first_.back() + static_cast<Index>(bolts_.size()));
  largest_load_ = 0;
  for (std::size_t b = 0; b < forces.size(); ++b) {
    loads_.segment(first_[b], forces[b].sum.size()) = forces[b].sum;
    largest_load_ = std::max(largest_load_, forces[b].largest);
  }
  if (moves_.size() != loads_.size()) moves_.setZero(loads_.size());
  for (std::size_t i = 0; i < bolts_.size(); ++i) {
    Bolt& bolt = bolts_[i];
    const Pretension& pretension = *sim_.pairs[bolt.pair].pretension;
    if (pretension.force) {
      loads_[first_.back() + static_cast<Index>(i)] = share * *pretension.force;
    } else {
      bolt.length = share * *pretension.shortening;
    }
    state_.bodies[bolt.body].end = bolt.length * bolt.normal.transpose();
  }
}

void Equilibrium::number_floating(const std::vector<FloatingForces>& forces) {
  first_.assign(1, 0);
  for (const FloatingForces& of : forces) first_.push_back(first_.back() + of.sum.size());
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    Body& body = *sim_.bodies[nodes.body];
    state_.bodies[c].response = body.static_response(nodes.set);
    floating_.push_back({body.floating_motions(nodes.set), first_[nodes.body]});
  }
  for (std::size_t i = 0; i < bolts_.size(); ++i) {
    const bool floats = sim_.pairs[bolts_[i].pair].pretension->force.has_value();
    floating_.push_back(
        {floats ? Matrix(bolts_[i].normal) : Matrix(3, 0), first_.back() + static_cast<Index>(i)});
  }
}

// Positions of the nodes under the last contact forces. The ends without them are the reference of
// the contact solution.
void Equilibrium::locate() {
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    ContactBody& contact = state_.bodies[c];
    sim_.bodies[nodes.body]->predicted_positions(nodes.set, contact.end);
    moved_[c].setZero();
    if (is_pushed_[c]) contact.response.add_product(forces_[c], moved_[c]);
    contact.end += moved_[c];
    sweep(contact);
  }
}

void Equilibrium::solve(Change& change) {
  solved_.clear();
  left_.setZero(moves_.size());
  for (Points& force : forces_) force.setZero();
  std::fill(is_pushed_.begin(), is_pushed_.end(), 0);
  std::vector<char> is_in_pair(sim_.bodies.size(), 0);
  for (const auto& pairs : islands(sim_, pairs_, Enforcement::impulse)) {
    const std::vector<Index> columns = columns_of(pairs);
    for (std::size_t b = 0; b < is_in_pair.size(); ++b)
      is_in_pair[b] |= std::binary_search(columns.begin(), columns.end(), first_[b]);
    solve_group(pairs, columns, change);
  }
  for (std::size_t b = 0; b < is_in_pair.size(); ++b) {
    const Index first = first_[b], n = first_[b + 1] - first;
    if (!is_in_pair[b] && largest(loads_.segment(first, n)) > balanced * largest_load_)
      refuse_unheld(static_cast<Index>(b), loads_.segment(first, n));
    note_slide(static_cast<Index>(b), left_.segment(first, n));
    if (largest(left_.segment(first, n)) > 0 &&
        largest(moves_.segment(first, n)) > lost * extent_of(*sim_.bodies[b]))
      refuse_unheld(static_cast<Index>(b), left_.segment(first, n));
  }
}

// Columns of the bodies of pairs, and of their bolts; ascending.
std::vector<Index> Equilibrium::columns_of(const std::vector<Index>& pairs) const {
  std::vector<Index> columns;
  const auto add = [&](Index contact) {
    if (contact < 0) return;
    const FloatingNodes& of = floating_[contact];
    for (Index j = 0; j < of.R.cols(); ++j) columns.push_back(of.first + j);
  };
  for (const Index p : pairs) {
    const ContactPair& pair = sim_.pairs[p];
    for (const Index contact : {pair.slave->body, pair.master->body, pair.joint}) add(contact);
    for (const Bolt& bolt : bolts_)
      if (bolt.pair == p) add(bolt.body);
  }
  sort_uniquely(columns);
  return columns;
}

// Motions of the columns that contact must hold (columns x k), orthonormal: all but the rigid ones
// of the pairs' bodies as a whole. Empty: all, as something holds or loads these, or ties span a
// gap. Forces of points that have slid since they were projected have a small moment: by it a free
// assembly turned without end.
Matrix Equilibrium::held_motions(const std::vector<Index>& pairs,
                                 const std::vector<Index>& columns) const {
  // touches: relative to a face; a pretension shortens a bolt
  constexpr double same = 1e-9, touches = 0.1;
  constexpr Index rigid_motions = 6;
  const auto n = static_cast<Index>(columns.size());
  const Matrix all;
  Matrix whole = Matrix::Zero(n, rigid_motions);
  std::vector<Index> contacts;
  for (const Index p : pairs) {
    const ContactPair& pair = sim_.pairs[p];
    if (pair.wall || pair.joint >= 0) return all;
    const Points& offset = pair.seen().tie_offset;
    if (offset.size() > 0 && offset.rowwise().norm().maxCoeff() > touches * pair.slave->size)
      return all;
    contacts.insert(contacts.end(), {pair.slave->body, pair.master->body});
  }
  sort_uniquely(contacts);
  for (const Index c : contacts) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    const Matrix& R = floating_[c].R;
    if (R.cols() != rigid_motions) return all;
    const Points x = sim_.bodies[nodes.body]->reference_positions()(nodes.nodes, Eigen::all);
    Matrix rigid(R.rows(), rigid_motions);
    for (Index i = 0; i < x.rows(); ++i) {
      rigid.block<3, 3>(3 * i, 0).setIdentity();
      for (int d = 0; d < 3; ++d)
        rigid.block<3, 1>(3 * i, 3 + d) = Vector3::Unit(d).cross(Vector3(x.row(i)));
    }
    const PivotedQr factor(R, same);
    if (factor.rank() < rigid_motions) return all;
    const Matrix own = factor.solve(rigid);
    if ((R * own - rigid).norm() > same * rigid.norm()) return all;
    const auto at = std::lower_bound(columns.begin(), columns.end(), floating_[c].first);
    whole.middleRows(at - columns.begin(), rigid_motions) = own;
  }
  const Matrix Q = PivotedQr(whole).Q();
  const Vector loads = Q.leftCols(rigid_motions).transpose() * Vector(loads_(columns));
  if (largest(loads) > balanced * largest_load_) return all;
  return Q.rightCols(n - rigid_motions);
}

// In statics functions are for a number, or for more points than a dense W serves: friction's work
// in a function that slides in part is wrong.
bool Equilibrium::takes_functions(const ContactGroup& group, std::size_t search) const {
  const ContactPair& pair = sim_.pairs[group.searches[search].pair];
  const Index rows = static_cast<Index>(pair.slave->nodes.size()) * n_rows(pair.law.law);
  return pair.keeps_functions || rows > most_rows_of_points;
}

void Equilibrium::solve_group(const std::vector<Index>& pairs, const std::vector<Index>& columns,
                              Change& change) {
  // A load step is as long as many time steps: faces have rotated since the last search
  for (const Index p : pairs)
    if (iteration_ <= new_searches) sim_.pairs[p].state().memory.standing = StandingSearch();
  // Floating motions follow the search, whose reach must cover them
  const bool initial = initial_ && iteration_ <= new_searches;
  Solved solved{collect(sim_, pairs, initial, state_, first_way(), iteration_ >= new_searches), {}};
  ContactGroup& group = solved.group;
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
  }
  std::vector<FunctionsOfSearch> searches = functions_of(sim_, group);
  for (std::size_t s = 0; s < searches.size(); ++s)
    if (!takes_functions(group, s)) searches[s].functions = nullptr;
  // W is of other springs
  if (std::any_of(group.bodies.begin(), group.bodies.end(), [&](Index b) {
        return b < static_cast<Index>(forces_.size()) && bends(static_cast<std::size_t>(b));
      }))
    memories_[pairs.front()] = {.gap = memories_[pairs.front()].gap};
  StaticResult result = enforce_static(
      group.list, group.laws, group.guess, floating_, columns, held_motions(pairs, columns), loads_,
      largest_load_, most_way_, state_.bodies, searches, memories_[pairs.front()]);
  for (const Index b : group.bodies) give(b);
  move(columns, result, change);
  change.residual = std::max(change.residual, result.of_points.residual);
  solved.result = std::move(result.of_points);
  if (group.list.empty()) {
    for (const ContactSearch& of : group.searches) forget(*of.memory);
    return;
  }
  remember(sim_, group, solved.result, 0, state_);
  solved_.push_back(std::move(solved));
}

// Motion of the contact nodes in this iteration, and in this load step.
void Equilibrium::look_at_nodes(Change& change) {
  Points x;
  for (std::size_t c = 0; c < here_.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->positions(nodes.set, x);
    if (x.size() == 0) continue;
    change.moved = std::max(change.moved, (x - here_[c]).cwiseAbs().maxCoeff());
    change.displaced =
        std::max(change.displaced, (x - state_.bodies[c].start).cwiseAbs().maxCoeff());
    here_[c].swap(x);
  }
}

// Passes a contact body's forces to its body.
void Equilibrium::give(Index b) {
  if (b >= static_cast<Index>(sim_.contact_nodes.size())) return;
  ContactBody& contact = state_.bodies[b];
  const ContactNodes& nodes = sim_.contact_nodes[b];
  Body& body = *sim_.bodies[nodes.body];
  forces_[b] = contact.impulses + contact.friction;
  is_pushed_[b] = !forces_[b].isZero(0);
  outcome_.touched[b] |= is_pushed_[b];
  if (is_pushed_[b]) body.add_static_forces(nodes.set, forces_[b]);
}

// Moves floating bodies; notes what is left without balance.
void Equilibrium::move(const std::vector<Index>& columns, const StaticResult& result,
                       Change& change) {
  const bool balances =
      largest(result.left) <= balanced * std::max(largest_load_, result.largest_force);
  change.balances &= balances;
  Vector move = Vector::Zero(moves_.size());
  move(columns) = result.moves;
  if (!balances) left_(columns) = result.left;
  moves_ += move;
  for (std::size_t b = 0; b < sim_.bodies.size(); ++b)
    if (const Index n = first_[b + 1] - first_[b]; n > 0)
      sim_.bodies[b]->float_by(move.segment(first_[b], n));
  for (std::size_t i = 0; i < bolts_.size(); ++i)
    bolts_[i].length += move[first_.back() + static_cast<Index>(i)];
}

bool Equilibrium::is_done(const Change& change) {
  most_change_ = std::max(most_change_, change.change);
  const double scale = change.energy + nothing * most_change_;
  const auto stands = [&](double share) {
    return change.change <= share * share * scale &&
           change.moved <= std::max(share * change.displaced, drift * first_way());
  };
  // Without forces there is no balance but of round-off
  if (iteration_ >= patience && change.moved <= still * reach_) return true;
  if (change.balances && iteration_ > 1) {
    if (stands(aim) || change.moved <= round_off * reach_) return true;
    // No elastic change: unconstrained motions drift by round-off, once they have closed the gaps
    const bool holds = change.residual <= good_residual || iteration_ >= patience;
    if (holds && change.change <= aim * aim * scale && closed_ == closed_before_) return true;
    if (iteration_ >= patience && stands(enough)) return true;
  }
  if (iteration_ >= most_iterations) {
    for (std::size_t b = 0; b < slides_.size(); ++b)
      if (!slides_[b].pairs.empty() && slides_[b].n > first_slides)
        refuse_unheld(static_cast<Index>(b), slides_[b].left);
    refuse_endless(change);
  }
  most_way_ = change.balances ? first_way() : 2 * most_way_;
  return false;
}

double Equilibrium::first_way() const {
  double size = HUGE_VAL;
  for (const Index p : pairs_) {
    const ContactPair& pair = sim_.pairs[p];
    if (pair.law.law == ContactLaw::tied) continue;
    for (const auto& side : {pair.slave, pair.master})
      if (side->size > 0) size = std::min(size, side->size);
  }
  if (std::isfinite(size)) return first_share * size;
  for (const auto& body : sim_.bodies) size = std::min(size, extent_of(*body));
  return size;
}

void Equilibrium::at_pushing_points(const PointTaker& take) const {
  for (const Solved& solved : solved_)
    for (const ContactSearch& of : solved.group.searches)
      for (auto i = of.first; i < of.last; ++i)
        if (solved.result.pushes(static_cast<Index>(i)))
          take(solved, static_cast<std::size_t>(of.pair), i);
}

// Records the points with an impulse, by pair.
void Equilibrium::note_closed() {
  closed_before_.swap(closed_);
  closed_.assign(pairs_.size(), {});
  at_pushing_points([&](const Solved& solved, std::size_t pair, std::size_t i) {
    const ContactList& list = solved.group.list;
    const ContactTerm& term = list.terms[list.points[i].first_term];
    closed_[pair].push_back({term.body, term.node, list.points[i].slot});
  });
  for (auto& points : closed_) std::sort(points.begin(), points.end());
}

std::vector<ContactList> Equilibrium::closed_points() const {
  std::vector<ContactList> closed(pairs_.size());
  at_pushing_points([&](const Solved& solved, std::size_t pair, std::size_t i) {
    const ContactLaw law = solved.group.laws[i].law;
    if (law == ContactLaw::tied) return;
    const ContactList& list = solved.group.list;
    ContactPoint point = list.points[i];
    if (law == ContactLaw::frictionless) point.frame.bottomRows<2>().setZero();
    const auto first = list.terms.begin() + point.first_term;
    point.first_term = static_cast<Index>(closed[pair].terms.size());
    closed[pair].terms.insert(closed[pair].terms.end(), first, first + point.n_terms);
    closed[pair].points.push_back(point);
  });
  return closed;
}

// Books the forces of this load step for the time since the last output.
void Equilibrium::book() {
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    pair.kept.clear();
    pair.step = {};
  }
  book_last_forces_of_walls(sim_);
  for (std::size_t c = 0; c < forces_.size(); ++c) {
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->positions(nodes.set, state_.bodies[c].end);
    state_.impulses_since_output[c] = forces_[c];
    state_.normal_since_output[c].setZero();
    state_.pressure_since_output[c].setZero();
    state_.bodies[c].rubbed = state_.bodies[c].friction;
  }
  book_friction(sim_, 1, true, state_);
  for (const Solved& solved : solved_) {
    cbr::book(sim_, solved.group, solved.result, state_, outcome_);
    book_walls_in_statics(sim_, solved.group, solved.result);
  }
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    pair.is_active = outcome_.active[p] > 0;
    add_step(pair.step, pair.kept);
    if (!outcome_.near[p] || outcome_.has_met[p]) continue;
    outcome_.has_met[p] = 1;
    outcome_.met.push_back(p);
  }
}

void Equilibrium::keep_known() {
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    known_[p].clear();
    for (const PairMemory* memory : {&pair.memory, &pair.back, &pair.edges})
      known_[p].push_back({memory->face, memory->known_face, memory->further_faces, memory->offset,
                           memory->has_points, memory->depth, memory->edges});
  }
}

// Restores search states of the start of the load step, for the next search. Forces stay as the
// first guess of the solution.
void Equilibrium::recall() {
  for (const Index p : pairs_) {
    PairState& pair = sim_.pairs[p].state();
    std::size_t side = 0;
    for (PairMemory* memory : {&pair.memory, &pair.back, &pair.edges}) {
      const Known& known = known_[p][side++];
      renumber(known.edges, *memory);
      if (known.face.size() != memory->face.size()) {  // not searched before this load step
        std::fill(memory->face.begin(), memory->face.end(), -1);
        std::fill(memory->known_face.begin(), memory->known_face.end(), -1);
        std::fill(memory->further_faces.begin(), memory->further_faces.end(), -1);
        memory->offset.setConstant(memory->rest);
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

// Reduces tolerated overlaps, and applies interference, with each load step.
void Equilibrium::resolve_overlaps(double share) {
  const double left = resolved_ < 1 ? (1 - share) / (1 - resolved_) : 0;
  for (const Index p : pairs_) {
    ContactPair& pair = sim_.pairs[p];
    const double interference = std::max(0.0, pair.interference);
    if (!pair.resolves_overlap && interference == 0) continue;
    PairState& state = pair.state();
    for (PairMemory* memory : {&state.memory, &state.back, &state.edges}) {
      if (pair.resolves_overlap) memory->kept_share = 1 - share;
      const double rest = interference > 0 ? share * interference : memory->rest;
      for (double& offset : memory->offset) {
        const double beyond = offset - memory->rest;
        offset = rest + (pair.resolves_overlap && beyond < 0 ? left * beyond : beyond);
      }
      memory->rest_before = std::exchange(memory->rest, rest);
    }
  }
  resolved_ = share;
}

// Adds bolts along the mean outward normal of the slave.
void Equilibrium::add_bolts() {
  for (const Index p : pairs_) {
    ContactPair& pair = sim_.pairs[p];
    if (!pair.pretension) continue;
    Bolt bolt;
    bolt.pair = p;
    bolt.body = static_cast<Index>(state_.bodies.size());
    bolt.normal = pair.slave->area_vectors.colwise().sum().transpose().normalized();
    ContactBody body;
    body.start = body.end = body.impulses = body.friction = Points::Zero(1, 3);
    body.response.set_block(Matrix::Zero(3, 3));
    state_.bodies.push_back(std::move(body));
    end_terms(pair.state().ties, bolt.body);
    bolts_.push_back(bolt);
  }
}

// Keeps the length by ties.
void Equilibrium::lock_bolts() {
  for (const Bolt& bolt : bolts_) {
    ContactPair& pair = sim_.pairs[bolt.pair];
    pair.pretension->length = bolt.length;
    pair.state().tie_offset.rowwise() += bolt.length * bolt.normal.transpose();
    end_terms(pair.state().ties, {});
  }
  state_.bodies.resize(sim_.contact_nodes.size());
  if (!floating_.empty()) floating_.resize(sim_.contact_nodes.size());
  bolts_.clear();
}

void Equilibrium::start_motion(double h) {
  for (auto& body : sim_.bodies) body->start_motion(h, {});
  for (std::size_t c = 0; c < sim_.contact_nodes.size(); ++c) {
    if (forces_[c].isZero(0)) continue;
    state_.bodies[c].lasting = forces_[c];
    const ContactNodes& nodes = sim_.contact_nodes[c];
    sim_.bodies[nodes.body]->expect_forces(nodes.set, forces_[c]);
  }
  for (const Index p : pairs_) {
    const bool is_penalty = sim_.pairs[p].enforcement == Enforcement::penalty;
    PairState& pair = sim_.pairs[p].state();
    for (PairMemory* memory : {&pair.memory, &pair.back, &pair.edges}) {
      memory->lets_jump = is_penalty;
      memory->kept_share = 1;
      memory->rest_before = memory->rest;
      memory->impulse *= h;
      memory->begins_in_equilibrium = true;
    }
    if (sim_.pairs[p].enforcement == Enforcement::impulse &&
        sim_.pairs[p].law.law != ContactLaw::tied && pair.memory.impulse.isZero(0))
      pair.memory.begins_in_equilibrium = false;  // it may strike later
    pair.kept.clear();
    pair.wall_force += pair.wall_friction;
  }
  for (ContactBody& contact : state_.bodies) {
    contact.response_h = 0;
    contact.rubbed_before *= h;
  }
  for (Points& impulses : state_.impulses_since_output) impulses.setZero();
  for (Points& impulses : state_.normal_since_output) impulses.setZero();
  for (Points& pressures : state_.pressure_since_output) pressures.setZero();
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// State of the time loop's parts between steps.
#include "dynamics/contact/laws/keep_state.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/contact/pair_schedule.hpp"
#include "dynamics/run/equilibrium.hpp"
#include "dynamics/run/recorder.hpp"

namespace cbr {
namespace {

// Without ties: a restarted run finds the same ones from the initial positions.
void keep_pair(StateArchive& archive, ContactPair& pair) {
  bool has_state = pair.has_state();
  archive(has_state);
  if (!has_state) return;
  PairState& state = pair.state();
  archive.expect(static_cast<Index>(pair.slave->nodes.size()));
  archive.expect(static_cast<Index>(state.ties.points.size()));
  archive(state.memory, state.back, state.edges, state.penalty);
  if (pair.pretension) archive(state.tie_offset, pair.pretension->length);
  archive(state.penetration, state.residual, state.recent_penetration, state.recent_residual,
          state.friction_change, state.n_fallbacks, state.n_function_steps, state.n_unknowns,
          state.most_unknowns);
  if (pair.wall || pair.driven)
    archive(state.wall_work, state.wall_friction_work, state.wall_force, state.wall_friction);
  archive(state.has_touched, state.is_active, state.kept, state.largest_area);
}

}  // namespace

void ContactState::keep_state(StateArchive& archive, Simulation& sim) {
  archive.expect(static_cast<Index>(sim.pairs.size()));
  archive.expect(static_cast<Index>(sim.contact_nodes.size()));
  for (ContactPair& pair : sim.pairs) keep_pair(archive, pair);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const ContactNodes& nodes = sim.contact_nodes[b];
    ContactBody& contact = bodies[b];
    bool with_velocities = !contact.velocity_response.empty();
    archive(sim.contact_nodes[b].pressure, sim.contact_nodes[b].slip, contact, contact.response_h,
            with_velocities);
    if (!archive.restores()) continue;
    Body& body = *sim.bodies[nodes.body];
    if (contact.response_h > 0) contact.response = body.response(nodes.set, contact.response_h);
    if (with_velocities) contact.velocity_response = body.velocity_response(nodes.set);
  }
  archive(islands, settled, friction_work, impulses_since_output, ahead_since_output,
          normal_since_output, pressure_since_output);
}

void ContactOutcome::keep_state(StateArchive& archive) {
  archive(touched, near, active, searched, met, has_met);
}

void PairSchedule::Known::keep_state(StateArchive& archive) {
  archive(bound, step, fine, loose, can_settle, busy_at, box, box_step);
}

void PairSchedule::Entry::keep_state(StateArchive& archive) { archive(step, pair, stamp); }

void PairSchedule::keep_state(StateArchive& archive) {
  archive.expect(static_cast<Index>(always_.size()));
  archive(known_, stamp_, taken_at_, wait_, backoff_, queue_, taken_, loose_);
}

static void keep_state(StateArchive& archive, Series3& series) { archive(series.values); }

static void keep_state(StateArchive& archive, RunResult::OfMonitor& of) {
  archive(of.mean_position, of.mean_velocity, of.mean_acceleration, of.force, of.rotation);
}

static void keep_state(StateArchive& archive, RunResult::OfReaction& of) {
  archive(of.force, of.moment);
}

static void keep_state(StateArchive& archive, RunResult::OfBody& of) {
  archive(of.center_of_mass, of.momentum, of.angular_momentum, of.reaction, of.kinetic_energy,
          of.strain_energy);
  double turned_at = of.turned_at.value_or(-1);
  archive(of.rotation, turned_at, of.orientation);
  if (turned_at >= 0) of.turned_at = turned_at;
}

static void keep_state(StateArchive& archive, RunResult::OfScan& of) {
  archive(of.worst, of.worst_stress, of.of_elements, of.of_nodes);
}

static void keep_state(StateArchive& archive, RunResult::OfPair& of) { archive(of.series); }

static void keep_state(StateArchive& archive, WorkCounts& work) {
  archive(work.body_steps, work.pair_looks, work.pair_searches, work.bounds);
}

static void keep_state(StateArchive& archive, RunResult& result) {
  archive.expect(static_cast<Index>(result.monitors.size()));
  archive(result.time, result.monitors, result.bodies, result.pairs);
  archive(result.total, result.work_external, result.work_contact, result.work_friction,
          result.work_damping, result.work_numerical, result.active);
  archive(result.steps, result.jumps, result.contact_steps, result.contact_rows, result.work);
  archive(result.largest_rotation);
  archive.expect(static_cast<Index>(result.reactions.size()));
  archive(result.reactions);
  archive.expect(static_cast<Index>(result.watches.size()));
  archive(result.watches, result.scans);
}

void Equilibrium::keep_state(StateArchive& archive) {
  archive(forces_, is_pushed_, initial_, resolved_, last_t_);
}

void Recorder::keep_state(StateArchive& archive) {
  archive(result_, last_, work_, before_, friction_before_);
}

}  // namespace cbr

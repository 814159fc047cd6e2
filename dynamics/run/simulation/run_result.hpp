// SPDX-License-Identifier: GPL-3.0-or-later
// What a run has recorded of a Simulation, and what it has cost.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Rows of three, one per output time.
struct Series3 {
  std::vector<double> values;
  void add(const Vector3& v) { values.insert(values.end(), v.data(), v.data() + 3); }
};

// What a run has done, whatever the machine: bodies predicted and accepted; comparisons that tell
// whether a pair is worth a search; searches of a pair in a step; motion bounds formed.
struct WorkCounts {
  Index body_steps = 0, pair_looks = 0, pair_searches = 0, bounds = 0;
};

// Wall time of the parts of the steps.
struct StepSeconds {
  double bodies = 0;  // predicted, positions of their contact nodes, accepted
  double search = 0;  // for constraints of contact
  // of the bodies to impulses on their contact nodes: asked when a step's length is new
  double response = 0;
  double contact = 0;  // its matrix, impulses, and what they do to the bodies
  double output = 0;
};

// rad: 5 degrees. Bodies are linear: beyond it their strains are off by a share of it, and a
// warning says so.
constexpr double small_rotation = 0.08726646259971647;

struct RunResult {
  std::vector<double> time;
  struct OfMonitor {
    // acceleration: change of the mean velocity since the last output over that time; force:
    // contact impulses likewise
    Series3 mean_position, mean_velocity, mean_acceleration, force;
    Series3 rotation = {};  // of a point
  };
  struct OfBody {
    Series3 center_of_mass, momentum, angular_momentum;
    Series3 reaction;  // force of all supports on a body that has some, mean since the last output
    std::vector<double> kinetic_energy, strain_energy;
    // n x 4, w x y z since the start; empty: the body is linear
    std::vector<double> orientation;
    double rotation = 0;                   // rad, the largest at an output
    std::optional<double> turned_at = {};  // the first output at which it was above small_rotation
  };
  // Of a pair that `contact: all` stands for and that has never come near: empty.
  struct OfPair {
    std::vector<double> active, penetration, residual;  // at the output; largest since the last one
    std::vector<double> area;                           // in contact at the output
    // on the first-named surface, mean since the last output; where, or 0 without a force
    Series3 force, center_of_pressure;
  };
  // Extremes over the outputs: von Mises stress and when it was, the largest and the smallest
  // principal stress   (m x 4)
  struct OfScan {
    // outputs x n_worst, places in element_ids, the largest first
    std::vector<Index> worst;
    std::vector<double> worst_stress;  // von Mises
    Matrix of_elements, of_nodes;
  };
  struct OfReaction {
    Series3 force, moment;
  };
  std::vector<OfMonitor> monitors;
  std::vector<OfReaction> reactions;
  std::vector<std::vector<double>> watches;  // per watch: outputs x 6 m
  std::vector<OfScan> scans;
  std::vector<OfBody> bodies;
  std::vector<OfPair> pairs;
  std::vector<double> total, work_external, work_contact, work_friction, work_damping,
      work_numerical, active;
  // body steps are counted once for all bodies; a jump skips over steps without contact
  Index steps = 0, jumps = 0;
  Index contact_steps = 0;  // steps with a constraint of contact
  double contact_rows = 0;  // constraints with an impulse, summed over the steps
  // largest share of all energy at an output that was in modes of scaled mass
  double scaled_energy_share = 0;
  WorkCounts work;
  StepSeconds seconds;          // of this part of the run, when it was restarted
  double largest_rotation = 0;  // rad
  // of the planned steps, those that the run has come to the end of
  Index reached = 0;
  // the time of the step after which the run was ended; none: it has come to its end
  std::optional<double> ended_at;
  std::string failure = {};  // why no load step came after that; empty: it was asked to end
  // The load step before the time 0 that the only output shows, where the next one has failed.
  std::optional<Index> preload_reached;
  // The body of RunOptions::turn_limit that has ended it, and how far it has turned then, rad.
  struct Turned {
    Index body = 0;
    double rotation = 0, t = 0;
  };
  std::optional<Turned> turned;
};

}  // namespace cbr

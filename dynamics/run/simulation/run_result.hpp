// SPDX-License-Identifier: GPL-3.0-or-later
// Recorded results of a Simulation, and the cost of the run.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/types.hpp"

namespace cbr {

// Rows of three values, one per output time.
struct Series3 {
  std::vector<double> values;
  void add(const Vector3& v) { values.insert(values.end(), v.data(), v.data() + 3); }
};

// Machine-independent work of a run: bodies predicted and accepted; distance checks of pairs;
// searches of pairs; motion bounds formed.
struct WorkCounts {
  Index body_steps = 0, pair_looks = 0, pair_searches = 0, bounds = 0;
};

// Wall time of the parts of the steps.
struct StepSeconds {
  double bodies = 0;  // prediction, positions of contact nodes, acceptance
  double search = 0;  // for contact points
  // responses to impulses on contact nodes, computed when the step length changes
  double response = 0;
  double contact = 0;  // response matrix, impulses, and their effect on the bodies
  double output = 0;
};

// rad: 5 degrees. Beyond it strains of linear bodies are wrong by a percentage, and a warning is
// given.
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
    Series3 reaction;  // force of all supports on a constrained body, mean since the last output
    std::vector<double> kinetic_energy, strain_energy;
    // n x 4, w x y z since the start; empty: the body is linear
    std::vector<double> orientation;
    double rotation = 0;                   // rad, largest at an output
    std::optional<double> turned_at = {};  // first output above small_rotation
  };
  // Empty for a pair of `contact: all` that has never been near.
  struct OfPair {
    std::vector<Series3> series;  // of pair_outputs(): so many numbers of each output time
    bool empty() const { return series.empty(); }
    const Series3& operator[](std::string_view name) const;
  };
  // Extremes over the outputs: von Mises stress and its time, largest and smallest principal stress
  // (m x 4)
  struct OfScan {
    // outputs x n_worst, indices in element_ids, largest first
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
  // body steps are counted once for all bodies; a jump covers several steps without contact
  Index steps = 0, jumps = 0;
  Index contact_steps = 0;  // steps with a constraint of contact
  double contact_rows = 0;  // constraints with an impulse, summed over the steps
  WorkCounts work;
  StepSeconds seconds;          // of the current part of a restarted run
  double largest_rotation = 0;  // rad
  // number of planned steps completed
  Index reached = 0;
  // time at which the run was ended early; none: it is complete
  std::optional<double> ended_at;
  std::string failure = {};  // reason why the next load step failed; empty: ended on request
  // The load step before time 0 in the only output, if the next one has failed.
  std::optional<Index> preload_reached;
  // The body of RunOptions::turn_limit that ended the run, and its rotation then, rad.
  struct Turned {
    Index body = 0;
    double rotation = 0, t = 0;
  };
  std::optional<Turned> turned;
};

// Adds its lifetime in wall time to `sum`.
class Stopwatch {
 public:
  explicit Stopwatch(double& sum) : sum_(sum), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& sum_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace cbr

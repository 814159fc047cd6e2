// SPDX-License-Identifier: GPL-3.0-or-later
// Records results at the output times.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/simulation/run_result.hpp"
#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

class Recorder {
 public:
  explicit Recorder(Simulation& simulation);

  // Precondition: all bodies are at time t, `interval` after the last record (0: the first). Takes
  // and resets the sums of contact. RunError if a recorded value is not finite, with time and
  // instance, pair or surface. resting, per body: at rest since the last record. Without an
  // interval in equilibrium: sums of contact are forces, and reactions balance loads and contact.
  void record(double t, std::optional<double> interval, const std::vector<char>& resting,
              ContactState& state, const ContactOutcome& outcome);
  RunResult& result() { return result_; }
  void keep_state(StateArchive& archive);

 private:
  void record_monitors(double interval, ContactState& state);
  void record_energy(const std::vector<char>& resting, double friction);
  void record_stress(double t);
  void record_reactions(double t, std::optional<double> interval, const ContactState& state);
  bool looks_now() const;
  void record_pairs(double interval, const ContactOutcome& outcome);
  void record_pressure(double interval, ContactState& state);
  void check_finite(double t, const ContactOutcome& outcome) const;

  Simulation& sim_;
  RunResult result_;
  // Current coordinates and rates of a body, computed once per output.
  const std::pair<Vector, Vector>& coordinates(Index body);
  std::vector<BodyState> last_;  // per body
  std::map<Index, std::pair<Vector, Vector>> coordinates_;
  std::string not_finite_;  // stress that is not finite
  std::vector<BodyWork> work_;
  BodyWork before_;             // of all bodies, before the first record: of a preload
  double friction_before_ = 0;  // likewise
};

}  // namespace cbr

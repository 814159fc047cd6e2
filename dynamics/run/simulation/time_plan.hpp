// SPDX-License-Identifier: GPL-3.0-or-later
// Which steps a run takes: from limits and output times to step lengths.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "dynamics/motion/body.hpp"

namespace cbr {

// n_whole steps of h, steps_per_output to an output; then n_rest steps of h_rest when `end` is no
// multiple of the output interval.
struct TimePlan {
  double h = 0, every = 0, h_rest = 0, end = 0;
  Index steps_per_output = 1, n_whole = 0, n_rest = 0;
  std::string limit;  // what limits the step, for the summary; empty: nothing
  // Under Newmark, for the summary: alpha, and the critical step that central differences would
  // have (0: none, all bodies are rigid)
  std::optional<double> newmark_alpha;
  double critical = 0;
  // Bodies with scaling() get all modes above this frequency scaled to it (rad/s); 0: none.
  double clip = 0;
  // time.mass_scaling, whether or not the step is long enough for it to do something
  bool is_scaling_asked = false;

  Index n_steps() const { return n_whole + n_rest; }
  double time(Index step) const;
  // of the step that starts at `step`
  double step_length(Index step) const { return step < n_whole ? h : h_rest; }
  bool is_output(Index step) const { return step % steps_per_output == 0 || step == n_steps(); }
  Index next_output(Index step) const;  // the first after `step`
};

// The largest step <= h_max (0: none) that fits a whole number of times into `every` (0: every step
// is an output) and `end`.
TimePlan fit_steps(double h_max, double every, double end);

// The largest stable step of a body that is met in contact (`in_contact`) or not; 0: no limit, as
// under Newmark. omega_max h <= 2: beyond it central differences are unstable, and below omega h =
// pi the response of an exact body is definite; 2 keeps clear of it.
double critical_step(const Body& body, bool in_contact);

// How a body takes part in contact.
enum class ContactKind : char { none, hard, penalty };

// From the scene's options: auto is the critical step of exact bodies and 0.9 of it for central
// differences; a quarter of it for bodies in a penalty contact, whose spring is the stiffer the
// further the step is below the critical one. Where all bodies are under Newmark, auto is one step
// to an output (a thousandth of the end when every step is one) and cfl of any size is of what the
// critical step would be. With mass_scaling the same holds, from a default of 2, for the critical
// step of exact bodies in contact with scaling(); the others keep their limit. InputError: a step
// above the critical one (unless time.force), more steps or outputs than can be.
TimePlan plan_time(const TimeOptions& options, double every,
                   const std::vector<std::unique_ptr<Body>>& bodies,
                   const std::vector<ContactKind>& contact);

}  // namespace cbr

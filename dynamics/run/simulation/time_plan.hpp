// SPDX-License-Identifier: GPL-3.0-or-later
// Steps of a run, from limits and output times.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "dynamics/motion/body.hpp"

namespace cbr {

// n_whole steps of h, steps_per_output per output. Then n_rest steps of h_rest if `end` is not a
// multiple of the output interval.
struct TimePlan {
  double h = 0, every = 0, h_rest = 0, end = 0;
  Index steps_per_output = 1, n_whole = 0, n_rest = 0;
  std::string limit;  // limit of the step, for the summary; empty: none
  // Newmark, for the summary: alpha, and the critical step of central differences (0: none, all
  // bodies are rigid)
  std::optional<double> newmark_alpha;
  double critical = 0;

  Index n_steps() const { return n_whole + n_rest; }
  double time(Index step) const;
  // of the step that starts at `step`
  double step_length(Index step) const { return step < n_whole ? h : h_rest; }
  bool is_output(Index step) const { return step % steps_per_output == 0 || step == n_steps(); }
  Index next_output(Index step) const;  // the first after `step`
};

// The largest step <= h_max (0: none) of which `every` (0: every step is an output) and `end` are
// multiples.
TimePlan fit_steps(double h_max, double every, double end);

// The largest stable step of a body in contact (`in_contact`) or not; 0: no limit, as for Newmark.
// omega_max h <= 2 is the limit of central differences. The response of an exact body is definite
// below omega h = pi; 2 leaves a margin.
double critical_step(const Body& body, bool in_contact);

// Contact of a body.
enum class ContactKind : char { none, hard, penalty };

// Plans steps by the scene's options. auto: the critical step for exact bodies, 0.9 of it for
// central differences. A quarter of it for bodies in penalty contact, whose spring gets stiffer
// with shorter steps. If all bodies use Newmark: one step per output (a thousandth of the end if
// every step is an output). cfl is then relative to the critical step of central differences, with
// any value. Otherwise cfl above 1 is as auto: it has set the quasi-static modes of the bodies
// (BodyMaker). InputError: a step above the critical one (unless time.force), or too many steps or
// outputs.
TimePlan plan_time(const TimeOptions& options, double every,
                   const std::vector<std::unique_ptr<Body>>& bodies,
                   const std::vector<ContactKind>& contact);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/simulation/time_plan.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "common/base/error.hpp"

namespace cbr {
namespace {

// Shares s of the critical step 2 / omega_max that `step: auto` takes.
// Central differences answer an impulse on the highest mode 1 / sqrt(1 - s^2) times too far: 2.3
// times at 0.9, without bound at 1.
constexpr double automatic_share = 0.9;
// Springs of a penalty are stable up to a stiffness that goes with (1 - s^2) / s^2
// (enforcement.hpp): at 0.25 they are 64 times as stiff as at 0.9, and surfaces so much less deep
// in each other.
constexpr double penalty_step_share = 0.25;
constexpr double fit_tolerance = 1e-9;  // relative overshoot of a step that still fits

std::string text(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

Index ceil_count(double ratio) {
  return std::max<Index>(1, static_cast<Index>(std::ceil(ratio * (1 - fit_tolerance))));
}

// Limits of plausible runs and of memory: beyond them a unit is wrong.
constexpr double most_steps = 1e13, most_outputs = 1e8;

void require_countable(const TimeOptions& options, double h, double every) {
  // Without a limit by bodies the outputs define the steps
  const double step = h > 0 ? (every > 0 ? std::min(h, every) : h) : every;
  const double steps = step > 0 ? options.end / step : 0,
               outputs = every > 0 ? options.end / every : steps;
  if (steps <= most_steps && outputs <= most_outputs) return;
  const bool few_steps = steps <= most_steps;
  throw InputError(options.source.text() + ": time.end " + text(options.end) + " s would take " +
                   text(few_steps ? outputs : steps) + (few_steps ? " outputs" : " steps") +
                   ", at most " + text(few_steps ? most_outputs : most_steps) +
                   " are possible: look at the units of time.end, time.step and output.every");
}

// Smallest limit over the bodies, times `share`, and its body.
struct Limit {
  double h = 0, critical = 0;
  Body* body = nullptr;
};

Limit smallest(const std::vector<std::unique_ptr<Body>>& bodies,
               const std::vector<ContactKind>& contact,
               const std::function<double(Body&, ContactKind)>& share) {
  Limit limit;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const double critical = critical_step(*bodies[b], contact[b] != ContactKind::none);
    const double h = critical * share(*bodies[b], contact[b]);
    if (critical > 0 && (!limit.body || h < limit.h)) limit = {h, critical, bodies[b].get()};
  }
  return limit;
}

// Step of a body relative to its critical step.
double share_of_critical(const TimeOptions& options, Body& body, ContactKind contact) {
  if (options.cfl && *options.cfl <= 1) return *options.cfl;
  if (contact == ContactKind::penalty) return penalty_step_share;
  const double share = body.is_exact() ? 1 : automatic_share;
  return contact == ContactKind::hard ? std::min(share, body.facts().contact_share) : share;
}

// Times the critical step: springs keep (4 - x^2) / 4 = 1 % of their stiffness there, and none at
// the critical step.
constexpr double most_of_penalty = 0.995;

void require_springs(const TimeOptions& options, double h,
                     const std::vector<std::unique_ptr<Body>>& bodies,
                     const std::vector<ContactKind>& contact) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const double critical =
        contact[b] == ContactKind::penalty ? critical_step(*bodies[b], true) : 0;
    if (!(critical > 0) || h <= most_of_penalty * critical) continue;
    throw InputError(options.source.text() + ": time: a step of " + text(h) +
                     " s leaves the springs of enforcement: penalty on '" + bodies[b]->name() +
                     "' no stiffness, expected at most " + text(most_of_penalty * critical) +
                     " s (critical step " + text(critical) +
                     " s): use step: auto or enforcement: impulse");
  }
}

// Whether outputs limit the step below h.
bool cut_by_output(const TimePlan& plan, double h) {
  return plan.every > 0 && h > plan.every * (1 + fit_tolerance);
}

// Smallest 2 / highest frequency, for any integrator.
Limit frequency_limit(const std::vector<std::unique_ptr<Body>>& bodies) {
  Limit limit;
  for (const auto& body : bodies) {
    const double omega = body->largest_frequency();
    if (omega > 0 && (!limit.body || 2 / omega < limit.h))
      limit = {2 / omega, 2 / omega, body.get()};
  }
  return limit;
}

TimePlan plan_newmark(const TimeOptions& options, double every,
                      const std::vector<std::unique_ptr<Body>>& bodies) {
  const Limit critical = frequency_limit(bodies);
  // Without elastic modes there is no critical step
  const double h = options.step ? *options.step : options.cfl ? *options.cfl * critical.h : 0;
  require_countable(options, h > 0 || every > 0 ? h : options.end / 1000, every);
  TimePlan plan = fit_steps(h, every, options.end);
  if (options.step) plan.limit = "time.step";
  if (!options.step && h > 0)
    plan.limit = "time.step, a multiple of the critical step of '" + critical.body->name() + "'";
  if (cut_by_output(plan, h)) plan.limit = "output.every";
  plan.newmark_alpha = options.alpha;
  plan.critical = critical.h;
  return plan;
}

}  // namespace

double TimePlan::time(Index step) const {
  if (step == n_steps()) return end;
  const Index whole = std::min(step, n_whole), outputs = whole / steps_per_output;
  const double reached = every > 0 ? static_cast<double>(outputs) * every +
                                         static_cast<double>(whole % steps_per_output) * h
                                   : static_cast<double>(whole) * h;
  return reached + static_cast<double>(step - whole) * h_rest;
}

Index TimePlan::next_output(Index step) const {
  return std::min(n_steps(), (step / steps_per_output + 1) * steps_per_output);
}

TimePlan fit_steps(double h_max, double every, double end) {
  TimePlan plan;
  plan.end = end;
  const bool all = every <= 0 || every >= end;
  if (h_max <= 0) h_max = every > 0 ? std::min(every, end) : end / 1000;
  if (all) {
    plan.n_whole = ceil_count(end / h_max);
    plan.h = plan.h_rest = end / static_cast<double>(plan.n_whole);
    plan.steps_per_output = every > 0 ? plan.n_whole : 1;
    return plan;
  }
  plan.every = every;
  plan.steps_per_output = ceil_count(every / h_max);
  plan.h = every / static_cast<double>(plan.steps_per_output);
  const Index outputs = static_cast<Index>(std::floor(end / every * (1 + fit_tolerance)));
  plan.n_whole = outputs * plan.steps_per_output;
  const double rest = end - static_cast<double>(outputs) * every;
  if (rest > fit_tolerance * every) plan.n_rest = ceil_count(rest / plan.h);
  plan.h_rest = plan.n_rest > 0 ? rest / static_cast<double>(plan.n_rest) : plan.h;
  return plan;
}

double critical_step(const Body& body, bool in_contact) {
  if (body.scheme() == Scheme::newmark) return 0;
  const double omega = body.largest_frequency();
  return omega > 0 && (in_contact || !body.is_exact()) ? 2 / omega : 0;
}

TimePlan plan_time(const TimeOptions& options, double every,
                   const std::vector<std::unique_ptr<Body>>& bodies,
                   const std::vector<ContactKind>& contact) {
  const bool newmark = std::any_of(bodies.begin(), bodies.end(),
                                   [](const auto& b) { return b->scheme() == Scheme::newmark; });
  if (newmark) return plan_newmark(options, every, bodies);
  const Limit critical = smallest(bodies, contact, [](Body&, ContactKind) { return 1.0; });
  const Limit limit = smallest(bodies, contact, [&](Body& body, ContactKind kind) {
    return share_of_critical(options, body, kind);
  });
  double h = limit.h;
  std::string reason;
  if (options.step) {
    h = *options.step;
    reason = "time.step";
  } else if (limit.body) {
    reason = "'" + limit.body->name() + "' (critical step " + text(limit.critical) +
             " s, highest frequency " + text(limit.body->largest_frequency()) + " rad/s)";
  }
  require_countable(options, h, every);
  TimePlan plan = fit_steps(h, every, options.end);
  if (critical.body && plan.h > critical.h * (1 + fit_tolerance) && !options.force_step) {
    throw InputError(options.source.text() + ": time: a step of " + text(plan.h) +
                     " s is above the critical step " + text(critical.h) + " s of instance '" +
                     critical.body->name() +
                     "' (2 / highest frequency): use step: auto, a smaller one, or force: true to "
                     "run it all the same");
  }
  require_springs(options, plan.h, bodies, contact);
  plan.limit = cut_by_output(plan, h) ? "output.every" : reason;
  return plan;
}

}  // namespace cbr

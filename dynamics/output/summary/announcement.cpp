// SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>
#include <sstream>

#include "common/scene/scene_words.hpp"
#include "dynamics/output/summary/summary.hpp"

namespace cbr {
namespace {

Integrator integrator_of(Scheme scheme) {
  if (scheme == Scheme::newmark) return Integrator::newmark;
  return scheme == Scheme::exact ? Integrator::exact : Integrator::central_difference;
}

std::string kind_of(const BuiltScene::OfInstance& of) {
  if (of.is_rigid) return "rigid body";
  if (of.mesh) return std::string("mesh of ") + word_of(mass_words, of.mass_kind) + " mass";
  return of.parts.size() == 1 ? "superelement"
                              : "superelement of " + std::to_string(of.parts.size()) + " domains";
}

// Number of quasi-static modes: docs/decisions/truncation.md
std::string following_text(const BuiltScene::OfInstance& of) {
  if (of.n_following == 0) return {};
  return " (" + std::to_string(of.n_following) + " faster ones follow contact as statics)";
}

void instance_lines(const BuiltScene& built, Report& report) {
  for (std::size_t b = 0; b < built.instances.size(); ++b) {
    const Body& body = *built.simulation.bodies[b];
    std::ostringstream line;
    line << "instance " << body.name() << ": component " << built.instances[b].component << ", "
         << kind_of(built.instances[b]) << ", " << body.n_dofs() << " dofs"
         << following_text(built.instances[b]) << ", "
         << (built.simulation.is_static ? "statics"
                                        : word_of(integrator_words, integrator_of(body.scheme())));
    report.line(line.str());
    if (built.simulation.is_static) continue;  // not needed: there are no steps
    const double omega = body.largest_frequency();
    std::ostringstream detail;
    detail.precision(6);
    detail << "instance " << body.name() << ": highest frequency " << omega / (2 * std::numbers::pi)
           << " Hz";
    if (omega > 0) detail << ", critical step of central differences " << 2 / omega << " s";
    report.detail(detail.str());
  }
}

void step_line(const BuiltScene& built, Report& report) {
  const TimePlan& plan = built.simulation.plan;
  Index n_dofs = 0;
  for (const auto& body : built.simulation.bodies) n_dofs += body->n_dofs();
  std::ostringstream line;
  line.precision(5);
  if (built.simulation.is_static) {
    line << "load steps: " << built.simulation.preload + 1 + plan.n_steps();
    if (built.simulation.preload > 0) line << " (" << built.simulation.preload << " before t = 0)";
    line << ", from t = 0 every ";
  } else {
    line << "steps: " << plan.n_steps() << " of ";
  }
  line << plan.h << " s to t = " << plan.end << " s, " << n_dofs << " dofs in "
       << built.instances.size() << (built.instances.size() == 1 ? " instance" : " instances");
  if (plan.newmark_alpha) {
    line.precision(3);
    line << "; newmark, alpha " << *plan.newmark_alpha;
    if (plan.critical > 0)
      line << ", " << plan.h / plan.critical << " times the critical step of central differences";
    if (!plan.limit.empty()) line << " (set by " << plan.limit << ")";
  } else if (!plan.limit.empty() && !built.simulation.is_static) {
    line << "; step limited by " << plan.limit;
  }
  report.line(line.str());
}

}  // namespace

std::string steps_done(const Simulation& sim, Index reached) {
  const Index before = sim.is_static ? sim.preload + 1 : 0;
  return std::to_string(before + reached) + " of " + std::to_string(before + sim.plan.n_steps()) +
         (sim.is_static ? " load steps" : " steps");
}

void announce(const BuiltScene& built, bool is_again, Report& report) {
  if (!is_again) instance_lines(built, report);
  step_line(built, report);
}

}  // namespace cbr

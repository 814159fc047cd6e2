// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "common/format_text.hpp"
#include "common/scene_words.hpp"
#include "dynamics/output/basis_energy.hpp"
#include "dynamics/output/results.hpp"

namespace cbr {
namespace {

Vector3 at(const Series3& series, std::size_t i) { return Eigen::Map<const Vector3>(series.values.data() + 3 * i); }

// Largest norm of a series.
double largest(const Series3& series) {
  double norm = 0;
  for (std::size_t i = 0; 3 * i < series.values.size(); ++i) norm = std::max(norm, at(series, i).norm());
  return norm;
}

// Largest change of the sum over all bodies, as a share of `scale`.
double drift(const RunResult& result, Series3 RunResult::OfBody::*series, double scale) {
  double worst = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i) {
    Vector3 change = Vector3::Zero();
    for (const auto& body : result.bodies) change += at(body.*series, i) - at(body.*series, 0);
    worst = std::max(worst, change.norm());
  }
  return scale > 0 ? worst / scale : 0;
}

Integrator integrator_of(Scheme scheme) {
  if (scheme == Scheme::newmark) return Integrator::newmark;
  return scheme == Scheme::exact ? Integrator::exact : Integrator::central_difference;
}

std::string kind_of(const BuiltScene::OfInstance& of) {
  if (of.mesh) return "mesh";
  return of.parts.size() == 1 ? "superelement" : "superelement of " + std::to_string(of.parts.size()) + " domains";
}

void instance_lines(const BuiltScene& built, Report& report) {
  for (std::size_t b = 0; b < built.instances.size(); ++b) {
    const Body& body = *built.simulation.bodies[b];
    std::ostringstream line;
    line << "instance " << body.name() << ": component " << built.instances[b].component << ", " << kind_of(built.instances[b])
         << ", " << body.n_dofs() << " dofs, " << word_of(integrator_words, integrator_of(body.scheme()));
    report.line(line.str());
    const double omega = body.largest_frequency();
    std::ostringstream detail;
    detail.precision(6);
    detail << "instance " << body.name() << ": highest frequency " << omega / (2 * std::numbers::pi) << " Hz";
    if (omega > 0) detail << ", critical step of central differences " << 2 / omega << " s";
    report.detail(detail.str());
  }
}

void step_lines(const BuiltScene& built, const RunResult& result, Report& report) {
  const TimePlan& plan = built.simulation.plan;
  std::ostringstream line;
  line.precision(5);
  line << "steps: " << plan.n_steps() << " of " << plan.h << " s";
  if (result.jumps > 0)
    line << ", " << result.steps << " of them computed (the others were skipped: exact motion, no contact near)";
  if (plan.newmark_alpha) {
    line.precision(3);
    line << "; newmark, alpha " << *plan.newmark_alpha;
    if (plan.critical > 0) line << ", " << plan.h / plan.critical << " times the critical step of central differences";
    if (!plan.limit.empty()) line << " (set by " << plan.limit << ")";
  } else if (!plan.limit.empty()) {
    line << "; step limited by " << plan.limit;
  }
  report.line(line.str());
  if (plan.clip == 0) {
    if (plan.is_scaling_asked)
      report.line("mass scaling: nothing is scaled, as the step is not above the critical one of any superelement that touches" +
                  std::string(plan.limit == "output.every" ? ": a longer output.every would allow longer steps" : ""));
    return;
  }
  std::ostringstream scaling;
  scaling.precision(3);
  scaling << "mass scaling: in superelements that touch, all modes above " << plan.clip / (2 * std::numbers::pi)
          << " Hz have that frequency; they held at most " << 100 * result.scaled_energy_share << " % of the energy at an output";
  report.line(scaling.str());
  constexpr double too_much = 0.1;
  if (result.scaled_energy_share > too_much) {
    std::ostringstream warning;
    warning.precision(2);
    warning << "mass scaling: the modes that are scaled held " << 100 * result.scaled_energy_share
            << " % of the energy: their motion is not that of the body; take a smaller step";
    report.warning(warning.str());
  }
}

// "1 step", "2 steps"
std::string counted(Index n, const std::string& noun) { return std::to_string(n) + " " + noun + (n == 1 ? "" : "s"); }

// 0 where it is round-off.
double initial_overlap(const ContactPair& pair) {
  const double overlap = std::max(pair.seen().memory.initial_overlap, pair.seen().back.initial_overlap);
  return overlap > 1e-10 * pair.master->size ? overlap : 0;
}
double initial_gap(const ContactPair& pair) { return std::min(pair.seen().memory.initial_gap, pair.seen().back.initial_gap); }

std::string contact_line(const ContactPair& pair) {
  std::ostringstream line;
  line.precision(3);
  line << "contact " << pair.name << ": " << counted(static_cast<Index>(pair.slave->nodes.size()), "slave node") << " of "
       << pair.slave->name;
  if (pair.law.law == ContactLaw::tied) {
    const Index n = static_cast<Index>(pair.slave->nodes.size()),
                free = pair.has_state() ? pair.seen().tie_report.without_partner : n;
    line << ", " << counted(static_cast<Index>(pair.seen().ties.points.size()), "point") << " tied, largest offset "
         << pair.seen().tie_report.largest_offset << ", " << counted(free, "node") << " left free";
  }
  line << ", " << word_of(formulation_words, pair.formulation) << ", " << word_of(enforcement_words, pair.enforcement);
  if (pair.law.law == ContactLaw::coulomb) line << ", friction " << pair.law.friction;
  if (pair.damping > 0) line << ", damping " << pair.damping;
  line << "; largest area in contact " << pair.seen().largest_area;
  if (pair.law.law != ContactLaw::tied) line << ", largest penetration " << pair.seen().penetration;
  if (pair.enforcement == Enforcement::impulse) line << ", residual " << pair.seen().residual;
  if (initial_overlap(pair) > 0) line << "; initial overlap " << initial_overlap(pair);
  // Surfaces that touch or overlap somewhere have no gap, however far their other nodes are.
  if (initial_overlap(pair) == 0 && initial_gap(pair) > 0 && std::isfinite(initial_gap(pair)))
    line << "; initial gap " << initial_gap(pair);
  if (pair.seen().n_fallbacks > 0) line << "; Newton's method needed help in " << counted(pair.seen().n_fallbacks, "step");
  return line.str();
}

void contact_warnings(const ContactPair& pair, Report& report) {
  const double overlap = initial_overlap(pair);
  if (overlap > std::max(1e-6 * pair.master->size, pair.adjust.value_or(0))) {
    std::ostringstream warning;
    warning.precision(3);
    warning << "contact " << pair.name << ": the surfaces overlap by " << overlap
            << " at the start; nodes that overlapped were held where they were, not pushed out";
    report.warning(warning.str());
  }
  if (pair.enforcement != Enforcement::penalty && pair.seen().residual > 1e-6)
    report.warning("contact " + pair.name + ": not all gaps could be closed or opened (complementarity residual above 1e-6)");
}

// Of many pairs only those that met.
void contact_lines(const BuiltScene& built, Report& report) {
  constexpr std::size_t many = 10;
  const auto& pairs = built.simulation.pairs;
  std::size_t n_apart = 0;
  for (const ContactPair& pair : pairs) {
    const bool apart = pair.seen().largest_area == 0 && initial_overlap(pair) == 0;
    if (pairs.size() > many && apart) {
      ++n_apart;
    } else {
      report.line(contact_line(pair));
    }
    contact_warnings(pair, report);
  }
  if (n_apart > 0) report.line("contact: " + counted(n_apart, "more pair") + " that never met");
}

// Energy that round-off brings: gaps are closed to the last digits of positions, some eps of the reach in a step h, and so are
// velocities to some eps of reach / h. That times the mass, squared, half of it.
double round_off_energy(const BuiltScene& built) {
  double reach = 0, mass = 0;
  for (const auto& body : built.simulation.bodies) reach = std::max(reach, body->reference_positions().cwiseAbs().maxCoeff());
  for (const auto& instance : built.instances) mass += instance.mass;
  const double speed = 64 * std::numeric_limits<double>::epsilon() * reach / built.simulation.plan.h;
  return 0.5 * mass * speed * speed;
}

// Gaps and strains are differences of positions: far from the origin these keep too few digits of them.
void distance_warning(const BuiltScene& built, Report& report) {
  for (std::size_t i = 0; i < built.simulation.bodies.size(); ++i) {
    const Points& x = built.simulation.bodies[i]->reference_positions();
    const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff(), reach = x.cwiseAbs().maxCoeff();
    const double digit = std::numeric_limits<double>::epsilon() * reach;
    if (!(size > 0) || digit < 1e-6 * size) continue;
    report.warning(format_text("instance '%s' is %.2g across and lies %.2g from the origin, where positions are known to %.1g: ",
                               built.instances[i].name.c_str(), size, reach, digit) +
                   "contact and energy there are round-off: move the scene nearer to the origin");
    return;
  }
}

// What contact has given beyond what it had taken, where that is an error.
void energy_warning(const BuiltScene& built, const RunResult& result, Report& report) {
  // Frictionless contact can take energy, and give back what it took, but bring none.
  // While nodes are held, they swing between the ends of exact steps, which counts as energy until they are let go.
  double brought = result.work_contact.back();
  for (std::size_t i = 0; i < result.time.size(); ++i)
    if (result.active[i] == 0) brought = std::max(brought, result.work_contact[i]);
  const double scale = std::max(*std::max_element(result.total.begin(), result.total.end()), std::abs(result.work_external.back()));
  if (!(brought > std::max(0.01 * scale, round_off_energy(built)))) return;
  std::ostringstream warning;
  warning.precision(3);
  warning
      << "contact brought energy: up to " << brought << " of " << scale
      << ": try a smaller step; where it does not bring less, nodes were pushed out of faces that they were deep in: look at the "
         "surfaces";
  const auto& pairs = built.simulation.pairs;
  const auto is_mortar = [](const ContactPair& pair) {
    return pair.formulation == Formulation::mortar && pair.law.law != ContactLaw::tied;
  };
  if (std::any_of(pairs.begin(), pairs.end(), is_mortar))
    warning << "; mortar is for faces that look at each other: for bodies that go over convex edges take formulation: node-face";
  report.warning(warning.str());
}

// ", of numerical damping -0.1 (2 %)", the share being of the largest energy or work of loads
std::string numerical_loss(const RunResult& result) {
  double scale = std::abs(result.work_external.back());
  for (const double total : result.total) scale = std::max(scale, total);
  std::ostringstream text;
  text.precision(3);
  text << ", of numerical damping " << result.work_numerical.back();
  if (scale > 0) text << " (" << 100 * std::abs(result.work_numerical.back()) / scale << " %)";
  return text.str();
}

// What was done, of what the planned steps of every body and pair would have been.
void work_line(const BuiltScene& built, const RunResult& result, Report& report) {
  const Simulation& sim = built.simulation;
  const Index steps = sim.plan.n_steps();
  std::ostringstream line;
  line << "work: " << result.work.body_steps << " of " << steps * static_cast<Index>(sim.bodies.size()) << " body steps";
  if (!sim.pairs.empty())
    line << ", " << result.work.pair_searches << " of " << steps * static_cast<Index>(sim.pairs.size()) << " searches of pairs, "
         << result.work.pair_looks << " comparisons and " << result.work.bounds << " motion bounds to know which";
  report.line(line.str());
}

}  // namespace

Balance balance(const RunResult& result) {
  Balance b;
  double scale = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i) {
    scale = std::max({scale, std::abs(result.total[i]), std::abs(result.work_external[i]), std::abs(result.work_contact[i])});
    const double work = result.work_external[i] + result.work_contact[i] + result.work_friction[i] + result.work_numerical[i];
    b.energy = std::max(b.energy, std::abs(result.total[i] - result.total[0] - work));
  }
  if (scale > 0) b.energy /= scale;
  double momentum = 0, angular = 0;
  for (const auto& body : result.bodies) {
    momentum += largest(body.momentum);
    // An angular momentum that should be nil is measured by momentum times distance.
    angular += std::max(largest(body.angular_momentum), largest(body.momentum) * largest(body.center_of_mass));
  }
  b.momentum = drift(result, &RunResult::OfBody::momentum, momentum);
  b.angular_momentum = drift(result, &RunResult::OfBody::angular_momentum, angular);
  return b;
}

void summarise(const BuiltScene& built, const RunResult& result, Report& report) {
  instance_lines(built, report);
  step_lines(built, result, report);
  work_line(built, result, report);
  const Balance b = balance(result);
  std::ostringstream line;
  line.precision(3);
  line << "balance: energy " << b.energy << ", work of loads " << result.work_external.back() << ", of contact "
       << result.work_contact.back();
  if (built.simulation.plan.newmark_alpha.value_or(0) != 0) line << numerical_loss(result);
  line << ", total energy " << result.total.front() << " -> " << result.total.back();
  if (built.momentum_is_kept) line << "; drift of momentum " << b.momentum << ", of angular momentum " << b.angular_momentum;
  report.line(line.str());
  if (const auto outside = energy_outside_basis(built, result)) report.line(text_of(*outside, built.momentum_is_kept));
  contact_lines(built, report);
  for (const std::string& note : built.notes) report.line("note: " + note);
  if (!(b.energy <= 1e-8))
    report.warning(built.simulation.plan.newmark_alpha
                       ? "the energy balance does not close"
                       : "the energy balance does not close: the step may be above the critical one");
  distance_warning(built, report);
  energy_warning(built, result, report);
  const double degrees = result.largest_rotation * 180 / std::numbers::pi;
  if (degrees > 5) {
    std::ostringstream warning;
    warning.precision(3);
    warning << "instance '" << built.simulation.bodies[result.most_rotated]->name() << "' rotates by " << degrees
            << " degrees: bodies are linear (small rotations), so its motion is no longer right";
    report.warning(warning.str());
  }
}

}  // namespace cbr

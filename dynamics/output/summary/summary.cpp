// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/summary/summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/scene_words.hpp"

namespace cbr {
namespace {

Vector3 at(const Series3& series, std::size_t i) {
  return Eigen::Map<const Vector3>(series.values.data() + 3 * i);
}

// Largest norm of a series.
double largest(const Series3& series) {
  double norm = 0;
  for (std::size_t i = 0; 3 * i < series.values.size(); ++i)
    norm = std::max(norm, at(series, i).norm());
  return norm;
}

// Largest change of the sum over all bodies, divided by `scale`.
double drift(const RunResult& result, Series3 RunResult::OfBody::*series, double scale) {
  double worst = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i) {
    Vector3 change = Vector3::Zero();
    for (const auto& body : result.bodies) change += at(body.*series, i) - at(body.*series, 0);
    worst = std::max(worst, change.norm());
  }
  return scale > 0 ? worst / scale : 0;
}

// Largest energy: of all, or of the motion of one body, as springs can have energies below 0.
double largest_energy(const RunResult& result) {
  double energy = 0;
  for (const double total : result.total) energy = std::max(energy, std::abs(total));
  for (const RunResult::OfBody& body : result.bodies)
    for (const double kinetic : body.kinetic_energy) energy = std::max(energy, kinetic);
  return energy;
}

// Reports the progress of a run that ended early or skipped steps.
void reached_lines(const BuiltScene& built, const RunResult& result, Report& report) {
  const TimePlan& plan = built.simulation.plan;
  std::ostringstream line;
  line.precision(5);
  if (result.preload_reached)
    line << "ended early: " << *result.preload_reached << " of " << built.simulation.preload
         << " load steps before the time 0";
  else if (result.ended_at)
    line << "ended early: " << steps_done(built.simulation, result.reached)
         << ", t = " << *result.ended_at << " s of " << plan.end << " s";
  if (result.jumps > 0)
    line << (result.ended_at ? "; " : "steps: ") << result.steps << " of " << result.reached
         << " computed (the others were skipped: exact motion, no contact near)";
  if (!line.str().empty()) report.line(line.str());
}

// Longest path of a centre of mass, from the start to an output.
double longest_way(const RunResult& result) {
  double way = 0;
  for (const RunResult::OfBody& body : result.bodies) {
    const std::vector<double>& c = body.center_of_mass.values;
    for (std::size_t i = 0; i < c.size(); ++i) way = std::max(way, std::abs(c[i] - c[i % 3]));
  }
  return way;
}

// Bound of the energy error by round-off. Gaps are closed to the last digits of positions, some eps
// times the reach per step h, velocities to some eps reach / h. The energy is half the mass times
// that squared. Statics have no h: m omega^2 is the largest stiffness for the same digits. Its
// force does work along the path of prescribed motions. Strains after load steps are differences
// of displacements, which these have left with the body as a whole.
double round_off_energy(const BuiltScene& built, const RunResult& result) {
  const Simulation& sim = built.simulation;
  constexpr double eps = 64 * std::numeric_limits<double>::epsilon();
  const double way = longest_way(result);
  double reach = 0, inertia = 0, left = 0;
  for (const auto& body : sim.bodies) {
    reach = std::max(reach, body->reference_positions().cwiseAbs().maxCoeff());
    Points u, v;
    if (sim.preload > 0) body->displacements(u, v);
    if (u.size() > 0) left = std::max(left, u.colwise().mean().cwiseAbs().maxCoeff() - way);
  }
  for (std::size_t i = 0; i < built.instances.size(); ++i) {
    const double rate = sim.is_static ? sim.bodies[i]->largest_frequency() : 1 / sim.plan.h;
    if (std::isfinite(rate)) inertia += built.instances[i].mass * rate * rate;
  }
  const double digits = eps * reach;
  return 0.5 * inertia * (digits * (digits + (sim.is_static ? 2 * way : 0)) + eps * left * left);
}

bool is_energy_kept(const BuiltScene& built, const RunResult& result, const Balance& b) {
  return b.energy <= 1e-8 || b.energy_off <= round_off_energy(built, result);
}

// Gaps and strains are differences of positions, which have too few digits far from the origin.
void distance_warning(const BuiltScene& built, Report& report) {
  for (std::size_t i = 0; i < built.instances.size(); ++i) {
    const Points& x = built.simulation.bodies[i]->reference_positions();
    const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff(),
                 reach = x.cwiseAbs().maxCoeff();
    const double digit = std::numeric_limits<double>::epsilon() * reach;
    if (!(size > 0) || digit < 1e-6 * size) continue;
    report.warning(format_text("instance '%s' is %.2g across and lies %.2g from the origin, where "
                               "positions are known to %.1g: ",
                               built.instances[i].name.c_str(), size, reach, digit) +
                   "contact and energy there are round-off: move the scene nearer to the origin");
    return;
  }
}

// Warns if contact has returned more energy than it had removed, by an error.
void energy_warning(const BuiltScene& built, const RunResult& result, Report& report) {
  // Frictionless contact can remove energy and return it, but not add any.
  double brought = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i)
    if (result.active[i] == 0) brought = std::max(brought, result.work_contact[i]);
  const double scale = std::max(largest_energy(result), std::abs(result.work_external.back()));
  // Nodes in contact oscillate within exact steps. That counts as energy until they are released: a
  // few per cent for a body that is pressed at its critical step.
  constexpr double share_of_swings = 0.2;
  const double at_end = result.work_contact.back();
  if (result.active.back() == 0 || at_end > share_of_swings * scale)
    brought = std::max(brought, at_end);
  if (!(brought >
        std::max({0.01 * scale, round_off_energy(built, result), energy_of_a_step(built, result)})))
    return;
  bool has_mortar = false, has_springs = false;
  for (const ContactPair& pair : built.simulation.pairs) {
    has_mortar |= pair.formulation == Formulation::mortar && pair.law.law != ContactLaw::tied;
    has_springs |= pair.enforcement == Enforcement::penalty && pair.penalty.damping == 0;
  }
  report.warning(
      format_text(
          "contact brought energy: up to %.3g of %.3g: try a smaller step; where it does not bring "
          "less, nodes were pushed out of faces that they were deep in: look at the surfaces",
          brought, scale) +
      (has_mortar ? "; mortar is for faces that look at each other: for bodies that go over convex "
                    "edges take formulation: node-face"
                  : "") +
      (has_springs ? "; springs of penalty on which a body rests need contact[].damping, as 0.5"
                   : ""));
}

// Largest of a work at outputs, relative to the largest energy or work of loads; 0 if there is
// neither.
double share_of(const std::vector<double>& works, const RunResult& result) {
  double scale = std::abs(result.work_external.back()), most = 0;
  for (const double total : result.total) scale = std::max(scale, total);
  for (const double work : works) most = std::max(most, std::abs(work));
  return scale > 0 ? most / scale : 0;
}

// ", of numerical damping -0.1 (2 %)"; for steps with large rotation if above round-off.
std::string numerical_loss(const BuiltScene& built, const RunResult& result) {
  const bool damps = built.simulation.plan.newmark_alpha.value_or(0) != 0;
  const double share = share_of(result.work_numerical, result);
  if (!damps && !(share > 1e-8)) return {};
  return format_text(", of %s %.3g (at most %.2g %%)", damps ? "numerical damping" : "the steps",
                     result.work_numerical.back(), 100 * share);
}

// " (up to 2 % of all, ...)". In equilibrium normal forces do no work, but at moving walls, and as
// bolts and overlaps are applied. What is booked is an error of the load steps.
std::string error_of_load_steps(const BuiltScene& built, const RunResult& result) {
  const auto& pairs = built.simulation.pairs;
  const bool works = std::any_of(pairs.begin(), pairs.end(), [](const ContactPair& pair) {
    return pair.pretension || pair.interference != 0 || pair.resolves_overlap || pair.shift();
  });
  const double share = share_of(result.work_contact, result);
  const bool strains = *std::max_element(result.total.begin(), result.total.end()) > 0;
  if (!built.simulation.is_static || works || !strains || !(share > 1e-3)) return {};
  return format_text(" (up to %.2g %% of all, an error of the load steps; good: a few per cent)",
                     100 * share);
}

// Steps that are too long for the rotation and strain still close their balance, as the energy that
// they add or remove is booked. Hence this warning.
void steps_warning(const BuiltScene& built, const RunResult& result, Report& report) {
  constexpr double much = 0.01;
  const double share = share_of(result.work_numerical, result);
  if (built.simulation.plan.newmark_alpha || !(share > much)) return;
  report.warning(format_text(
      "the steps have made or taken %.2g %% of the energy (work_numerical): the body strains too "
      "much for small strains, or the step is too long: take a smaller time.step",
      100 * share));
}

// Work done, relative to a step of each body and pair at each planned step.
void work_line(const BuiltScene& built, const RunResult& result, Report& report) {
  const Simulation& sim = built.simulation;
  const Index steps = sim.plan.n_steps();
  std::ostringstream line;
  line << "work: " << result.work.body_steps << " of "
       << steps * static_cast<Index>(sim.bodies.size()) << " body steps";
  if (!sim.pairs.empty())
    line << ", " << result.work.pair_searches << " of "
         << steps * static_cast<Index>(sim.pairs.size()) << " searches of pairs, "
         << result.work.pair_looks << " comparisons and " << result.work.bounds
         << " motion bounds to know which";
  report.detail(line.str());
}

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

// Equal instances share a line: up to three of them by name.
void instance_lines(const BuiltScene& built, Report& report) {
  constexpr std::size_t named = 3;
  std::vector<std::pair<std::string, std::vector<std::string>>> lines;
  for (std::size_t b = 0; b < built.instances.size(); ++b) {
    const Body& body = *built.simulation.bodies[b];
    std::ostringstream line;
    line << ": component " << built.instances[b].component << ", " << kind_of(built.instances[b])
         << ", " << body.n_dofs() << " dofs" << following_text(built.instances[b]) << ", "
         << (built.simulation.is_static ? "statics"
                                        : word_of(integrator_words, integrator_of(body.scheme())));
    const auto same = std::find_if(lines.begin(), lines.end(),
                                   [&](const auto& of) { return of.first == line.str(); });
    if (same == lines.end())
      lines.push_back({line.str(), {body.name()}});
    else
      same->second.push_back(body.name());
  }
  for (auto& [text, names] : lines) {
    const std::size_t n = names.size();
    names.resize(std::min(n, named));
    report.line((n > 1 ? "instances " : "instance ") + join(names) +
                (n > named ? " and " + std::to_string(n - named) + " more" : "") + text);
  }
  for (std::size_t b = 0; b < built.instances.size(); ++b) {
    const Body& body = *built.simulation.bodies[b];
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

Balance balance(const RunResult& result) {
  Balance b;
  double scale = largest_energy(result);
  for (std::size_t i = 0; i < result.time.size(); ++i) {
    scale = std::max({scale, std::abs(result.work_external[i]), std::abs(result.work_contact[i])});
    const double work = result.work_external[i] + result.work_contact[i] + result.work_friction[i] +
                        result.work_damping[i] + result.work_numerical[i];
    b.energy_off = std::max(b.energy_off, std::abs(result.total[i] - result.total[0] - work));
  }
  b.energy = scale > 0 ? b.energy_off / scale : b.energy_off;
  double momentum = 0, angular = 0;
  for (const auto& body : result.bodies) {
    momentum += largest(body.momentum);
    // Angular momenta near 0 are scaled by momentum times distance.
    angular += std::max(largest(body.angular_momentum),
                        largest(body.momentum) * largest(body.center_of_mass));
  }
  b.momentum_off = drift(result, &RunResult::OfBody::momentum, 1);
  b.momentum = momentum > 0 ? b.momentum_off / momentum : 0;
  b.angular_momentum = drift(result, &RunResult::OfBody::angular_momentum, angular);
  return b;
}

namespace {

void balance_lines(const BuiltScene& built, const RunResult& result, const Balance& b,
                   Report& report) {
  std::ostringstream line;
  line.precision(3);
  line << "energy: " << result.total.front() << " -> " << result.total.back() << ", work of loads "
       << result.work_external.back() << ", of contact " << result.work_contact.back()
       << error_of_load_steps(built, result);
  if (result.work_damping.back() != 0) line << ", of damping " << result.work_damping.back();
  line << numerical_loss(built, result);
  line << "; the balance closes to " << b.energy
       << (b.energy > 1e-8 && is_energy_kept(built, result, b) ? " of energies that are round-off"
                                                               : " (good: below 1e-8)");
  report.line(line.str());
  if (!built.momentum_is_kept) return;
  const auto& bodies = built.simulation.bodies;
  const bool all_turn = std::all_of(
      bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(built.instances.size()),
      [](const auto& body) { return body->turns(); });
  // A body that spins in place has a momentum of round-off
  double momentum = 0;
  for (std::size_t i = 0; i < built.instances.size(); ++i) {
    const auto& kinetic = result.bodies[i].kinetic_energy;
    momentum +=
        std::sqrt(2 * built.instances[i].mass * *std::max_element(kinetic.begin(), kinetic.end()));
  }
  const bool is_nil = b.momentum_off < 1e-10 * momentum;
  report.line(format_text(
      "momentum: drift %.3g (good: below 1e-10), of angular momentum %.3g (good: below %s)",
      is_nil ? b.momentum_off / momentum : b.momentum, b.angular_momentum,
      all_turn ? "1e-10" : "1e-2; it grows with rotations, which bodies take as small"));
}

// Advice that enables large rotation of an instance.
std::string cure_of_rotation(const BuiltScene& built, std::size_t i) {
  if (built.simulation.is_static) return {};
  const std::string& why = built.instances[i].why_linear;
  return "; " + (why.empty() ? "time: {rotations: large} turns it by any angle" : why);
}

// Linear bodies: strains are wrong after large rotations.
void rotation_warnings(const BuiltScene& built, const RunResult& result, Report& report) {
  constexpr int most = 10;
  constexpr double limit = small_rotation * 180 / std::numbers::pi;
  int n = 0;
  for (std::size_t i = 0; i < result.bodies.size(); ++i) {
    const RunResult::OfBody& of = result.bodies[i];
    if (!of.turned_at || ++n > most) continue;
    report.warning(format_text("instance '%s' rotates by %.3g degrees, beyond %.3g from t = %.4g s "
                               "on: bodies are linear (small "
                               "rotations), so its motion is no longer right",
                               built.simulation.bodies[i]->name().c_str(),
                               of.rotation * 180 / std::numbers::pi, limit, *of.turned_at) +
                   cure_of_rotation(built, i));
  }
  if (n > most)
    report.warning(
        format_text("and %d more instances rotate by more than %.3g degrees", n - most, limit));
}

// Warns of statics beyond small strains and displacements.
void strain_warnings(const BuiltScene& built, Report& report) {
  const auto of = [&](const StrainWatch::Worst& worst) {
    return "instance '" + built.instances[worst.body].name + "' ";
  };
  const std::string cause =
      ": bodies are linear, and right up to strains of some per cent: is a load, youngs_modulus or "
      "the mesh in another unit?";
  if (const auto worst = built.strains.strain())
    report.warning(of(*worst) +
                   format_text("is strained by %.3g %% at t = %.4g", 100 * worst->value, worst->t) +
                   cause);
  if (const auto worst = built.strains.displacement())
    report.warning(
        of(*worst) +
        format_text("deforms by %.3g times its size at t = %.4g", worst->value, worst->t) + cause);
}

}  // namespace

void summarise(const BuiltScene& built, const RunResult& result, bool is_restarted,
               Report& report) {
  reached_lines(built, result, report);
  work_line(built, result, report);
  const Balance b = balance(result);
  balance_lines(built, result, b, report);
  const auto outside =
      built.simulation.is_static ? std::nullopt : energy_outside_basis(built, result);
  if (outside) report.line(text_of(*outside, built.momentum_is_kept));
  contact_lines(built, is_restarted, report);
  for (const std::string& note : built.notes) report.line("note: " + note);
  if (!is_energy_kept(built, result, b))
    report.warning(
        built.simulation.plan.newmark_alpha || built.simulation.is_static
            ? "the energy balance does not close"
            : "the energy balance does not close: the step may be above the critical one");
  steps_warning(built, result, report);
  distance_warning(built, report);
  energy_warning(built, result, report);
  if (const auto warning = outside ? warning_of(*outside) : std::nullopt) report.warning(*warning);
  rotation_warnings(built, result, report);
  strain_warnings(built, report);
}

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

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/summary/half_check.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

// Infinite of what is there in the second run only.
double share(double part, double whole) {
  if (!(part > 0)) return 0;
  return whole > 0 ? part / whole : std::numeric_limits<double>::infinity();
}

using Rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>;
Rows rows(const Series3& series) {
  return {series.values.data(), static_cast<Index>(series.values.size()) / 3, 3};
}

double rms(const Points& values) {
  return values.rows() > 0 ? std::sqrt(values.squaredNorm() / static_cast<double>(values.rows()))
                           : 0;
}

// Of what has changed since the first output.
double rms_motion(const Series3& series) {
  const Rows x = rows(series);
  return x.rows() > 0 ? rms(x.rowwise() - x.row(0)) : 0;
}

double rms_difference(const Series3& a, const Series3& b) { return rms(rows(a) - rows(b)); }

// A share that the round-off of two runs makes.
constexpr double nothing = 1e-9;

std::string percent(double value) { return format_text("%.2g %%", 100 * value); }

}  // namespace

double HalfDifference::largest() const {
  double share = std::max({position, velocity, energy});
  for (const OfBody& of : bodies) share = std::max({share, of.center, of.momentum, of.energy});
  return share;
}

HalfDifference half_difference(const RunResult& whole, const RunResult& half) {
  assert(whole.time.size() == half.time.size() && whole.bodies.size() == half.bodies.size());
  HalfDifference d;
  for (std::size_t i = 0; i < whole.monitors.size(); ++i) {
    const auto &a = whole.monitors[i], &b = half.monitors[i];
    HalfDifference::OfMonitor of;
    of.length = rms_difference(a.mean_position, b.mean_position);
    of.position = share(of.length, rms_motion(a.mean_position));
    of.velocity =
        share(rms_difference(a.mean_velocity, b.mean_velocity), rms(rows(a.mean_velocity)));
    d.position = std::max(d.position, of.position);
    d.velocity = std::max(d.velocity, of.velocity);
    d.monitors.push_back(of);
  }
  double largest = 0;
  for (std::size_t t = 0; t < whole.time.size(); ++t) {
    double total = 0;
    for (const auto& body : whole.bodies) total += body.kinetic_energy[t] + body.strain_energy[t];
    largest = std::max(largest, total);
  }
  for (std::size_t i = 0; i < whole.bodies.size(); ++i) {
    const auto &a = whole.bodies[i], &b = half.bodies[i];
    HalfDifference::OfBody of;
    of.center =
        share(rms_difference(a.center_of_mass, b.center_of_mass), rms_motion(a.center_of_mass));
    const Index last = static_cast<Index>(whole.time.size()) - 1;
    if (last >= 0)
      of.momentum = share((rows(a.momentum).row(last) - rows(b.momentum).row(last)).norm(),
                          rows(a.momentum).rowwise().norm().maxCoeff());
    for (std::size_t t = 0; t < whole.time.size(); ++t)
      of.energy = std::max({of.energy, std::abs(a.kinetic_energy[t] - b.kinetic_energy[t]),
                            std::abs(a.strain_energy[t] - b.strain_energy[t])});
    of.energy = share(of.energy, largest);
    d.energy = std::max(d.energy, of.energy);
    d.bodies.push_back(of);
  }
  return d;
}

void say_half_difference(const Simulation& simulation, const HalfDifference& d, Index modes_whole,
                         Index modes_half, Report& report) {
  report.line("check: the same steps with " + std::to_string(modes_half) + " of the " +
              std::to_string(modes_whole) + " modes differ by");
  for (std::size_t i = 0; i < d.monitors.size(); ++i)
    report.line("  " + simulation.monitors[i].name + ": position " +
                format_text("%.3g", d.monitors[i].length) + " (rms), " +
                percent(d.monitors[i].position) + " of its motion; velocity " +
                percent(d.monitors[i].velocity));
  for (std::size_t i = 0; i < d.bodies.size(); ++i)
    report.line("  instance " + simulation.bodies[i]->name() + ": centre of mass " +
                percent(d.bodies[i].center) + " of its motion; momentum at the end " +
                percent(d.bodies[i].momentum) + "; kinetic and strain energy up to " +
                percent(d.bodies[i].energy) + " of the largest total");
  if (d.largest() < nothing) {
    report.line(
        "  the modes left out take no part in this motion: nothing is shown of the run's own "
        "errors");
  } else {
    report.line(
        "  a difference and no bound: the run's own errors are below it where twice the modes at "
        "least halve them");
  }
  report.count("check_modes", static_cast<double>(modes_half));
  report.count("check_position_share", d.position);
  report.count("check_velocity_share", d.velocity);
  report.count("check_energy_share", d.energy);
}

}  // namespace cbr

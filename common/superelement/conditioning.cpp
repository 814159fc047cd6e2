// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/superelement/conditioning.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Beyond these a warning is due: four digits are left of sixteen; a mode in another; ten times the
// residual of modes that a basis uses; forces on a body that only moves.
constexpr double poor_condition = 1e12, poor_pivot = 1e-11, poor_modes = 1e-6, poor_residual = 1e-3,
                 poor_rigid = 1e-8;
// Of the stiffness against a motion beside that of its own diagonal: below it is a mechanism, or as
// good as one.
constexpr double no_stiffness = 1e-12;
// Of the largest eigenvalue's round-off: a lowest elastic one below it has less than three digits.
constexpr double few_digits = 1e3;

std::string known(double value) {
  return std::isnan(value) ? "not computed" : format_text("%.1e", value);
}

double hertz(double omega) { return omega / (2 * std::numbers::pi); }

int digits_lost(double condition) {
  return static_cast<int>(std::min(15L, std::lround(std::log10(std::max(condition, 1.0)))));
}

}  // namespace

bool is_without_stiffness(double softest) { return softest < no_stiffness; }

bool is_dependent(double orthogonality) { return !(orthogonality <= poor_modes); }

void report_conditioning(const Conditioning& c, Report& report, bool of_domain) {
  report.detail("condition of K_II: " + known(c.K_II.plain) + ", scaled by its diagonal " +
                known(c.K_II.scaled) + "; weakest pivot " + known(c.smallest_pivot) +
                (c.weakest.empty() ? "" : " at " + c.weakest));
  if (!of_domain)
    report.detail("condition of the reduced mass: " + known(c.mass.plain) +
                  ", scaled by its diagonal " + known(c.mass.scaled));
  report.detail((c.knows_modes() ? format_text("modes: Phi^T M Phi - I %.1e, residual %.1e; ",
                                               c.modes.orthogonality, c.modes.residual)
                                 : std::string("modes: not checked; ")) +
                (c.counts.empty() ? "no inertia counted" : "inertia counts " + c.counts));
  report.detail("rigid motions: forces of K " + known(c.rigid) + ", of the reduced K " +
                known(c.reduced_rigid));
  if (of_domain) return;
  if (c.rho_res)
    report.detail(format_text("rho_res x %.4f  y %.4f  z %.4f", (*c.rho_res)(0), (*c.rho_res)(1),
                              (*c.rho_res)(2)));
  if (c.knows_frequencies() && !(c.largest_omega > 0)) {
    report.detail(
        format_text("reduced frequencies: all %lld are 0", static_cast<long long>(c.n_zero)));
  } else if (c.knows_frequencies()) {
    report.detail(
        format_text("reduced frequencies: %lld are 0, lowest other %.6g Hz, highest %.6g Hz "
                    "(critical step %.4g s)",
                    static_cast<long long>(c.n_zero), hertz(c.lowest_omega), hertz(c.largest_omega),
                    2 / c.largest_omega));
  } else {
    report.detail(
        "reduced frequencies: not computed; the least stiffness against a motion that is not "
        "rigid, of its diagonal: " +
        known(c.softest));
  }
}

void warn_of_conditioning(const Conditioning& c, Report& report) {
  if (c.K_II.scaled > poor_condition || c.smallest_pivot < poor_pivot)
    report.warning(
        format_text("the stiffness of the interior is ill-conditioned (%.0e): about %d of 16 "
                    "digits are lost; ",
                    c.K_II.scaled, digits_lost(c.K_II.scaled)) +
        "look for slivers, thin parts, Poisson's ratio near 0.5, parts of very unlike stiffness" +
        (c.weakest.empty() ? "" : ", first at " + c.weakest));
  if (c.mass.scaled > poor_condition)
    report.warning(
        format_text("the reduced mass is ill-conditioned (%.0e): about %d of 16 digits are lost; ",
                    c.mass.scaled, digits_lost(c.mass.scaled)) +
        "keep fewer modes, or widen the interface: its nodes may hold the rest as a needle's point "
        "does, or be much lighter");
  if (c.modes.residual > poor_residual)
    report.warning(
        format_text("the fixed-interface modes are inaccurate (residual %.0e): look for the cause "
                    "in the stiffness of the interior, or ask for fewer modes",
                    c.modes.residual));
  const double rigid = std::fmax(c.rigid, c.reduced_rigid);  // the known one
  if (rigid > poor_rigid)
    report.warning(
        format_text("the stiffness resists rigid motions by %.0e of its size", rigid) +
        (c.rigid_node.empty() ? "" : ", most at " + c.rigid_node) +
        ": free bodies will not move freely; look for very thin or very distorted elements there");
  if (c.n_zero > c.n_rigid)
    report.warning(format_text("the reduced component has %lld motion%s without stiffness beside "
                               "its %lld rigid ones: a mechanism, which will "
                               "move freely, or a part too soft for a double beside the rest",
                               static_cast<long long>(c.n_zero - c.n_rigid),
                               c.n_zero - c.n_rigid == 1 ? "" : "s",
                               static_cast<long long>(c.n_rigid)) +
                   (c.loose_node.empty() ? "" : "; it moves most at " + c.loose_node));
  if (is_without_stiffness(c.softest))
    report.warning(
        format_text(
            "the reduced component has a motion without stiffness (%.0e of its diagonal) beside "
            "its rigid ones: a "
            "mechanism, which will move freely, or a part too soft for a double beside the rest",
            c.softest) +
        (c.loose_node.empty() ? "" : "; it moves most at " + c.loose_node));
  const double digits =
      c.lowest_omega * c.lowest_omega / (epsilon * c.largest_omega * c.largest_omega);
  if (c.lowest_omega > 0 && digits < few_digits)
    report.warning(format_text(
        "the lowest elastic frequency, %.4g Hz, is so far below the highest, %.4g Hz, that %s of "
        "its digits are right: use larger or less flat elements where they are stiffest",
        hertz(c.lowest_omega), hertz(c.largest_omega), digits < 10 ? "none" : "one or two"));
}

}  // namespace cbr

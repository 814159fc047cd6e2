// SPDX-License-Identifier: GPL-3.0-or-later
// Errors that are known before a run, in words.
#include <algorithm>
#include <cmath>
#include <string>

#include "common/format_text.hpp"

#include "reducer/accuracy.hpp"

namespace cbr {
namespace {

// "contact 0.1110, back 0.0549"; the largest four
template <typename Figure>
std::string of_surfaces(const Superelement::Accuracy& a, const char* pattern, Figure figure) {
  constexpr std::size_t most_named = 4;
  std::vector<std::pair<double, std::string>> list;
  for (const auto& [name, surface] : a.surfaces) list.emplace_back(figure(surface), name);
  std::stable_sort(list.begin(), list.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
  std::string text;
  for (std::size_t i = 0; i < std::min(list.size(), most_named); ++i)
    text += (text.empty() ? "" : ", ") + list[i].second + " " + format_text(pattern, list[i].first);
  if (list.size() > most_named) text += ", others less";
  return text;
}

void say_estimates(const Superelement::Accuracy& a, Report& report) {
  const Index m = a.frequency_hz.size();
  if (m == 0) return;
  const auto good = std::count_if(a.frequency_hz.begin(), a.frequency_hz.end(), [&](double f) { return f <= a.covered_hz; });
  // lambda (1 - error) is the exact one's at least
  const auto percent = [&](Index j) { return 100 * (1 - std::sqrt(std::max(0.0, 1 - a.eigenvalue_error(j)))); };
  std::string text = "  free modes   ";
  if (good > 0) {
    text += format_text("the lowest %lld, up to %.6g Hz, are right to 1 %% of their frequency", static_cast<long long>(good),
                        a.covered_hz);
    if (good < m) text += format_text(", the next at %.6g Hz to %.2g %%", a.frequency_hz(good), percent(good));
  } else {
    text += format_text("even the lowest, at %.6g Hz, may be too high by %.2g %% of it", a.frequency_hz(0), percent(0));
  }
  report.line(text + " (estimated)");
  for (Index j = 0; j < m; ++j)
    report.detail(format_text("free mode %lld: %.6g Hz, eigenvalue too high by %.2e", static_cast<long long>(j + 1),
                              a.frequency_hz(j), a.eigenvalue_error(j)));
}

}  // namespace

void say_accuracy(const Superelement& s, Report& report) {
  if (!s.accuracy) return;
  const Superelement::Accuracy& a = *s.accuracy;
  if (a.rho_floor)
    report.detail(format_text("rho_res with all modes: x %.4f  y %.4f  z %.4f, the mass of the interface's nodes",
                              (*a.rho_floor)(0), (*a.rho_floor)(1), (*a.rho_floor)(2)));
  const auto impact = [](const auto& of) { return of.impact; };
  if (std::any_of(a.surfaces.begin(), a.surfaces.end(), [&](const auto& of) { return impact(of.second) > 0; }))
    report.line("  flat impact  loses " + of_surfaces(a, "%.4f", impact) + " of the energy, without friction");
  std::string left =
      format_text("  left out     %.2g of the interior's strain energy under rigid accelerations", a.largest_left_out);
  if (!a.surfaces.empty()) left += "; under pressure: " + of_surfaces(a, "%.2g", [](const auto& of) { return of.strain_left_out; });
  if (a.tolerance > 0) left += format_text(" (tolerance %g)", a.tolerance);
  report.line(left);
  report.detail(format_text("left out along x %.2e  y %.2e  z %.2e, about x %.2e  y %.2e  z %.2e", a.strain_left_out(0),
                            a.strain_left_out(1), a.strain_left_out(2), a.strain_left_out(3), a.strain_left_out(4),
                            a.strain_left_out(5)));
  say_estimates(a, report);
  if (a.complete_hz > 0)
    report.line(format_text("  held modes   none is missing below %.6g Hz, the interface held", a.complete_hz));
}

}  // namespace cbr

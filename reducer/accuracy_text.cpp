// SPDX-License-Identifier: GPL-3.0-or-later
// Errors that are known before a run, in words.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/format_text.hpp"

#include "reducer/accuracy.hpp"

namespace cbr {
namespace {

constexpr double much_left_out = 0.01;

// Each face once, whatever the number of sets that it is: "contact", or "contact (also x_max)", by the name of the first.
std::map<std::string, std::string> named_once(const Superelement& s) {
  std::map<std::vector<Index>, std::string> first;
  std::map<std::string, std::string> text;
  for (const Surface& surface : s.surfaces) {
    if (s.accuracy->surfaces.count(surface.name) == 0) continue;
    const auto [known, is_new] = first.emplace(surface_nodes(surface), surface.name);
    if (is_new) {
      text[surface.name] = surface.name;
    } else {
      std::string& of = text[known->second];
      of = of.ends_with(')') && of != known->second ? of.substr(0, of.size() - 1) + ", " + surface.name + ")"
                                                    : of + " (also " + surface.name + ")";
    }
  }
  return text;
}

// "contact 0.1110, back 0.0549"; the largest four
template <typename Figure>
std::string of_surfaces(const Superelement& s, const char* pattern, Figure figure) {
  constexpr std::size_t most_named = 4;
  std::vector<std::pair<double, std::string>> list;
  for (const auto& [name, text] : named_once(s)) list.emplace_back(figure(s.accuracy->surfaces.at(name)), text);
  std::stable_sort(list.begin(), list.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
  std::string text;
  for (std::size_t i = 0; i < std::min(list.size(), most_named); ++i)
    text += (text.empty() ? "" : ", ") + list[i].second + " " + format_text(pattern, list[i].first);
  if (list.size() > most_named) text += ", others less";
  return text;
}

// Hz, of a frequency whose square is off by `error` of itself: too high, or the other way round.
double percent(double error) { return 100 * (error < 1 ? 1 - std::sqrt(1 - error) : std::sqrt(1 + error) - 1); }

void say_estimates(const Superelement& s, Report& report) {
  const Superelement::Accuracy& a = *s.accuracy;
  const Index m = a.frequency_hz.size();
  if (!s.has_interface_matrices() && !(s.eigenvalues.array() > 0).any())
    return report.line("  free modes   none but the rigid ones is kept");
  if (!a.worst_of_ten)
    return report.line(
        "  free modes   not estimated, as that takes the diagonal form (--diagonal-limit), and stiffness against all "
        "that is not rigid");
  const std::string ten = format_text("; of the ten lowest the worst to %.2g %%", percent(*a.worst_of_ten));
  if (m == 0)
    return report.line("  free modes   not known: the lowest is above the first held mode that is missing" + ten + " (estimated)");
  const auto good = std::count_if(a.frequency_hz.begin(), a.frequency_hz.end(), [&](double f) { return f <= a.covered_hz; });
  std::string text = "  free modes   ";
  if (good > 0) {
    text += format_text("the lowest %lld, up to %.6g Hz, are right to 1 %% of their frequency", static_cast<long long>(good),
                        a.covered_hz);
    if (good < m) text += format_text(", the next at %.6g Hz to %.2g %%", a.frequency_hz(good), percent(a.eigenvalue_error(good)));
  } else {
    text +=
        format_text("even the lowest, at %.6g Hz, may be off by %.2g %% of it", a.frequency_hz(0), percent(a.eigenvalue_error(0)));
  }
  report.line(text + (*a.worst_of_ten > much_left_out ? ten : "") + " (estimated)");
  for (Index j = 0; j < m; ++j)
    report.detail(format_text("free mode %lld: %.6g Hz, eigenvalue off by %.2e", static_cast<long long>(j + 1), a.frequency_hz(j),
                              a.eigenvalue_error(j)));
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
    report.line("  flat impact  loses " + of_surfaces(s, "%.4f", impact) + " of the energy, without friction");
  std::string left = format_text("  left out     %.2g of the strain energy that rigid accelerations of the interface bring inside",
                                 a.largest_left_out);
  if (a.tolerance > 0) left += format_text(" (tolerance %g)", a.tolerance);
  if (!a.surfaces.empty())
    left += "; of that by the motion that a pressure sets going: " +
            of_surfaces(s, "%.2g", [](const auto& of) { return of.strain_left_out; });
  if (a.tolerance == 0 && a.largest_left_out > much_left_out)
    left += std::string("; more modes lower it") + (s.has_interface_matrices() ? ", tolerance picks them" : "");
  report.line(left);
  report.detail(format_text("left out along x %.2e  y %.2e  z %.2e, about x %.2e  y %.2e  z %.2e", a.strain_left_out(0),
                            a.strain_left_out(1), a.strain_left_out(2), a.strain_left_out(3), a.strain_left_out(4),
                            a.strain_left_out(5)));
  say_estimates(s, report);
  if (a.complete_hz > 0)
    report.line(format_text("  held modes   none is missing below %.6g Hz, the interface held", a.complete_hz));
}

}  // namespace cbr

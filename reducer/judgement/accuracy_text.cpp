// SPDX-License-Identifier: GPL-3.0-or-later
// Errors that are known before a run, in words.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "common/base/format_text.hpp"

#include "reducer/judgement/accuracy.hpp"

namespace cbr {
namespace {

constexpr double much_left_out = 0.01;
constexpr Index n_listed = 6;  // frequencies
// Nodes on faces from which few shapes pay (README, "Which basis").
constexpr std::size_t many_face_nodes = 100;

using Lines = std::vector<SummaryLine>;

// Each face once, whatever the number of sets that it is: "contact", or "contact (also x_max)", by
// the name of the first.
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
      of = of.ends_with(')') && of != known->second
               ? of.substr(0, of.size() - 1) + ", " + surface.name + ")"
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
  for (const auto& [name, text] : named_once(s))
    list.emplace_back(figure(s.accuracy->surfaces.at(name)), text);
  std::stable_sort(list.begin(), list.end(),
                   [](const auto& l, const auto& r) { return l.first > r.first; });
  std::string text;
  for (std::size_t i = 0; i < std::min(list.size(), most_named); ++i)
    text += (text.empty() ? "" : ", ") + list[i].second + " " + format_text(pattern, list[i].first);
  if (list.size() > most_named) text += ", others less";
  return text;
}

// Hz, of a frequency whose square is off by `error` of itself: too high, or the other way round.
double percent(double error) {
  return 100 * (error < 1 ? 1 - std::sqrt(1 - error) : std::sqrt(1 + error) - 1);
}

// "the lowest 8, up to 1234 Hz, are within 1 %": of this mesh's own, with this mass.
void add_estimates(const Superelement& s, Lines& lines) {
  const Superelement::Accuracy& a = *s.accuracy;
  const Index m = a.frequency_hz.size();
  const auto add = [&](const std::string& text) { lines.push_back({"  free modes   " + text}); };
  if (!s.has_interface_matrices() && !(s.eigenvalues.array() > 0).any())
    return add("none but the rigid ones is kept");
  if (!a.worst_of_ten)
    return add(
        "not estimated, as that takes the diagonal form (--diagonal-limit), and stiffness against "
        "all that is not rigid");
  const std::string ten =
      format_text("; of the ten lowest the worst to %.2g %%", percent(*a.worst_of_ten));
  if (m == 0)
    return add("not known: the lowest is above the first held mode that is missing" + ten +
               " (estimated)");
  const auto good = std::count_if(a.frequency_hz.begin(), a.frequency_hz.end(),
                                  [&](double f) { return f <= a.covered_hz; });
  std::string text;
  if (good > 0) {
    text = format_text("the lowest %lld, up to %.6g Hz, are right to 1 %%",
                       static_cast<long long>(good), a.covered_hz);
    if (good < m)
      text += format_text(", the next at %.6g Hz to %.2g %%", a.frequency_hz(good),
                          percent(a.eigenvalue_error(good)));
  } else {
    text = format_text("even the lowest, at %.6g Hz, may be off by %.2g %%", a.frequency_hz(0),
                       percent(a.eigenvalue_error(0)));
  }
  add(text + (*a.worst_of_ten > much_left_out ? ten : "") +
      " (estimated, against this mesh with this mass; aim: 1 % of the ten lowest)");
  for (Index j = 0; j < m; ++j)
    lines.push_back(
        {format_text("free mode %lld: %.6g Hz, eigenvalue off by %.2e",
                     static_cast<long long>(j + 1), a.frequency_hz(j), a.eigenvalue_error(j)),
         true});
}

std::string left_out_text(const Superelement& s) {
  const Superelement::Accuracy& a = *s.accuracy;
  std::string text = format_text(
      "  left out     modes miss %.2g %% of the interior's strain energy under acceleration (aim: "
      "below %g %%",
      100 * a.largest_left_out, 100 * (a.tolerance > 0 ? a.tolerance : much_left_out));
  text += a.tolerance > 0 ? ", the tolerance)" : ")";
  if (a.tolerance == 0 && a.largest_left_out > much_left_out)
    text += std::string("; more modes lower it") +
            (s.has_interface_matrices() ? ", tolerance picks them" : "");
  return text;
}

// "33421, 35560 Hz": the lowest six of those above 0; empty without any.
std::string listed(std::vector<double> omega) {
  std::sort(omega.begin(), omega.end());
  std::string text;
  Index n = 0;
  for (const double w : omega) {
    if (!(w > 0) || n == n_listed) continue;
    text += (n++ == 0 ? "" : ", ") + format_text("%.6g", w / (2 * std::numbers::pi));
  }
  return text.empty() ? text : text + " Hz";
}

std::vector<double> roots(const Vector& lambda) {
  std::vector<double> omega;
  for (const double value : lambda) omega.push_back(value > 0 ? std::sqrt(value) : 0);
  return omega;
}

}  // namespace

std::vector<SummaryLine> frequency_lines(const Superelement& s) {
  Lines lines;
  const auto add = [&](const std::string& label, const std::string& list) {
    if (!list.empty()) lines.push_back({label + list});
  };
  const std::string of_part = std::string("  free         first elastic frequencies of the ") +
                              (s.fixed.any() ? "part with its fixed dofs: " : "free part: ");
  if (s.fixed.any())
    lines.push_back({"  fixed        " + std::to_string(s.fixed.resisted.rows()) +
                     " of the six rigid motions; fixed dofs are not among those of the interface"});
  if (s.has_interface_matrices()) {
    add("  held         first frequencies with the interface held: ",
        listed(roots(s.eigenvalues.head(s.k() - s.n_residual))));
    add(of_part, listed({s.omega.begin(), s.omega.end()}));
  } else {
    add(of_part, listed(roots(s.eigenvalues)));
  }
  return lines;
}

std::vector<SummaryLine> statics_lines(const std::vector<Index>& nodes, bool in_levels) {
  if (nodes.empty()) return {};
  std::map<Index, int> entries;
  for (const Index node : nodes) ++entries[node];
  const auto n_all = std::count_if(entries.begin(), entries.end(),
                                   [](const auto& node) { return node.second == 3; });
  const auto n_normal = static_cast<std::ptrdiff_t>(entries.size()) - n_all;
  std::string text =
      format_text("  statics      %s at %zu nodes that may touch, ",
                  in_levels ? "of single nodes to some 2 %, of patches to some 0.2 %," : "in full",
                  entries.size());
  if (n_all == 0)
    text += "normal to their faces: for contact without friction";
  else if (n_normal == 0)
    text += "in all directions";
  else
    text += format_text(
        "in all directions at %td of them, for friction, and normal to their faces "
        "at the other %td",
        n_all, n_normal);
  return {{text}};
}

namespace {

// A node with six dofs.
bool is_point(const Superelement& s, const std::vector<Index>& nodes) {
  for (std::size_t i = 0; nodes.size() == 1 && i < s.dof_node.size(); ++i)
    if (s.dof_node[i] == nodes.front() && s.dof_component[i] > 2) return true;
  return false;
}

}  // namespace

std::string sets_text(const Superelement& s) {
  std::string text;
  for (const auto& surface : s.surfaces)
    text += (text.empty() ? "" : ", ") + surface.name + " (" + std::to_string(surface.n_faces()) +
            " faces)";
  for (const auto& [name, nodes] : s.nodesets)
    text += (text.empty() ? "" : ", ") + name +
            (is_point(s, nodes) ? " (point)" : " (" + std::to_string(nodes.size()) + " nodes)");
  return text.empty() ? "none" : text;
}

std::string advice_on_basis(const Superelement& s) {
  if (s.is_characteristic() || s.is_massless()) return "";
  std::set<Index> nodes;
  for (const Surface& surface : s.surfaces) {
    const std::vector<Index> of_one = surface_nodes(surface);
    nodes.insert(of_one.begin(), of_one.end());
  }
  if (nodes.size() < many_face_nodes) return "";
  return "all " + std::to_string(nodes.size()) +
         " nodes of faces are kept one by one; with basis: characteristic contact without friction "
         "usually steps two to six times faster (README, \"Which basis\")";
}

std::vector<SummaryLine> accuracy_lines(const Superelement& s) {
  Lines lines;
  if (!s.accuracy) return lines;
  const Superelement::Accuracy& a = *s.accuracy;
  if (a.rho_floor)
    lines.push_back(
        {format_text(
             "rho_res with all modes: x %.4f  y %.4f  z %.4f, the mass of the interface's nodes",
             (*a.rho_floor)(0), (*a.rho_floor)(1), (*a.rho_floor)(2)),
         true});
  if (std::any_of(a.surfaces.begin(), a.surfaces.end(),
                  [](const auto& of) { return of.second.impact > 0; }))
    lines.push_back({"  flat impact  a body that lands flat loses of its energy at " +
                     of_surfaces(s, "%.1f %%", [](const auto& of) { return 100 * of.impact; }) +
                     " (good: below 5 %; warned of above 20 %)"});
  lines.push_back({left_out_text(s)});
  if (!a.surfaces.empty())
    lines.push_back(
        {"left out of the motion that a pressure sets going: " +
             of_surfaces(s, "%.2g %%", [](const auto& of) { return 100 * of.strain_left_out; }),
         true});
  lines.push_back(
      {format_text("left out along x %.2e  y %.2e  z %.2e, about x %.2e  y %.2e  z %.2e",
                   a.strain_left_out(0), a.strain_left_out(1), a.strain_left_out(2),
                   a.strain_left_out(3), a.strain_left_out(4), a.strain_left_out(5)),
       true});
  add_estimates(s, lines);
  if (a.complete_hz > 0)
    lines.push_back(
        {format_text("  held modes   all below %.6g Hz are kept, the interface held (good: above "
                     "what excites the part)",
                     a.complete_hz)});
  return lines;
}

void say_accuracy(const Superelement& s, Report& report) {
  for (const SummaryLine& line : accuracy_lines(s))
    line.detail ? report.detail(line.text) : report.line(line.text);
}

}  // namespace cbr

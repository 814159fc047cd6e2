// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/summary.hpp"

#include <cstdio>
#include <string>

namespace cbr {
namespace {

// More than this of the energy lost in a flat impact is worth a warning.
constexpr double large_residual_mass = 0.2;

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

std::string modes_text(const Superelement& s, const ReductionFigures& figures) {
  if (s.k() == 0) return "none kept: static condensation";
  std::string text = std::to_string(s.k()) + " kept";
  if (figures.n_candidates > s.k()) text += " of the lowest " + std::to_string(figures.n_candidates);
  text += ", the highest at " + format("%.6g", figures.highest_frequency) + " Hz (" + figures.mode_method;
  if (figures.mode_method != "lapack") text += figures.modes_proven ? ", none missed by the inertia count" : ", not counted";
  return text + ")";
}

std::string sets_text(const Superelement& s) {
  std::string text;
  for (const auto& surface : s.surfaces) {
    text += (text.empty() ? "" : ", ") + surface.name + " (" + std::to_string(surface.n_faces()) + " faces)";
  }
  for (const auto& [name, nodes] : s.nodesets) {
    text += (text.empty() ? "" : ", ") + name + " (" + std::to_string(nodes.size()) + " nodes)";
  }
  return text.empty() ? "none" : text;
}

void say_residual_mass(const Superelement& s, Report& report) {
  const Vector3 rho = residual_mass_share(s);
  report.line(format("  rho_res      x %.4f  y %.4f  z %.4f: a flat impact in that direction loses this share of its energy",
                     rho(0), rho(1), rho(2)));
  if (rho.maxCoeff() > large_residual_mass) {
    report.warning(
        format("much mass is left on the interface (rho_res up to %.2f): contact in that direction will lose energy; keep "
               "more modes, or pick them by participation",
               rho.maxCoeff()));
  }
}

}  // namespace

void summarise(const Superelement& s, const ReductionFigures& figures, const std::filesystem::path& file, Report& report) {
  report.line(format("  dofs         %lld in full, %lld on the interface (%zu nodes), %lld modes, %lld reduced",
                     static_cast<long long>(figures.n_dofs), static_cast<long long>(s.c()), s.node_ids.size(),
                     static_cast<long long>(s.k()), static_cast<long long>(s.n())));
  report.line("  modes        " + modes_text(s, figures));
  say_residual_mass(s, report);
  const auto& b = s.rigid_body;
  report.line(format("  mass         %.9g, centre (%.6g, %.6g, %.6g)", b.mass, b.center(0), b.center(1), b.center(2)));
  report.line(format("  inertia      xx %.6g  yy %.6g  zz %.6g  xy %.6g  yz %.6g  xz %.6g", b.inertia(0, 0), b.inertia(1, 1),
                     b.inertia(2, 2), b.inertia(0, 1), b.inertia(1, 2), b.inertia(0, 2)));
  report.line("  sets kept    " + sets_text(s));
  const bool panels = figures.way == CondensationWay::second_solve;
  report.detail(format("factor: %.3g non-zeros, %.3g flops; solves %.3g flops; products %.3g flops", figures.factor_nonzeros,
                       figures.factor_flops, figures.solve_flops, figures.product_flops));
  report.detail(panels ? "constraint modes in panels of " + std::to_string(figures.panel) + " columns"
                       : "constraint modes held whole");
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  report.line("  file         " + file.string() + (error ? "" : ", " + human_bytes(static_cast<double>(size))) + ", " +
              (s.has_diagonal_form() ? "with diagonal form" : "without diagonal form") +
              (s.recovery.empty() ? "" : ", with recovery"));
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/component_reducer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "reducer/estimate/estimate.hpp"
#include "reducer/judgement/accuracy.hpp"

namespace cbr {
namespace {

// More than this of the energy lost in a flat impact is worth a warning.
constexpr double large_residual_mass = 0.2;
// Of a moment of inertia: largest excess by lumping without a remark.
constexpr double much_excess = 0.01;
constexpr double same_inertia = 1e-6;  // share

Index fixed_modes(const Superelement& s, const ReductionFigures& figures) {
  return s.is_characteristic() ? figures.characteristic.n_fixed : s.k() - s.n_residual;
}

std::string modes_text(const Superelement& s, const ReductionFigures& figures) {
  const Index own = fixed_modes(s, figures);
  if (own == 0) return "none kept: static condensation";
  std::string text = std::to_string(own) + " kept";
  if (figures.n_candidates > own) text += " of the lowest " + std::to_string(figures.n_candidates);
  text += ", the highest at " + format_text("%.6g", figures.highest_frequency) + " Hz";
  const bool proven = figures.mode_method == "lapack" || figures.modes_proven;
  return text + (proven ? ", none missed" : ", not proven that none is missed");
}

void say_loads(const Superelement& s, Report& report) {
  if (s.loads.empty()) return;
  std::string names;
  for (const auto& [name, load] : s.loads) names += (names.empty() ? "" : ", ") + name;
  report.line("  loads        on " + names + " inside the part: " + std::to_string(s.n_residual) +
              " residual vectors beside the modes");
}

bool has_points(const Superelement& s) {
  return std::any_of(s.dof_component.begin(), s.dof_component.end(),
                     [](int component) { return component > 2; });
}

// Of the faces that are nearly flat, where that is known, or else all of the interface stopped at
// once.
void warn_of_residual_mass(const Vector3& rho, const Superelement& s, Report& report) {
  if (s.surfaces.empty() && has_points(s)) return;  // which nothing can touch
  double most = 0;
  std::string face;
  if (s.accuracy)
    for (const auto& [name, surface] : s.accuracy->surfaces)
      if (surface.impact > most) {
        most = surface.impact;
        face = name;
      }
  if ((face.empty() ? rho.maxCoeff() : most) <= large_residual_mass) return;
  const std::string what = face.empty() ? "contact will lose energy"
                                        : "a flat impact of " + face +
                                              format_text(" will lose %.2f of its energy", most);
  // All modes are not enough where the mesh's own mass lies on the interface
  const double floor = s.accuracy && s.accuracy->rho_floor ? s.accuracy->rho_floor->maxCoeff() : 0;
  const bool modes_help = rho.maxCoeff() > 1.1 * floor;
  report.warning(
      format_text(
          "much mass is left on the interface (rho_res up to %.2f, if all of it stops at once): ",
          rho.maxCoeff()) +
      what +
      (modes_help ? "; keep more modes, or pick them by participation"
                  : format_text("; all modes would leave %.2f, which is the mass of the "
                                "interface's own nodes: refine the "
                                "mesh at the interface, or keep fewer faces",
                                floor)));
}

void say_residual_mass(const Vector3& rho, const Superelement& s, const ComponentMass& mass,
                       Report& report) {
  report.line(
      format_text("  rho_res      x %.4f  y %.4f  z %.4f: share of a body's energy of motion along "
                  "x, y, z that is lost when its whole interface stops at once (good: below 0.05)",
                  rho(0), rho(1), rho(2)));
  if (!mass.is_static) warn_of_residual_mass(rho, s, report);
}

// Free modes are exact, but for the taper at the interface.
void say_free_modes(const Superelement& s, const MasslessFigures& m, Report& report) {
  const Vector lambda = s.eigenvalues.tail(s.k() - m.n_rigid);
  if (!s.accuracy || lambda.size() == 0) return;
  report.line(format_text(
      "  free modes   %lld elastic ones up to %.6g Hz, exact; none is missing below %.6g Hz; "
      "answers to constant forces on the interface are exact",
      static_cast<long long>(lambda.size()), s.accuracy->covered_hz, s.accuracy->complete_hz));
  if (m.share.size() == 0) return;
  Index half = 0;
  while (half < m.share.size() && m.share(half) >= 0.5) ++half;
  std::string text = format_text(
      "  tapered      at the interface the lowest keeps %.4f of its compliance", m.share(0));
  if (half > 0)
    text += format_text(", half or more up to %.6g Hz",
                        std::sqrt(lambda(half - 1)) / (2 * std::numbers::pi));
  report.line(text + format_text(", the last %.4f; the rest of it answers at once",
                                 m.share(m.share.size() - 1)));
}

void say_massless(const Superelement& s, const MasslessFigures& m, Report& report) {
  report.line(
      format_text("  massless     %lld of the modes rigid; x %.4f  y %.4f  z %.4f: of the "
                  "compliance under a uniform load this is left to an interface without inertia",
                  static_cast<long long>(m.n_rigid), m.left(0), m.left(1), m.left(2)));
  report.line(format_text(
      "  step         highest frequency %.6g Hz with the interface held: critical step %.4g",
      s.massless.omega_closed / (2 * std::numbers::pi), 2 / s.massless.omega_closed));
  say_free_modes(s, m, report);
}

void say_characteristic(const Superelement& s, const ReductionFigures& figures, Report& report) {
  const CharacteristicFigures& c = figures.characteristic;
  const auto count = [](Index n) { return static_cast<long long>(n); };
  std::string text =
      format_text(c.free_modes ? "  interface    moves as in %lld modes of the free component"
                               : "  interface    %lld of its own modes",
                  count(c.n_modes));
  if (c.n_modes > 0) text += format_text(" up to %.6g Hz", c.highest / (2 * std::numbers::pi));
  text += c.n_kept > 0 ? format_text(", %lld dofs kept", count(c.n_kept))
                       : format_text(", %lld rigid motions", count(c.n_rigid));
  if (c.n_uniform + c.n_dropped > 0)
    text += format_text(", %lld responses to uniform pressures", count(c.n_uniform));
  if (c.n_loads > 0)
    text += format_text(
        c.n_kept > 0 ? ", %lld to loads and inertia" : ", %lld to the scene's loads and histories",
        count(c.n_loads));
  if (c.n_dropped > 0)
    text += format_text(" (%lld more are in the span of the others)", count(c.n_dropped));
  report.line(text);
  report.line(format_text("  step         highest frequency %.6g Hz: critical step %.4g",
                          std::sqrt(s.eigenvalues.maxCoeff()) / (2 * std::numbers::pi),
                          2 / std::sqrt(s.eigenvalues.maxCoeff())));
  if (!std::isnan(figures.shapes_error))
    report.line(
        format_text("  shapes       put the ten lowest free frequencies up to %.2g %% of them "
                    "above craig-bampton's of the same modes",
                    100 * (1 - std::sqrt(1 - std::clamp(figures.shapes_error, 0.0, 1.0)))));
  const StaticShare& statics = s.characteristic.statics;
  for (const SummaryLine& line : statics_lines(statics.node, !statics.levels.empty()))
    report.line(line.text);
  if (!c.bare.empty())
    report.line("  no statics   " + join(c.bare) +
                ": what is to act there must be in the scene that is reduced, or the sideset in "
                "characteristic.statics");
}

// The most that a lumped moment of inertia is above the geometry's, of itself.
double excess(const RigidBody& lumped, const RigidBody& geometry) {
  double most = 0;
  for (int i = 0; i < 3; ++i)
    if (geometry.inertia(i, i) > 0)
      most = std::max(most, lumped.inertia(i, i) / geometry.inertia(i, i) - 1);
  return most;
}

std::string inertia_text(const Matrix3& I) {
  return format_text("xx %.6g  yy %.6g  zz %.6g  xy %.6g  yz %.6g  xz %.6g", I(0, 0), I(1, 1),
                     I(2, 2), I(0, 1), I(1, 2), I(0, 2));
}

void say_rigid_body(const RigidBody& b, const ComponentMass& mass, Report& report) {
  const bool lumped = mass.kind == MassKind::lumped;
  report.line(format_text("  mass         %.9g, centre (%.6g, %.6g, %.6g), ", b.mass, b.center(0),
                          b.center(1), b.center(2)) +
              (lumped ? "lumped at the nodes" : "consistent"));
  const bool is_geometrys = !lumped || excess(b, mass.geometry) < same_inertia;
  report.line("  inertia      " + inertia_text(b.inertia) +
              (is_geometrys ? " (that of the geometry)" : " (of the lumped mass)"));
  if (is_geometrys) return;
  report.line("  geometry     " + inertia_text(mass.geometry.inertia) +
              format_text(": lumping adds up to %.2g %%", 100 * excess(b, mass.geometry)));
  if (excess(b, mass.geometry) > much_excess)
    report.line(
        "  note         lumped mass makes frequencies of quadratic and coarse meshes low and "
        "inertia high; mass: consistent has the geometry's inertia");
}

// Other programs print frequencies of consistent mass.
void say_mass_shift(const Vector& shift, const std::string& of, Report& report) {
  std::string list;
  for (const double share : shift)
    list += (list.empty() ? "" : ", ") + format_text("%.2g", 100 * share);
  if (!list.empty())
    report.line("  mass shift   consistent mass, as of most other programs, would put the first " +
                of + " up by " + list + " %");
}

// A domain holds its shared nodes, too.
void say_mass_shift_of_domains(const GroupFigures& f, Report& report) {
  Vector highest;
  for (const DomainFigures& domain : f.domains) {
    const Vector& shift = domain.reduction.mass_shift;
    if (shift.size() > 0 && (highest.size() == 0 || shift(0) > highest(0))) highest = shift.head(1);
  }
  say_mass_shift(highest,
                 "frequency of the domain that changes most, its interface held (those of the "
                 "whole, of longer waves, change less),",
                 report);
}

void say_file(const std::filesystem::path& file, bool diagonal, bool recovery, Report& report) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  report.line("  file         " + file.string() +
              (error ? "" : ", " + human_bytes(static_cast<double>(size))) + ", " +
              (diagonal ? "with diagonal form" : "without diagonal form") +
              (recovery ? ", with recovery" : ""));
}

// "12 to 15", or "12" when they are equal.
template <typename Figure>
std::string range_text(const GroupFigures& figures, Figure figure) {
  Index least = figure(0), most = least;
  for (std::size_t d = 0; d < figures.domains.size(); ++d) {
    least = std::min(least, figure(d));
    most = std::max(most, figure(d));
  }
  return std::to_string(least) + (most > least ? " to " + std::to_string(most) : "");
}

void say_missing_modes(const SuperelementGroup& group, const GroupFigures& figures,
                       Report& report) {
  std::string text;
  for (std::size_t d = 0; d < figures.domains.size(); ++d) {
    if (figures.domains[d].modes_missing == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(d + 1) + " (" +
            std::to_string(group.domains[d].k()) + ")";
  }
  if (!text.empty())
    report.line(
        "  note         fewer interior dofs than modes asked for, so all are kept, in domain " +
        text);
}

void count_work(const ReductionFigures& figures, Report& report) {
  report.count("dofs", static_cast<double>(figures.n_dofs));
  report.count("interior_dofs", static_cast<double>(figures.n_interior));
  report.count("mode_candidates", static_cast<double>(figures.n_candidates));
  report.count("factor_nonzeros", figures.factor_nonzeros);
  report.count("factor_flops", figures.factor_flops);
  report.count("solve_flops", figures.solve_flops);
  report.count("product_flops", figures.product_flops);
  report.count("front_flops", figures.front_flops);
}

std::string way_text(const ReductionFigures& figures) {
  if (figures.way == CondensationWay::fronts)
    return "condensed with the factorisation, front by front";
  if (figures.way == CondensationWay::product) return "constraint modes held whole";
  return "constraint modes in panels of " + std::to_string(figures.panel) + " columns";
}

void warn_of_cost(const Superelement& s, const ReductionFigures& figures, const ComponentMass& mass,
                  Report& report) {
  std::set<Index> nodes;
  for (const Surface& surface : s.surfaces)
    if (mass.touching.count(surface.name) > 0)
      for (const Index node : surface_nodes(surface)) nodes.insert(node);
  const double own = bytes_in_contact(static_cast<double>(s.n()),
                                      3 * static_cast<double>(nodes.size())),
               mesh = bytes_of_mesh(figures.mesh_nonzeros, static_cast<double>(figures.n_dofs));
  if (!s.has_interface_matrices() || figures.mesh_nonzeros == 0 || !(own > many_bytes * mesh))
    return;
  report.warning(
      format_text(
          "a step in contact reads %.2g times the bytes of a step of its mesh, as %zu nodes "
          "of faces that may touch are kept one by one: take as: mesh, which is likely "
          "faster where contact lasts, or fewer faces",
          own / mesh, nodes.size()) +
      (has_points(s) ? "" : ", or basis: characteristic"));
}

}  // namespace

void summarise(const Superelement& s, const ReductionFigures& figures, const ComponentMass& mass,
               const std::filesystem::path& file, Report& report) {
  count_work(figures, report);
  report.count("interface_dofs", static_cast<double>(s.c()));
  report.count("modes", static_cast<double>(s.k()));
  report.line(format_text(
      "  dofs         %lld in full, %lld on the interface (%zu nodes), %lld modes, %lld reduced",
      static_cast<long long>(figures.n_dofs), static_cast<long long>(s.c()), s.node_ids.size(),
      static_cast<long long>(fixed_modes(s, figures)), static_cast<long long>(s.n_coordinates())));
  report.line("  modes        " + modes_text(s, figures));
  report.detail("modes by " + figures.mode_method);
  for (const SummaryLine& line : frequency_lines(s)) report.line(line.text);
  say_loads(s, report);
  if (s.is_characteristic()) say_characteristic(s, figures, report);
  if (s.is_massless()) {
    say_massless(s, figures.massless, report);
  } else {
    say_residual_mass(s.is_characteristic() ? figures.characteristic.rho : residual_mass_share(s),
                      s, mass, report);
    say_accuracy(s, report);
  }
  say_rigid_body(s.rigid_body, mass, report);
  say_mass_shift(figures.mass_shift,
                 s.is_massless() ? "elastic frequencies" : "frequencies with the interface held",
                 report);
  report.line("  sets kept    " + sets_text(s));
  report.detail(format_text(
      "factor: %.3g non-zeros, %.3g flops; solves %.3g flops; products %.3g flops",
      figures.factor_nonzeros, figures.factor_flops, figures.solve_flops, figures.product_flops));
  report.detail(way_text(figures));
  say_file(file, s.has_diagonal_form(), !s.recovery.empty(), report);
  if (const std::string advice = advice_on_basis(s); !advice.empty())
    report.line("  note         " + advice);
  warn_of_cost(s, figures, mass, report);
}

void summarise_domains(const SuperelementGroup& group, const GroupFigures& f,
                       const std::optional<Vector3>& rho, const ComponentMass& mass,
                       Report& report) {
  const auto of = [&](auto figure) { return range_text(f, figure); };
  report.line("  domains      " + std::to_string(f.domains.size()) + " of " +
              of([&](std::size_t d) { return f.domains[d].n_elements; }) +
              " elements, reduced in " + human_seconds(f.seconds) + " by " +
              (f.n_processes > 1 ? std::to_string(f.n_processes) + " processes of " : "") +
              std::to_string(f.n_workers) + (f.n_workers > 1 ? " threads" : " thread"));
  Index k = 0;
  for (const auto& domain : group.domains) k += domain.k();
  const auto c = 3 * static_cast<Index>(join_nodes(group).node_ids.size());
  report.line("  dofs         " + std::to_string(f.n_dofs) + " in full; each domain " +
              of([&](std::size_t d) { return group.domains[d].c(); }) + " on its interface and " +
              of([&](std::size_t d) { return group.domains[d].k(); }) + " modes; " +
              std::to_string(f.n_shared_nodes) + " nodes shared");
  report.line("  joined       " + std::to_string(k) + " modes, " + std::to_string(c) +
              " dofs of nodes, " + std::to_string(k + c) + " reduced");
  say_missing_modes(group, f, report);
  if (rho) say_residual_mass(*rho, {}, mass, report);
  say_mass_shift_of_domains(f, report);
  report.line(
      "  errors       of what the domains make together are not estimated, neither its frequencies "
      "nor its flat impacts: compare with twice the modes, or with domains: 1; rigid motion and "
      "answers to constant forces on the interface are exact");
  for (std::size_t d = 0; d < f.domains.size(); ++d) {
    report.detail(format_text("domain %zu: %lld elements, %lld interior dofs, c %lld, k %lld, "
                              "factor %.3g non-zeros, ",
                              d + 1, static_cast<long long>(f.domains[d].n_elements),
                              static_cast<long long>(f.domains[d].reduction.n_interior),
                              static_cast<long long>(group.domains[d].c()),
                              static_cast<long long>(group.domains[d].k()),
                              f.domains[d].reduction.factor_nonzeros) +
                  f.domains[d].reduction.mode_method);
  }
}

void summarise_group(const SuperelementGroup& group, const ComponentMass& mass,
                     const std::filesystem::path& file, Report& report) {
  say_rigid_body(group.rigid_body, mass, report);
  Superelement described;
  JoinedNodes joined = join_nodes(group);
  described.surfaces = std::move(joined.surfaces);
  described.nodesets = std::move(joined.nodesets);
  report.line("  sets kept    " + sets_text(described));
  const bool recovery = !group.domains.empty() && !group.domains.front().recovery.empty();
  say_file(file, group.has_diagonal_form(), recovery, report);
}

}  // namespace cbr

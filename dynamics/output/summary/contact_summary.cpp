// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/summary/summary.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/base/format_text.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/setup/built/instance_elements.hpp"

namespace cbr {
namespace {

// "1 step", "2 steps"
std::string counted(Index n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

// Largest initial penetration, 0 within round-off.
double initial_overlap(const ContactPair& pair) {
  const PairState& state = pair.seen();
  const double overlap = std::max(
      {state.memory.initial_overlap, state.back.initial_overlap, state.edges.initial_overlap});
  return overlap > 1e-10 * pair.master->size ? overlap : 0;
}

// Of contact, within its reach, else of the gap watch, as mortar's is a mean. HUGE_VAL: not known.
double initial_gap(const BuiltScene& built, Index p) {
  const ContactPair& pair = built.simulation.pairs[p];
  const double seen = pair.seen().memory.initial_gap;
  const bool is_known = std::isfinite(seen) && pair.formulation != Formulation::mortar;
  return is_known ? seen : built.gaps.initial(built.simulation, p).value_or(seen);
}

// Mortar may see no overlap where an edge or a corner goes in.
bool has_touched(const ContactPair& pair) {
  return pair.seen().has_touched || initial_overlap(pair) > 0 ||
         pair.seen().penetration > 1e-10 * pair.master->size;
}

// Penetration relative to a face. A hard constraint has none at its points, but may between them.
double share_of_face(const ContactPair& pair) {
  const double face = std::min(pair.slave->size, pair.master->size);
  return face > 0 ? pair.seen().penetration / face : 0;
}

std::string unknowns_text(const PairState& state) {
  return format_text(
      "; %.0f unknown pressures in the mean, %td at most",
      static_cast<double>(state.n_unknowns) / static_cast<double>(state.n_function_steps),
      static_cast<std::ptrdiff_t>(state.most_unknowns));
}

// Each figure is followed by its good range.
std::string penetration_text(const ContactPair& pair) {
  const double depth = pair.seen().penetration, share = 100 * share_of_face(pair);
  std::string text = format_text(", largest penetration %.3g, %.2g %% of a face", depth, share);
  if (pair.seen().n_function_steps > 0) return text + unknowns_text(pair.seen());
  return text + " (good: below 1 %)";
}

// "contact a - b: never touched; the nearest gap at an output was 0.2; initial gap 0.3"
std::string apart_line(const BuiltScene& built, Index p, bool is_restarted) {
  const ContactPair& pair = built.simulation.pairs[p];
  const auto nearest = built.gaps.nearest(built.simulation, p),
             initial = built.gaps.initial(built.simulation, p);
  std::string text = "contact " + pair.name;
  // As in statics whose first load step failed
  if (nearest && *nearest <= 1e-10 * pair.slave->size) return text + ": touched without a force";
  text += ": never touched";
  if (!nearest || !initial) return text;
  text += format_text("; the nearest gap at an output was %.3g", *nearest);
  if (is_restarted) text += " (since the restart)";
  return text + format_text("; initial gap %.3g", *initial);
}

std::string contact_line(const BuiltScene& built, Index p) {
  const ContactPair& pair = built.simulation.pairs[p];
  std::ostringstream line;
  line.precision(3);
  if (pair.is_link) {
    line << "link " << pair.name << ": residual " << pair.seen().residual << " (good: below 1e-6)";
    return line.str();
  }
  line << "contact " << pair.name << ": "
       << counted(static_cast<Index>(pair.slave->nodes.size()), "slave node") << " of "
       << pair.slave->name;
  if (pair.law.law == ContactLaw::tied) {
    const Index n = static_cast<Index>(pair.slave->nodes.size()),
                free = pair.has_state() ? pair.seen().tie_report.without_partner : n;
    line << ", " << counted(pair.seen().tie_report.n_points, "point")
         << " tied, largest offset " << pair.seen().tie_report.largest_offset << ", "
         << counted(free, "node") << " left free";
  }
  line << ", " << word_of(formulation_words, pair.formulation) << ", "
       << word_of(enforcement_words, pair.enforcement);
  if (pair.law.law == ContactLaw::coulomb)
    line << ", friction " << pair.law.friction << (pair.friction.varies() ? " at rest" : "");
  if (pair.restitution > 0) line << ", restitution " << pair.restitution;
  if (pair.penalty.damping > 0) line << ", damping " << pair.penalty.damping;
  line << "; largest area in contact " << pair.seen().largest_area;
  if (pair.law.law != ContactLaw::tied) line << penetration_text(pair);
  if (pair.enforcement == Enforcement::impulse)
    line << ", residual " << pair.seen().residual << " (good: below 1e-6)";
  if (initial_overlap(pair) > 0) line << "; initial overlap " << initial_overlap(pair);
  // Surfaces that touch or overlap have no gap, however distant their other nodes are.
  if (initial_overlap(pair) > 0) return line.str();
  const double gap = initial_gap(built, p);
  if (gap > 0 && std::isfinite(gap)) line << "; initial gap " << gap;
  return line.str();
}

// Warns of penetration above the effect of a coarse mesh, although all tested points are
// constrained.
void penetration_warning(const ContactPair& pair, Report& report) {
  constexpr double too_deep = 0.1;
  if (pair.law.law == ContactLaw::tied || pair.wall || !(share_of_face(pair) > too_deep)) return;
  const char* cure =
      pair.formulation == Formulation::mortar
          ? "mortar holds means over faces: where edges or corners meet use formulation: node-face "
            "and pressures: nodes"
      : pair.seen().n_function_steps > 0
          ? "pressure functions hold means over several nodes: pressures: nodes holds each node"
      : pair.enforcement == Enforcement::impulse
          ? "look at the positions of the instances, and at what else pushes there"
          : "use enforcement: impulse, or a shorter step";
  report.warning("contact " + pair.name +
                 format_text(": the surfaces were %.3g inside each other, %.3g %% of a face; ",
                             pair.seen().penetration, 100 * share_of_face(pair)) +
                 cure);
}

void friction_warning(const ContactPair& pair, Report& report) {
  const double change = pair.seen().friction_change;
  if (!(change > 1)) return;
  report.warning("contact " + pair.name +
                 format_text(": in one step friction changed the slip speed so much that its "
                             "coefficient changes by %.2g of itself (good: below 1): take a "
                             "smaller time.step",
                             change));
}

void tie_warning(const ContactPair& pair, Report& report) {
  if (pair.has_state() && pair.seen().tie_report.free_motions > 0)
    report.warning("contact " + pair.name + ": " + tie_text(pair.seen().tie_report, *pair.slave));
}

// One for all: pairs of one mechanism share a solution and its residual.
void residual_warning(const std::vector<ContactPair>& pairs, Report& report) {
  const ContactPair* worst = nullptr;
  std::size_t n = 0;
  for (const ContactPair& pair : pairs) {
    if (pair.enforcement == Enforcement::penalty || !(pair.seen().residual > good_residual))
      continue;
    ++n;
    if (worst == nullptr || pair.seen().residual > worst->seen().residual) worst = &pair;
  }
  if (worst == nullptr) return;
  report.warning(
      "contact " + worst->name + (n > 1 ? " and " + counted(n - 1, "more pair") : "") +
      format_text(": not all gaps could be closed or opened: complementarity residual %.2g (good: "
                  "below 1e-6): take a smaller time.step, and look for motions that links or ties "
                  "hold twice",
                  worst->seen().residual));
}

// What is wrong, and its cure. Instances that are apart have nothing in common: one is behind the
// faces of the other. Statics can separate overlapping elastic bodies, but not free rigid ones.
std::string overlap_text(const BuiltScene& built, const ContactPair& pair, double overlap) {
  bool rigid = false, turns = false;
  const auto box_of = [&](const ContactSurface& surface) {
    const Index i = built.simulation.contact_nodes[surface.body].body;
    rigid |= built.instances[i].is_rigid;
    turns |= built.simulation.bodies[i]->turns();
    return extents(*built.simulation.bodies[i], built.instances[i]);
  };
  const auto slave = box_of(*pair.slave), master = box_of(*pair.master);
  if (!pair.wall && !slave.meets(master))
    return format_text(
        ": the surfaces face away from each other: nodes start %.3g behind the "
        "faces of an instance that is apart from theirs: turn or mirror one, or "
        "name both surfaces (of shells, BLOCK.back has the other side)",
        overlap);
  const std::string text = format_text(
      ": the surfaces overlap by %.3g at the start; nodes that overlap are held where "
      "they are, not pushed out",
      overlap);
  if (rigid) return text + ", and rigid bodies may jam: move the instances apart (position)";
  return text + ": move the instances apart (position)" +
         (turns ? "" : ", or take overlap: resolve");
}

}  // namespace

void warn_of_initial_overlaps(const BuiltScene& built, Report& report) {
  for (const ContactPair& pair : built.simulation.pairs) {
    if (pair.resolves_overlap) continue;  // statics remove the overlap
    const double overlap = initial_overlap(pair);
    if (!(overlap > std::max(1e-6 * pair.master->size, pair.adjust.value_or(0)))) continue;
    report.warning("contact " + pair.name + overlap_text(built, pair, overlap));
  }
}

// With many pairs: only those that met, and the first that the scene names and that did not.
void contact_lines(const BuiltScene& built, bool is_restarted, Report& report) {
  constexpr std::size_t many = 10, most_named = 20;
  const auto& pairs = built.simulation.pairs;
  std::size_t n_apart = 0, n_named = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const ContactPair& pair = pairs[p];
    const bool apart = pair.law.law != ContactLaw::tied && !has_touched(pair);
    if (pairs.size() > many && !has_touched(pair) && (pair.of_all || ++n_named > most_named)) {
      ++n_apart;
    } else {
      report.line(apart ? apart_line(built, static_cast<Index>(p), is_restarted)
                        : contact_line(built, static_cast<Index>(p)));
      if (pair.seen().n_fallbacks > 0)
        report.detail("contact " + pair.name + ": Newton's method needed help in " +
                      counted(pair.seen().n_fallbacks, "step"));
    }
    tie_warning(pair, report);
    friction_warning(pair, report);
    penetration_warning(pair, report);
  }
  residual_warning(pairs, report);
  if (n_apart > 0) report.line("contact: " + counted(n_apart, "more pair") + " that never touched");
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/summary/summary.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"

namespace cbr {
namespace {

// Both surfaces of a pair; of a wall none.
std::vector<const ContactSurface*> surfaces_of(const ContactPair& pair) {
  if (pair.wall) return {pair.slave.get()};
  return {pair.slave.get(), pair.master.get()};
}

// Kinetic energy of the common motion of all bodies, which contact among them cannot change.
double common_motion(const BuiltScene& built, const RunResult& result) {
  if (!built.momentum_is_kept) return 0;
  Vector3 momentum = Vector3::Zero();
  double mass = 0;
  for (std::size_t b = 0; b < result.bodies.size(); ++b) {
    momentum += Eigen::Map<const Vector3>(result.bodies[b].momentum.values.data());
    mass += built.instances[b].mass;
  }
  return mass > 0 ? momentum.squaredNorm() / (2 * mass) : 0;
}

// Adds the component of a body that loses energy to what the warning names.
void name_component(const BuiltScene::OfInstance& instance, const ContactPair& pair,
                    OutsideBasis& outside) {
  constexpr double part = 0.25;  // of a face: contact of edges, corners and curved faces
  const bool is_reduced = !instance.parts.empty();
  if (is_reduced && !outside.has_modes) outside.components.clear();
  if (instance.is_rigid || (outside.has_modes && !is_reduced)) return;
  outside.components.insert(instance.component);
  if (!is_reduced) return;
  outside.has_modes = true;
  outside.may_be_massless &=
      instance.parts.size() == 1 && !instance.parts.front().superelement->is_massless();
  const auto& accuracy = instance.parts.front().superelement->accuracy;
  outside.modes_help |= !accuracy || !accuracy->rho_floor ||
                        accuracy->rho_res.maxCoeff() > 1.5 * accuracy->rho_floor->maxCoeff();
  outside.of_faces_in_part |= instance.parts.front().superelement->is_characteristic() &&
                              pair.seen().largest_area < part * pair.slave->areas.sum();
}

}  // namespace

double energy_of_a_step(const BuiltScene& built, const RunResult& result) {
  const Simulation& sim = built.simulation;
  double energy = 0;
  for (std::size_t p = 0; p < sim.pairs.size(); ++p) {
    if (result.pairs[p].empty()) continue;
    const std::vector<double>& force = result.pairs[p]["force"].values;
    const double impulse = sim.plan.h * Vector3(force.data() + force.size() - 3).stableNorm();
    for (const ContactSurface* surface : surfaces_of(sim.pairs[p])) {
      const Index body = sim.contact_nodes[surface->body].body;
      if (!built.instances[body].is_rigid) continue;
      energy += impulse * impulse / (2 * built.instances[body].mass);
    }
  }
  return energy;
}

std::optional<OutsideBasis> energy_outside_basis(const BuiltScene& built, const RunResult& result) {
  OutsideBasis outside;
  bool any = false;
  const std::vector<ContactPair>& pairs = built.simulation.pairs;
  for (const ContactPair& pair : pairs) {
    if (pair.law.law == ContactLaw::tied || pair.seen().largest_area == 0) continue;
    if (pair.enforcement != Enforcement::impulse) {
      outside.has_others = true;
      continue;
    }
    bool loses = false, is_rigid = true;
    for (const ContactSurface* surface : surfaces_of(pair)) {
      const Index body = built.simulation.contact_nodes[surface->body].body;
      const auto& instance = built.instances[body];
      if (built.simulation.bodies[body]->facts().kicks_at_end) continue;
      loses = true;
      is_rigid &= instance.is_rigid;
      name_component(instance, pair, outside);
    }
    const auto& series = result.pairs[&pair - pairs.data()];
    if (loses && !series.empty())
      outside.n_impacts += static_cast<Index>(series["impacts"].values.back());
    any |= loses;
    outside.all_rigid &= is_rigid;
    outside.has_rigid |= loses && is_rigid;
  }
  if (!any) return std::nullopt;
  outside.may_be_massless &= !built.simulation.plan.newmark_alpha;
  std::size_t at = result.time.size() - 1;
  for (std::size_t i = 0; i < result.time.size(); ++i)
    if (result.active[i] == 0) at = i;
  // No separation since the first contact; and rigid bodies lend no energy
  if (outside.all_rigid || (result.work_contact[at] == 0 && result.active.back() > 0))
    at = result.time.size() - 1;
  outside.energy = 0 - result.work_contact[at];
  if (std::abs(outside.energy) <= energy_of_a_step(built, result)) outside.energy = 0;
  outside.friction = 0 - result.work_friction.back();
  outside.scale =
      *std::max_element(result.total.begin(), result.total.end()) - common_motion(built, result);
  if (!built.momentum_is_kept)
    outside.scale = std::max(outside.scale, std::abs(result.work_external.back()));
  return outside;
}

std::optional<double> share_outside_basis(const BuiltScene& built, const RunResult& result) {
  if (built.simulation.is_static) return std::nullopt;
  const auto outside = energy_outside_basis(built, result);
  if (!outside || !(outside->scale > 0)) return std::nullopt;
  return outside->energy / outside->scale;
}

std::string text_of(const OutsideBasis& outside, bool momentum_is_kept) {
  std::string to = "to the mass of the faces' own nodes",
              cure = "good: a few per cent; a finer mesh at the face lowers it";
  if (outside.has_modes) {
    to = "to truncated modes";
    cure = "good: a few per cent; more modes and a finer mesh at the face lower it";
  } else if (outside.all_rigid) {
    to = "in impacts of rigid bodies";
    cure = "they rebound by contact[].restitution alone";
  }
  std::ostringstream text;
  text.precision(3);
  text << "energy lost " << to;
  if (outside.has_others) text << ", and to springs and node-lumped contact";
  if (outside.has_rigid && !outside.all_rigid) text << ", and in impacts of rigid bodies";
  text << ": " << outside.energy;
  if (outside.scale > 0)
    text << ", " << 100 * outside.energy / outside.scale << " % of "
         << (momentum_is_kept ? "the energy against the common centre of mass"
                              : "the largest energy or work of loads")
         << " (" << cure << ")";
  text << "; friction: " << outside.friction;
  return text.str();
}

std::optional<std::string> warning_of(const OutsideBasis& outside) {
  constexpr double much = 0.2;
  constexpr Index many = 3;
  const double share = outside.scale > 0 ? outside.energy / outside.scale : 0;
  if (!(share > much) || outside.has_rigid || outside.has_others) return std::nullopt;
  std::string cure;
  if (outside.of_faces_in_part)
    cure = "basis: craig-bampton loses less where edges or parts of a face strike; ";
  if (outside.n_impacts > many && outside.may_be_massless)
    cure += std::string(outside.has_modes ? "" : "as: superelement with ") +
            "basis: massless and massless_modes: tapered lose none in many impacts; ";
  // Modes up to a frequency f are as many as f^3, and leave a layer of the thickness 1 / f at a
  // face
  cure += outside.modes_help ? "8 times the modes" : "elements of half the size at the face";
  return format_text("contact lost %.3g %% of the energy, in %td impact%s, to ", 100 * share,
                     static_cast<std::ptrdiff_t>(outside.n_impacts),
                     outside.n_impacts == 1 ? "" : "s") +
         (outside.has_modes ? "truncated modes of " : "the mass of face nodes of ") +
         (outside.components.size() == 1 ? "component '" : "components '") +
         join({outside.components.begin(), outside.components.end()}, "', '") + "': " + cure +
         " about halve the loss of an impact";
}

}  // namespace cbr

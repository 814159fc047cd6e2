// SPDX-License-Identifier: GPL-3.0-or-later
// The summary of cbr-reduce about a superelement that it made.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "common/app/report.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/domains/domains.hpp"

namespace cbr {

// The mass that the component has, the rigid body that its geometry is, whether the scene has
// statics alone, and sets that may touch other bodies in exact motion.
struct ComponentMass {
  MassKind kind = MassKind::lumped;
  RigidBody geometry;
  bool is_static = false;
  std::set<std::string> touching = {};
};

void summarise(const Superelement& superelement, const ReductionFigures& figures,
               const ComponentMass& mass, const std::filesystem::path& file, Report& report);

// A decomposed component: figures of its domains, and the file of the group. rho:
// residual_mass_share() of the group; none: not computed.
void summarise_domains(const SuperelementGroup& group, const GroupFigures& figures,
                       const std::optional<Vector3>& rho, const ComponentMass& mass,
                       Report& report);
void summarise_group(const SuperelementGroup& group, const ComponentMass& mass,
                     const std::filesystem::path& file, Report& report);

}  // namespace cbr

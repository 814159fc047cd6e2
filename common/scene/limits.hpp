// SPDX-License-Identifier: GPL-3.0-or-later
// Limits: which abilities do not go with which bodies, bases, integrators and other abilities.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/scene.hpp"

namespace cbr {

// What an instance is, what acts on it, or what its run does: the text in messages and in
// docs/formats.md.
using Feature = std::string_view;

namespace feature {

inline constexpr Feature
    // of a run
    central_difference = "`integrator: central-difference`",
    newmark = "`integrator: newmark`", small_rotation = "`time.rotations: small`",
    large_rotation = "large rotation (`time.rotations: large`)",
    statics = "statics (`time.static`, `time.preload`)", static_run = "`time.static`",
    no_load_steps = "a run without load steps (`time.preload: 0`)", sweep = "`--sweep`",
    // of an instance and its component
    rigid = "`as: rigid`", flexible = "`as: superelement` or `as: mesh`", mesh = "`as: mesh`",
    mesh_modes = "`as: mesh` with `--modes`, `--sweep`",
    mesh_with_shells = "`as: mesh` with shells and `mass: consistent`", parts = "several parts",
    dense = "dense blocks (above `--diagonal-limit`)",
    domains = "several domains (`reduction.domains`)", massless = "`basis: massless`",
    characteristic = "`basis: characteristic`",
    rotations = "nodes with rotations (`reduction.points`, `blocks.NAME.thickness`)",
    velocity = "`velocity`", spin = "`angular_velocity`", damping = "damping",
    modal_damping = "damping of modes (`loss_factor`, `instances.NAME.damping`)",
    mass_damping = "mass-proportional damping (`alpha`)", point_inertia = "a point with `inertia`",
    interface_points = "`reduction.points`", points_of_massless = "points of `basis: massless`",
    points_of_shells = "points of an instance with shells",
    // of what acts on it
    penalty = "`enforcement: penalty`", nodal = "`enforcement: nodal`",
    restitution = "`restitution`", open_contact = "contact that is not `tied`",
    pressing = "`pretension`, `overlap: resolve` or `interference` above 0",
    supports = "supports (`boundary`)", fixed = "`reduction.fixed`",
    into_fixed = "motion along a fixed direction",
    unlike_supports = "supports that move unlike each other or rotate, or `output.reactions`",
    dashpot = "a link with damping but no stiffness",
    driven_link = "a link with a prescribed motion", skin = "a structural `skin`",
    skin_in_modes = "a structural `skin` with `integrator: exact`",
    skin_of_instance = "a structural `skin` on the instance",
    moments_of_shells = "moments on an instance with shells", moment = "`moment`",
    pressure = "`pressure`", traction = "`traction`", inside = "a set inside a superelement",
    nodeset = "a nodeset",
    // of its output
    stress = "`output.stress`";

}  // namespace feature

// Features, each with the first line of the scene that asks for it.
struct Asked {
  const SourceLine* at = nullptr;  // of the scene, which must outlive it
  std::string found = {};          // what the text of the feature leaves open
};
using Features = std::map<Feature, Asked>;
void add_if(bool is_on, Feature feature, const SourceLine& at, Features& features,
            std::string found = {});

// A row of the table, which docs/formats.md repeats.
struct Limit {
  Feature ability;
  std::vector<Feature> not_with;
  std::string cure;
  bool before_reduction = false;  // cbr-reduce refuses it, too
};
const std::vector<Limit>& limits();

// The first limit of an ability that the other features exceed: "ABILITY does not go with FEATURE
// (line 7): CURE". Empty: none.
std::string exceeded_limit(Feature ability, const Features& features);

// InputError at the line of the ability: "scene.yaml:3: SUBJECT: " and the text above. The second
// is of two features with a row in the table.
void check_limits(const Features& features, const std::string& subject);
[[noreturn]] void refuse(const SourceLine& at, const std::string& subject, Feature ability,
                         Feature not_with);
[[noreturn]] void refuse(const Load& load, Feature not_with);

// Of the run: integrator, rotations, statics and skin. Empty without `time`.
Features features_of_run(const Scene& scene);
// Of each instance by the scene alone, with those of the run.
std::vector<Features> features_of(const Scene& scene);
// InputError for a run that cannot be, before anything is reduced for it.
void check_before_reduction(const Scene& scene);

}  // namespace cbr

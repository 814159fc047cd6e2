// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/limits.hpp"

#include <algorithm>
#include <cstdlib>
#include <unordered_map>

#include "common/base/error.hpp"
#include "common/scene/scene_uses.hpp"

namespace cbr {
namespace {

std::string text_of(const Limit& limit, const Asked& ability, Feature feature, const Asked& with) {
  const auto named = [](Feature of, const Asked& asked) {
    return std::string(of) + (asked.found.empty() ? "" : " (found " + asked.found + ")");
  };
  const bool has_line = with.at != nullptr && with.at->line > 0 &&
                        (ability.at == nullptr || ability.at->line != with.at->line);
  std::string text = named(limit.ability, ability) + " does not go with " + named(feature, with) +
                     (has_line ? " (line " + std::to_string(with.at->line) + ")" : "") + ": " +
                     limit.cure;
  std::erase(text, '`');
  return text;
}

std::string exceeded(const Limit& limit, const Asked& ability, const Features& features) {
  for (const Feature feature : limit.not_with)
    if (const auto with = features.find(feature); with != features.end())
      return text_of(limit, ability, feature, with->second);
  return {};
}

void check(const Features& features, const std::string& subject, bool before_reduction) {
  for (const Limit& limit : limits()) {
    const auto ability = features.find(limit.ability);
    if (ability == features.end() || (before_reduction && !limit.before_reduction)) continue;
    if (const std::string text = exceeded(limit, ability->second, features); !text.empty())
      throw InputError(ability->second.at->text() + ": " + subject + ": " + text);
  }
}

bool has_shells(const Component& component) {
  return std::any_of(component.blocks.begin(), component.blocks.end(),
                     [](const auto& block) { return block.second.thickness.has_value(); });
}

void add_reduction(const Component& component, Features& features) {
  const ReductionOptions& reduction = *component.reduction;
  const SourceLine& at = component.source;
  const bool has_points = !component.points.empty(), is_massless = reduction.is_massless();
  add_if(is_massless, feature::massless, at, features);
  add_if(reduction.is_characteristic(), feature::characteristic, at, features);
  add_if(has_points && is_massless, feature::points_of_massless, at, features);
  add_if(has_points && !reduction.interface_points.empty(), feature::interface_points, at,
         features);
}

// Whether the motion (scene axes) has a part along an axis that the component's `fixed` names.
bool is_into_fixed(const Component& component, const Instance& instance, const Vector3& motion) {
  constexpr double round_off = 1e-12;
  const Vector3 own = instance.transformation().transpose() * motion;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (component.reduction && component.reduction->fixes(axis) &&
        std::abs(own[static_cast<Index>(axis)]) > round_off * own.norm())
      return true;
  return false;
}

// Of an instance and its component.
Features features_of(const Scene& scene, const Instance& instance) {
  Features features;
  const SourceLine& at = instance.source;
  add_if(instance.as == InstanceKind::rigid, feature::rigid, at, features);
  add_if(instance.as != InstanceKind::rigid, feature::flexible, at, features);
  add_if(!instance.velocity.isZero(0), feature::velocity, at, features);
  add_if(!instance.angular_velocity.isZero(0), feature::spin, at, features);
  const auto found = scene.components.find(instance.component);
  if (found == scene.components.end()) return features;
  const Component& component = found->second;
  for (const auto& [name, point] : component.points)
    add_if(!point.inertia.isZero(0), feature::point_inertia, point.source, features,
           "'" + name + "'");
  if (instance.as == InstanceKind::superelement && component.reduction)
    add_reduction(component, features);
  add_if(instance.as != InstanceKind::rigid && !component.points.empty() && has_shells(component),
         feature::points_of_shells, component.source, features);
  if (component.reduction && !component.reduction->fixed.empty())
    features[feature::fixed] = {&component.reduction->fixed.front().source};
  add_if(is_into_fixed(component, instance, instance.velocity), feature::into_fixed, at, features,
         "velocity");
  return features;
}

Features features_of(const ContactOptions& contact) {
  Features features;
  const auto add = [&](bool is_on, Feature feature, const char* found = "") {
    add_if(is_on, feature, contact.source, features, found);
  };
  add(contact.enforcement == Enforcement::penalty, feature::penalty);
  add(contact.enforcement == Enforcement::nodal, feature::nodal);
  add(contact.restitution > 0, feature::restitution);
  add(contact.pretension_force || contact.shortening, feature::pressing, "pretension");
  add(contact.resolves_overlap, feature::pressing, "overlap: resolve");
  add(contact.interference > 0, feature::pressing, "interference");
  return features;
}

}  // namespace

void add_if(bool is_on, Feature feature, const SourceLine& at, Features& features,
            std::string found) {
  if (is_on) features.try_emplace(feature, Asked{&at, std::move(found)});
}

const std::vector<Limit>& limits() {
  using namespace feature;
  const std::string impulse = "take `enforcement: impulse`",
                    no_skin = "leave it out of `skin.surfaces`",
                    its_damping = "give its material `damping: {alpha, beta}`, or take ";
  static const std::vector<Limit> all = {
      {newmark,
       {massless},
       "take `exact` or `central-difference`, or `basis: craig-bampton`",
       true},
      {penalty, {newmark, massless}, impulse, true},
      {nodal, {newmark, massless, characteristic}, impulse, true},
      {penalty, {statics, rigid}, impulse},
      {nodal, {statics, rigid}, impulse},
      {nodal, {skin_in_modes}, "take `integrator: central-difference`"},
      {nodal, {damping, unlike_supports, fixed}, "take `enforcement: impulse` or `penalty`"},
      {restitution,
       {flexible},
       "take `as: rigid` for both, or `enforcement: penalty` with `damping`; elastic bodies "
       "rebound "
       "by their waves",
       true},
      {restitution, {newmark, static_run}, "take `exact` or `central-difference`, or leave it out"},
      {pressing,
       {no_load_steps},
       "leave out `time.preload`, for five load steps, or give 1 or more"},
      {velocity, {static_run}, "leave it out"},
      {dashpot, {statics}, "give the motion a `stiffness`, or leave its `damping` out"},
      {driven_link, {sweep}, "leave its motion out, or move supports by `boundary`"},
      {spin, {small_rotation}, "take `time.rotations: auto` or `large`"},
      {into_fixed, {fixed}, "leave this direction out of it, or out of `fixed`"},
      {spin, {supports, fixed}, "leave it out, or hold the instance by links to the ground"},
      {large_rotation, {central_difference, newmark}, "take `integrator: exact`"},
      {large_rotation,
       {statics},
       "keep rotations small, without `time.rotations` and `angular_velocity`"},
      {large_rotation, {skin}, "leave `skin` out, or its `thickness`"},
      {large_rotation, {supports, fixed}, "hold it by links to the ground"},
      {large_rotation, {penalty, nodal}, impulse},
      {large_rotation, {points_of_massless}, "take `basis: craig-bampton` or `characteristic`"},
      {large_rotation,
       {points_of_shells, moments_of_shells},
       "take `as: rigid`, or keep its rotations small"},
      {large_rotation, {interface_points}, "name their sets in `reduction.interface`"},
      {large_rotation,
       {point_inertia},
       "give it a mass alone, or the inertia to a rigid body that a link welds to it"},
      {large_rotation, {domains}, "reduce it in one domain"},
      {large_rotation, {mesh_with_shells}, "leave `mass` out, or take `as: superelement`"},
      {large_rotation, {parts}, "give each part a component"},
      {large_rotation, {mass_damping}, "take `beta`, or damping of modes for a superelement"},
      {modal_damping, {mesh}, its_damping + "`as: superelement`"},
      {modal_damping, {dense}, its_damping + "`integrator: exact` or a larger `--diagonal-limit`"},
      {skin_of_instance, {rigid, rotations, fixed}, no_skin},
      {skin_of_instance, {massless, characteristic}, no_skin + ", or take `basis: craig-bampton`"},
      {skin_of_instance, {mesh_modes}, "take `as: superelement`"},
      {unlike_supports, {skin_of_instance}, no_skin},
      {unlike_supports, {fixed}, "keep the fixed nodes by `interface`, and fix them by `boundary`"},
      {unlike_supports, {sweep}, "give all that hold an axis the same motion along it"},
      {open_contact, {sweep}, "take `tied: true` or `time.preload`, or leave it out"},
      {inside, {sweep}, "name a set of the interface"},
      {moment, {inside}, "add the set to `reduction.interface`"},
      {pressure, {inside}, "add the sideset to `reduction.interface`, or give `traction`"},
      {pressure, {nodeset}, "give `force`, or name a sideset"},
      {traction, {nodeset}, "give `force`, which its nodes share, or name a sideset"},
      {stress, {rigid}, "take `as: superelement` or `mesh`"}};
  return all;
}

std::string exceeded_limit(Feature ability, const Features& features) {
  for (const Limit& limit : limits())
    if (limit.ability == ability)
      if (std::string text = exceeded(limit, {}, features); !text.empty()) return text;
  return {};
}

void check_limits(const Features& features, const std::string& subject) {
  check(features, subject, false);
}

void refuse(const SourceLine& at, const std::string& subject, Feature ability, Feature not_with) {
  check_limits({{ability, {&at}}, {not_with, {}}}, subject);
  std::abort();  // no row of the table
}

void refuse(const Load& load, Feature not_with) {
  using Kind = Load::Kind;
  refuse(load.source, "load on '" + load.surface + "' of instance '" + load.instance + "'",
         load.kind == Kind::moment     ? feature::moment
         : load.kind == Kind::pressure ? feature::pressure
                                       : feature::traction,
         not_with);
}

Features features_of_run(const Scene& scene) {
  Features features;
  if (!scene.time) return features;
  const TimeOptions& time = *scene.time;
  add_if(time.integrator == Integrator::central_difference, feature::central_difference,
         time.source, features);
  add_if(time.integrator == Integrator::newmark, feature::newmark, time.source, features);
  add_if(time.rotations == Rotations::small, feature::small_rotation, time.source, features);
  add_if(time.is_static, feature::static_run, time.source, features);
  add_if(time.is_static || preload_steps(scene) > 0, feature::statics, time.source, features);
  add_if(preload_steps(scene) == 0, feature::no_load_steps, time.source, features);
  if (!skin_acts(scene)) return features;
  add_if(true, feature::skin, scene.skin->source, features);
  add_if(time.integrator == Integrator::exact, feature::skin_in_modes, scene.skin->source,
         features);
  return features;
}

std::vector<Features> features_of(const Scene& scene) {
  std::vector<Features> all;
  std::unordered_map<std::string, std::size_t> places;
  const Features of_run = features_of_run(scene);
  for (const Instance& instance : scene.instances) {
    places.try_emplace(instance.name, all.size());
    all.push_back(features_of(scene, instance));
    all.back().insert(of_run.begin(), of_run.end());
  }
  const auto add = [&](const std::string& instance, Feature feature, const SourceLine& at) {
    add_if(true, feature, at, all[places.at(instance)]);
  };
  for (const BoundaryCondition& condition : scene.boundary) {
    add(condition.instance, feature::supports, condition.source);
    const Instance& instance = scene.instances[places.at(condition.instance)];
    const auto component = scene.components.find(instance.component);
    add_if(component != scene.components.end() && condition.motion != SupportMotion::none &&
               is_into_fixed(component->second, instance, condition.value),
           feature::into_fixed, condition.source, all[places.at(condition.instance)],
           "boundary of '" + condition.nodes + "'");
  }
  for (const ContactOptions& contact : scene.contact) {
    const Features features = features_of(contact);
    if (features.empty()) continue;
    for (std::size_t i = 0; contact.all && i < all.size(); ++i)
      all[i].insert(features.begin(), features.end());
    for (const SurfaceName* side : {&contact.first, &contact.second})
      if (!contact.all && !side->is_wall())
        all[places.at(side->instance)].insert(features.begin(), features.end());
  }
  for (const LinkOptions& link : scene.links)
    for (Index m = 0; m < 6; ++m)
      if (link.damping(m, m) > 0 && !(link.stiffness(m, m) > 0) &&
          link.force[static_cast<std::size_t>(m)].empty())
        for (const SurfaceName* end : {&link.first, &link.second})
          if (!end->is_wall()) add(end->instance, feature::dashpot, link.source);
  for (const Load& load : scene.loads) {
    if (load.kind != Load::Kind::moment || load.on_point) continue;
    const Instance& instance = scene.instances[places.at(load.instance)];
    if (instance.as != InstanceKind::rigid && has_shells(component_of(scene, instance)))
      add(load.instance, feature::moments_of_shells, load.source);
  }
  for (const StressOptions& stress : scene.output.stress)
    add(stress.instance, feature::stress, stress.source);
  return all;
}

void check_before_reduction(const Scene& scene) {
  if (!scene.time) return;
  const std::vector<Features> features = features_of(scene);
  for (std::size_t i = 0; i < features.size(); ++i)
    check(features[i], "instance '" + scene.instances[i].name + "'", true);
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Skin, boundary, loads, time.
#include <algorithm>
#include <cctype>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// Some of the axes, or none.
void read_rotations(const SceneNode& node, const SceneReading& reading,
                    std::optional<std::array<bool, 3>>& axes) {
  axes.emplace().fill(false);
  const auto items = node.list_or_one();
  if (items.empty()) node.fail("is empty, expected some of x, y, z, or none");
  if (items.size() > 1 || items.front().text() != "none") read_motions(node, reading, *axes);
}

std::string rotations_text(const std::optional<std::array<bool, 3>>& axes) {
  return axes ? motions_text(*axes) : "";
}

// A set, or a point, which takes forces and moments.
void parse_place(const SceneMap& map, const Scene& scene, Load& load) {
  const SceneNode* point = map.find("point");
  load.on_point = point != nullptr;
  if (!load.on_point) {
    load.surface = map.at("surface").text();
    return;
  }
  if (const auto* surface = map.find("surface"))
    surface->fail("stands beside 'point', expected one of the two");
  if (load.kind != Load::Kind::force && load.kind != Load::Kind::moment)
    point->fail("takes a force or a moment, found " + word_of(load_words, load.kind));
  load.surface = point->text();
  if (point_of(scene, load.instance, load.surface) == nullptr)
    point->fail("instance '" + load.instance + "' has no point '" + load.surface +
                "': give it under components.NAME.points");
}

Load parse_load(const SceneNode& node, const SceneReading& reading) {
  Load load;
  load.source = node.source();
  const SceneMap map = node.map_of(scene_keys(load));
  const std::string kind = map.exactly_one(texts_of(load_words));
  load.kind = *value_of(load_words, kind);
  const bool is_pressure = load.kind == Load::Kind::pressure;
  load.value = is_pressure ? Vector3(map.at(kind).number(), 0, 0) : map.at(kind).vector3();
  load.follows = is_pressure;
  if (load.kind == Load::Kind::gravity) {
    for (const char* key : {"instance", "surface", "follow"}) {
      if (const auto* value = map.find(key))
        value->fail(std::string("gravity acts on everything, remove '") + key + "'");
    }
  } else {
    map.at("instance");
  }
  read_keys(node, scene_keys(load), reading);
  if (load.kind != Load::Kind::gravity) parse_place(map, reading.scene, load);
  return load;
}

void read_step(const SceneNode& node, const SceneReading& reading, TimeOptions& time) {
  if (node.is_map()) {
    read_keys(node, {{"cfl", Number{time.cfl, positive}, true, true}}, reading);
  } else if (!node.is_scalar()) {
    node.fail("expected auto, seconds, or {cfl: NUMBER}");
  } else if (const std::string text = node.text(); text != "auto") {
    if (std::isalpha(static_cast<unsigned char>(text.front())) != 0)
      node.fail("found '" + text + "', expected auto, seconds, or {cfl: NUMBER}");
    time.step = node.number(positive);
  }
}

std::string step_text(const TimeOptions& time) {
  if (time.step) return number_text(*time.step);
  return time.cfl ? "{cfl: " + number_text(*time.cfl) + "}" : "auto";
}

constexpr SupportMotion no_motion = SupportMotion::none;
constexpr Index most_preload = 10000;

// Keys without effect in statics.
void refuse_with_statics(const SceneMap& map, const TimeOptions& time) {
  for (const char* key : {"integrator", "alpha", "force", "rotations"})
    if (const auto* value = map.find(key))
      value->fail(std::string("static: true computes equilibrium and has no '") + key +
                  "': remove one of the two");
  if (time.cfl)
    map.at("step").fail(
        "static: true has no critical step: give the length of a load step, or auto");
}

// Points so near each other that a velocity or displacement jumps between them, as a share of the
// table's length; and changes of value that are round-off.
constexpr double jump_share = 1e-8, same_share = 1e-12;

// Without points that repeat a value at once, which a sine of whole cycles ends with. InputError:
// jumps.
History without_jumps(const History& table, const SceneNode& node) {
  History history;
  double largest = 0;
  for (const double value : table.value) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < table.time.size(); ++i) {
    if (i > 0 && table.time[i] - history.time.back() <
                     jump_share * (table.time.back() - table.time.front())) {
      if (std::abs(table.value[i] - history.value.back()) <= same_share * largest) continue;
      node.fail("jumps at the time " + std::to_string(table.time[i]) +
                ", which takes an infinite force: let the points there stand farther apart, or "
                "give an acceleration");
    }
    history.time.push_back(table.time[i]);
    history.value.push_back(table.value[i]);
  }
  return history;
}

// A rotation moves nodes at right angles to its axis alone.
void refuse_free_turn(const SceneMap& map, const GivenMotion& given,
                      const BoundaryCondition& condition) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    const bool holds = condition.fix[b] || condition.fix[c] ||
                       (condition.fix_rotations && (*condition.fix_rotations)[axis]);
    if (given.turn[static_cast<Index>(axis)] == 0 || holds) continue;
    map.at(std::string(word_of(turn_words, given.motion)))
        .fail(std::string("turns about ") + "xyz"[axis] + ", and 'fix' leaves " + "xyz"[b] +
              " and " + "xyz"[c] + " free: add one of them to 'fix', or give 0 there");
  }
}

}  // namespace

void read_motions(const SceneNode& node, const SceneReading&, std::span<bool> fix) {
  const std::vector<std::string> allowed(motion_names, motion_names + fix.size());
  std::fill(fix.begin(), fix.end(), false);
  const auto items = node.list_or_one();
  for (const SceneNode& item : items) {
    const std::size_t motion = item.choice(allowed);
    if (fix[motion]) item.fail_repeated();
    fix[motion] = true;
  }
  if (items.empty()) node.fail("is empty, expected some of " + join(allowed));
}

std::string motions_text(std::span<const bool> fix) {
  std::vector<std::string> names;
  for (std::size_t m = 0; m < fix.size(); ++m)
    if (fix[m]) names.push_back(motion_names[m]);
  return names.empty() ? "none" : yaml_list(names);
}

void add_motion_keys(std::vector<SceneKey>& keys, const Words<SupportMotion>& words,
                     const SupportMotion& motion, const Vector3& value) {
  for (const auto& [word, of] : words)
    keys.push_back({word, Own{value, yaml_vector}, motion == of});
}

GivenMotion parse_motion(const SceneMap& map, const SceneReading& reading) {
  GivenMotion given;
  const SceneNode* value = nullptr;
  for (const auto& [word, motion] : motion_words) {
    const SceneNode* found = map.find(word);
    if (found == nullptr) continue;
    if (value != nullptr)
      found->fail("stands beside '" + std::string(word_of(motion_words, given.motion)) +
                  "', expected one of the two: remove the other");
    value = found;
    given.motion = motion;
    given.value = found->vector3();
  }
  for (const auto& [word, motion] : turn_words) {
    const SceneNode* found = map.find(word);
    if (found == nullptr) continue;
    if (given.motion != SupportMotion::none && given.motion != motion)
      found->fail("stands beside a motion of another kind: expected '" +
                  std::string(word_of(turn_words, given.motion)) + "' there");
    value = found;
    given.motion = motion;
    given.turn = found->vector3();
  }
  const SceneNode* history = map.find("history");
  if (value == nullptr) {
    if (history != nullptr)
      history->fail("needs one of displacement, velocity, acceleration beside it");
    return given;
  }
  const bool is_displacement = given.motion == SupportMotion::displacement;
  if (is_displacement && history == nullptr)
    value->fail(
        "needs a history, as nothing can be elsewhere at once: history: {time: [0, T], value: [0, "
        "1]}");
  if (history == nullptr) return given;
  if (is_displacement && history->is_map() && history->map_of_any().find("sine") != nullptr)
    history->fail(
        "a displacement that is a sine begins with a jump of the velocity: give velocity or "
        "acceleration with the sine");
  read_history(*history, reading, given.history);
  if (given.history.time.front() < 0)
    history->fail("begins before the time 0, expected times from 0 on");
  const bool moves = reading.scene.time && !reading.scene.time->is_static;
  if (is_displacement && moves && given.history.value.front() != 0)
    history->fail("begins with " + number_text(given.history.value.front()) +
                  ", and nothing can be elsewhere at once: displacements count from the initial "
                  "positions, take the first value from all of them");
  if (given.motion != SupportMotion::acceleration)
    given.history = without_jumps(given.history, *history);
  return given;
}

std::string parse_instance_name(const SceneNode& node, const std::string& name,
                                const SceneReading& reading) {
  if (reading.instances.contains(name)) return name;
  std::vector<std::string> known;
  for (const auto& instance : reading.scene.instances) known.push_back(instance.name);
  require_known(node, "instance", name, known);
  return name;
}

Own instance_name(std::string& member) {
  const auto read = [](const SceneNode& node, const SceneReading& reading, std::string& name) {
    name = parse_instance_name(node, node.text(), reading);
  };
  return {member, read, yaml_word};
}

std::vector<SceneKey> scene_keys(SkinOptions& skin) {
  return {{"surfaces", NameList{skin.surfaces}, true, true},
          // Shells for contact alone may have no stiffness and no mass.
          {"youngs_modulus", Number{skin.youngs_modulus, not_negative}, true, true},
          {"poissons_ratio", Number{skin.poissons_ratio, {.low = -1, .high = 0.5}}, true, true},
          {"density", Number{skin.density, not_negative}, true, true},
          {"thickness", Number{skin.thickness, not_negative}, true, true},
          {"mesh", File{skin.mesh}}};
}

void parse_skin(const SceneNode& node, SceneReading& reading) {
  SkinOptions& skin = reading.scene.skin.emplace();
  skin.source = node.source();
  skin.mesh = reading.folder / "skinned.msh";
  for (const Instance& instance : reading.scene.instances)
    if (!instance.place.on.empty())
      node.fail("does not go with instances." + instance.name +
                ".place, as cbr-skin writes meshes in their positions: give the position that "
                "cbr-dyn prints without the skin");
  const SceneMap map = read_keys(node, scene_keys(skin), reading);
  if (skin.surfaces.empty()) map.at("surfaces").fail("is empty, expected at least one surface");
}

std::vector<SceneKey> scene_keys(FixedSet& set) {
  return {{"nodes", Text{set.nodes}, true, true},
          {"fix", Own{set.fix, read_motions, motions_text}, true, true}};
}

std::vector<SceneKey> scene_keys(BoundaryCondition& c) {
  std::vector<SceneKey> keys{{"instance", instance_name(c.instance), true, true}};
  for (const SceneKey& key : scene_keys(static_cast<FixedSet&>(c))) keys.push_back(key);
  keys.push_back({"rotations", Own{c.fix_rotations, read_rotations, rotations_text}});
  add_motion_keys(keys, motion_words, c.motion, c.value);
  add_motion_keys(keys, turn_words, c.turn == Vector3::Zero() ? no_motion : c.motion, c.turn);
  keys.push_back({"about", ThreeNumbers{c.about}});
  keys.push_back({"history", Own{c.history, history_text}});
  return keys;
}

void parse_boundary(const SceneNode& node, SceneReading& reading) {
  node.for_each_item([&](const SceneNode& item) {
    BoundaryCondition condition;
    condition.source = item.source();
    const SceneMap map = read_keys(item, scene_keys(condition), reading);
    GivenMotion given = parse_motion(map, reading);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (given.value[static_cast<Index>(axis)] != 0 && !condition.fix[axis])
        map.at(word_of(motion_words, given.motion))
            .fail(std::string("moves along ") + "xyz"[axis] +
                  ", which 'fix' leaves free: add it to 'fix', or give 0 there");
    if (given.turn != Vector3::Zero()) refuse_free_turn(map, given, condition);
    if (condition.about && given.turn == Vector3::Zero())
      map.at("about").fail(
          "is the point of a rotation, and there is none: give rotation, angular_velocity or "
          "angular_acceleration beside it");
    condition.motion = given.motion;
    condition.value = given.value;
    condition.turn = given.turn;
    condition.history = std::move(given.history);
    reading.scene.boundary.push_back(std::move(condition));
  });
}

std::vector<SceneKey> scene_keys(Load& load) {
  const bool acts_on_all = load.kind == Load::Kind::gravity,
             is_pressure = load.kind == Load::Kind::pressure;
  const auto value = [is_pressure](const Vector3& of) {
    return is_pressure ? number_text(of[0]) : yaml_vector(of);
  };
  std::vector<SceneKey> keys{
      {"instance", instance_name(load.instance), !acts_on_all},
      {"surface", Own{load.surface, yaml_word}, !acts_on_all && !load.on_point},
      {"point", Own{load.surface, yaml_word}, load.on_point}};
  for (const auto& [word, kind] : load_words)
    keys.push_back({word, Own{load.value, value}, load.kind == kind});
  keys.push_back({"follow", TrueOrFalse{load.follows}, load.follows != is_pressure});
  keys.push_back({"history", Own{load.history, read_history, history_text}});
  return keys;
}

void parse_loads(const SceneNode& node, SceneReading& reading) {
  node.for_each_item(
      [&](const SceneNode& item) { reading.scene.loads.push_back(parse_load(item, reading)); });
}

std::vector<SceneKey> scene_keys(TimeOptions& t) {
  return {{"end", Number{t.end, positive}, true, true},
          {"step", Own{t, read_step, step_text}},
          {"static", TrueOrFalse{t.is_static}, t.is_static},
          {"integrator", OneWord{t.integrator, integrator_words}, !t.is_static},
          {"preload", WholeNumber{t.preload}},
          {"alpha", Number{t.alpha}, t.alpha != 0},
          {"mass_scaling", Retired{"leave it out, and take step: {cfl: 2} for long steps"}},
          {"rotations", OneWord{t.rotations, rotations_words}, t.rotations != Rotations::automatic},
          {"force", TrueOrFalse{t.force_step}, t.force_step}};
}

void parse_time(const SceneNode& node, SceneReading& reading) {
  TimeOptions& time = reading.scene.time.emplace();
  time.source = node.source();
  const SceneMap map = read_keys(node, scene_keys(time), reading);
  if (time.cfl && *time.cfl > 1 && time.integrator == Integrator::central_difference)
    map.at("step").map({"cfl"}).at("cfl").fail(
        "found a number above 1, expected one from above 0 to 1 (above 1 with integrator: "
        "exact or newmark only)");
  if (const auto* alpha = map.find("alpha")) {
    if (time.integrator != Integrator::newmark) alpha->fail("requires integrator: newmark");
    if (!(time.alpha >= -1.0 / 3 && time.alpha <= 0))
      alpha->fail("found " + alpha->text() + ", expected a number from -1/3 to 0");
  }
  if (time.is_static) refuse_with_statics(map, time);
  if (!time.preload) return;
  const SceneNode& preload = map.at("preload");
  if (*time.preload > most_preload)
    preload.fail("found " + preload.text() + ", expected at most 10000 load steps");
  if (*time.preload > 0 && time.rotations == Rotations::large)
    preload.fail("does not go with rotations: large: leave one of the two out");
}

}  // namespace cbr

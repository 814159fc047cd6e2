// SPDX-License-Identifier: GPL-3.0-or-later
// Skin, boundary, loads, time: what is done with it.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

std::array<bool, 3> parse_axes(const SceneNode& node) {
  std::array<bool, 3> axes{};
  for (const auto& item : node.list_or_one()) {
    const auto axis = item.one_of<std::size_t>({{"x", 0}, {"y", 1}, {"z", 2}});
    if (axes[axis]) item.fail("'" + item.text() + "' is listed twice: remove one");
    axes[axis] = true;
  }
  if (axes == std::array<bool, 3>{}) node.fail("is empty, expected some of x, y, z");
  return axes;
}

// Some of the axes, or none.
std::array<bool, 3> parse_rotations(const SceneNode& node) {
  const auto items = node.list_or_one();
  if (items.size() == 1 && items.front().text() == "none") return {};
  std::array<bool, 3> axes{};
  for (const auto& item : items) {
    const auto axis = item.one_of<std::size_t>({{"x", 0}, {"y", 1}, {"z", 2}});
    if (axes[axis]) item.fail("'" + item.text() + "' is listed twice: remove one");
    axes[axis] = true;
  }
  if (items.empty()) node.fail("is empty, expected some of x, y, z, or none");
  return axes;
}

// A set, or a point, which takes forces and moments.
void parse_place(const SceneMap& map, const std::string& kind, const Scene& scene, Load& load) {
  const SceneNode* point = map.find("point");
  load.on_point = point != nullptr;
  if (!load.on_point) {
    load.surface = map.at("surface").text();
    return;
  }
  if (const auto* surface = map.find("surface"))
    surface->fail("stands beside 'point', expected one of the two");
  if (kind != "force" && kind != "moment") point->fail("takes a force or a moment, found " + kind);
  load.surface = point->text();
  if (point_of(scene, load.instance, load.surface) == nullptr)
    point->fail("instance '" + load.instance + "' has no point '" + load.surface +
                "': give it under components.NAME.points");
}

Load parse_load(const SceneNode& node, const std::filesystem::path& folder, const Scene& scene,
                const SceneNames& names) {
  const SceneMap map = node.map({"instance", "surface", "point", "traction", "force", "pressure",
                                 "gravity", "moment", "history", "follow"});
  Load load;
  load.source = node.source();
  const std::string kind = map.exactly_one({"traction", "force", "pressure", "gravity", "moment"});
  if (kind == "pressure") {
    load.kind = Load::Kind::pressure;
    load.value = Vector3(map.at(kind).number(), 0, 0);
  } else {
    load.value = map.at(kind).vector3();
    load.kind = kind == "moment"     ? Load::Kind::moment
                : kind == "traction" ? Load::Kind::traction
                : kind == "force"    ? Load::Kind::force
                                     : Load::Kind::gravity;
  }
  if (load.kind == Load::Kind::gravity) {
    for (const char* key : {"instance", "surface", "follow"}) {
      if (const auto* value = map.find(key))
        value->fail(std::string("gravity acts on everything, remove '") + key + "'");
    }
  } else {
    load.instance = parse_instance_name(map.at("instance"), scene, names);
    parse_place(map, kind, scene, load);
  }
  const auto* follow = map.find("follow");
  load.follows = follow != nullptr ? follow->boolean() : load.kind == Load::Kind::pressure;
  if (const auto* history = map.find("history"))
    load.history = parse_history(*history, folder, scene);
  return load;
}

void parse_step(const SceneNode& node, TimeOptions& time) {
  if (node.is_map()) {
    const SceneMap map = node.map({"cfl"});
    time.cfl = map.at("cfl").positive();
    if (*time.cfl > 1 && time.integrator != Integrator::newmark && !time.mass_scaling)
      map.at("cfl").fail(
          "found a number above 1, expected one from above 0 to 1 (above 1 with integrator: "
          "newmark or mass_scaling: true only)");
  } else if (!node.is_scalar()) {
    node.fail("expected auto, seconds, or {cfl: NUMBER}");
  } else if (const std::string text = node.text(); text != "auto") {
    if (std::isalpha(static_cast<unsigned char>(text.front())) != 0)
      node.fail("found '" + text + "', expected auto, seconds, or {cfl: NUMBER}");
    time.step = node.positive();
  }
}

constexpr Index most_preload = 10000;

// What has no meaning without motion.
void refuse_with_statics(const SceneMap& map, const TimeOptions& time) {
  for (const char* key : {"integrator", "alpha", "mass_scaling", "force", "rotations"})
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

GivenMotion parse_motion(const SceneMap& map, const std::filesystem::path& folder,
                         const Scene& scene) {
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
  given.history = parse_history(*history, folder, scene);
  if (given.history.time.front() < 0)
    history->fail("begins before the time 0, expected times from 0 on");
  if (given.motion != SupportMotion::acceleration)
    given.history = without_jumps(given.history, *history);
  return given;
}

std::string parse_instance_name(const SceneNode& node, const std::string& name, const Scene& scene,
                                const SceneNames& names) {
  if (names.instances.contains(name)) return name;
  std::vector<std::string> known;
  for (const auto& instance : scene.instances) known.push_back(instance.name);
  require_known(node, "instance", name, known);
  return name;
}

std::string parse_instance_name(const SceneNode& node, const Scene& scene,
                                const SceneNames& names) {
  return parse_instance_name(node, node.text(), scene, names);
}

void parse_skin(const SceneNode& node, const std::filesystem::path& folder, Scene& scene) {
  const SceneMap map =
      node.map({"surfaces", "youngs_modulus", "poissons_ratio", "density", "thickness", "mesh"});
  SkinOptions skin;
  skin.source = node.source();
  skin.surfaces = map.at("surfaces").names();
  if (skin.surfaces.empty()) map.at("surfaces").fail("is empty, expected at least one surface");
  // Shells for contact alone may have no stiffness and no mass.
  skin.youngs_modulus = map.at("youngs_modulus").not_negative();
  skin.poissons_ratio = map.at("poissons_ratio").in_open_range(-1, 0.5);
  skin.density = map.at("density").not_negative();
  skin.thickness = map.at("thickness").not_negative();
  const auto* mesh = map.find("mesh");
  skin.mesh = mesh != nullptr ? resolve_path(*mesh, folder) : folder / "skinned.msh";
  scene.skin = skin;
}

void parse_boundary(const SceneNode& node, const std::filesystem::path& folder,
                    const SceneNames& names, Scene& scene) {
  node.for_each_item([&](const SceneNode& item) {
    const SceneMap map = item.map({"instance", "nodes", "fix", "rotations", "displacement",
                                   "velocity", "acceleration", "rotation", "angular_velocity",
                                   "angular_acceleration", "about", "history"});
    BoundaryCondition condition;
    condition.source = item.source();
    condition.instance = parse_instance_name(map.at("instance"), scene, names);
    condition.nodes = map.at("nodes").text();
    condition.fix = parse_axes(map.at("fix"));
    if (const auto* rotations = map.find("rotations"))
      condition.fix_rotations = parse_rotations(*rotations);
    GivenMotion given = parse_motion(map, folder, scene);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (given.value[static_cast<Index>(axis)] != 0 && !condition.fix[axis])
        map.at(std::string(word_of(motion_words, given.motion)))
            .fail(std::string("moves along ") + "xyz"[axis] +
                  ", which 'fix' leaves free: add it to 'fix', or give 0 there");
    if (given.turn != Vector3::Zero()) refuse_free_turn(map, given, condition);
    if (const auto* about = map.find("about")) {
      if (given.turn == Vector3::Zero())
        about->fail(
            "is the point of a rotation, and there is none: give rotation, angular_velocity or "
            "angular_acceleration beside it");
      condition.about = about->vector3();
    }
    condition.motion = given.motion;
    condition.value = given.value;
    condition.turn = given.turn;
    condition.history = std::move(given.history);
    scene.boundary.push_back(condition);
  });
}

void parse_loads(const SceneNode& node, const std::filesystem::path& folder,
                 const SceneNames& names, Scene& scene) {
  node.for_each_item([&](const SceneNode& item) {
    scene.loads.push_back(parse_load(item, folder, scene, names));
  });
}

void parse_time(const SceneNode& node, Scene& scene) {
  const SceneMap map = node.map({"end", "step", "static", "preload", "integrator", "alpha",
                                 "mass_scaling", "force", "rotations"});
  TimeOptions time;
  time.source = node.source();
  time.end = map.at("end").positive();
  if (const auto* integrator = map.find("integrator")) {
    time.integrator = integrator->one_of(integrator_words);
  }
  if (const auto* rotations = map.find("rotations"))
    time.rotations = rotations->one_of(rotations_words);
  if (const auto* scaling = map.find("mass_scaling")) {
    time.mass_scaling = scaling->boolean();
    if (time.mass_scaling && time.integrator != Integrator::exact)
      scaling->fail("requires integrator: exact");
  }
  if (const auto* step = map.find("step")) parse_step(*step, time);
  if (const auto* force = map.find("force")) time.force_step = force->boolean();
  if (const auto* alpha = map.find("alpha")) {
    time.alpha = alpha->number();
    if (time.integrator != Integrator::newmark) alpha->fail("requires integrator: newmark");
    if (!(time.alpha >= -1.0 / 3 && time.alpha <= 0))
      alpha->fail("found " + alpha->text() + ", expected a number from -1/3 to 0");
  }
  if (const auto* still = map.find("static")) time.is_static = still->boolean();
  if (time.is_static) refuse_with_statics(map, time);
  if (const auto* preload = map.find("preload")) {
    time.preload = preload->index(0);
    if (*time.preload > most_preload)
      preload->fail("found " + preload->text() + ", expected at most 10000 load steps");
    if (*time.preload > 0 && (time.mass_scaling || time.rotations == Rotations::large))
      preload->fail(
          "does not go with mass_scaling: true or rotations: large: leave one of the two out");
  }
  scene.time = time;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces, rigid walls, contact pairs and their enforcement.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// Of length 1. One that has it already, to rounding, is left alone: what is written is read back to
// the last digit.
void read_direction(const SceneNode& node, const SceneReading&, Vector3& v) {
  v = node.vector3();
  if (std::abs(v.squaredNorm() - 1) <= 8 * std::numeric_limits<double>::epsilon()) return;
  const double largest = v.cwiseAbs().maxCoeff();
  if (largest == 0) node.fail("found [0, 0, 0], expected a direction: a vector that is not zero");
  v /= largest;  // no square overflows or vanishes
  v = (v / v.norm()).eval();
}

WallOptions parse_wall(const SceneNode& node, const SceneReading& reading,
                       const std::string& name) {
  if (node.is_map())
    if (const SceneNode* mass = SceneMap(node, {}).find("mass"))
      mass->fail(
          "is not known of a wall, whose motion is given: a wall with a mass of its own is an "
          "instance with as: rigid, held by boundary where it does not move");
  WallOptions wall;
  wall.name = name;
  wall.source = node.source();
  const SceneMap map = read_keys(node, scene_keys(wall), reading);
  GivenMotion given = parse_motion(map, reading);
  wall.motion = given.motion;
  wall.value = given.value;
  wall.history = std::move(given.history);
  wall.kind = *value_of(wall_words, map.exactly_one(texts_of(wall_words)));
  return wall;
}

std::vector<std::string> wall_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const auto& wall : scene.walls) names.push_back(wall.name);
  return names;
}

// INSTANCE.SURFACE or a wall.
SurfaceName parse_partner(const SceneNode& node, const SceneReading& reading) {
  const std::string text = node.text();
  const std::size_t dot = text.find('.');
  if (dot != std::string::npos && reading.walls.contains(text.substr(0, dot)))
    node.fail("found '" + text + "': '" + text.substr(0, dot) +
              "' is a rigid wall, which has no surfaces: name it alone");
  if (dot != std::string::npos) return parse_surface_name(node, reading);
  if (reading.walls.contains(text)) return {"", text, node.source()};
  const auto names = wall_names(reading.scene);
  const std::string hint = nearest_name(text, names);
  node.fail("found '" + text + "', expected INSTANCE.SURFACE or the name of a wall" + hint +
            (hint.empty() ? ", " : " ") + "walls: " + (names.empty() ? "none" : join(names)));
}

void read_between(const SceneNode& node, const SceneReading& reading, ContactOptions& contact) {
  if (node.is_scalar()) {
    if (node.text() != "all")
      node.fail("found '" + node.text() +
                "', expected all, or two surfaces: [a.SURFACE, b.SURFACE]");
    contact.all = true;
    return;
  }
  const auto surfaces = node.list();
  if (surfaces.size() != 2)
    node.fail("has " + std::to_string(surfaces.size()) +
              " surfaces, expected two: [a.SURFACE, b.SURFACE]");
  contact.first = parse_partner(surfaces[0], reading);
  contact.second = parse_partner(surfaces[1], reading);
  if (contact.first.text() == contact.second.text())
    node.fail("'" + contact.first.text() + "' cannot be in contact with itself");
  if (contact.first.is_wall() && contact.second.is_wall())
    node.fail("'" + contact.first.text() + "' and '" + contact.second.text() +
              "' are both rigid walls, expected one surface of an instance");
  if (contact.first.is_wall()) std::swap(contact.first, contact.second);
}

// Keys that the enforcement or the formulation does not support.
void check_enforcement(const SceneMap& map, const ContactOptions& contact) {
  const bool is_nodal = contact.enforcement == Enforcement::nodal,
             is_penalty = contact.enforcement == Enforcement::penalty;
  if (contact.friction.at_rest > 0 && is_nodal) {
    map.at("friction").fail("'enforcement: nodal' knows no friction, use impulse or penalty");
  }
  if (contact.damping > 0 && !is_penalty) {
    map.at("damping").fail(
        "damping is that of the springs of 'enforcement: penalty': use it, or remove 'damping'");
  }
  if (!contact.stiffness.empty() && (!is_penalty || contact.damping > 0))
    map.at("stiffness")
        .fail(
            "is that of the springs of 'enforcement: penalty' without 'damping': use it, or remove "
            "one of them");
  if (contact.restitution > 1)
    map.at("restitution")
        .fail("found " + number_text(contact.restitution) + ", expected a share from 0 to 1");
  if (contact.restitution > 0 && (contact.tied || contact.enforcement != Enforcement::impulse))
    map.at("restitution")
        .fail(
            "is of contact that closes by 'enforcement: impulse': remove it, or 'tied' or "
            "'enforcement'; springs of 'penalty' have 'damping'");
  if (contact.formulation == Formulation::two_way && !is_penalty) {
    map.at("formulation")
        .fail(
            "two-way needs 'enforcement: penalty' (hard contact of both sides' nodes is too much): "
            "use it, or " +
            std::string("'node-face' or 'mortar'"));
  }
  if (contact.formulation == Formulation::mortar && is_nodal) {
    map.at("formulation")
        .fail(
            "mortar is not available with 'enforcement: nodal': use impulse or penalty, or "
            "'node-face'");
  }
}

void check_tied(const SceneMap& map, const ContactOptions& contact) {
  if (!contact.tied) return;
  if (contact.friction.at_rest > 0)
    map.at("friction").fail("tied surfaces do not slide, remove 'friction' or 'tied'");
  if (contact.enforcement != Enforcement::impulse) {
    map.at("enforcement")
        .fail(
            "tied surfaces are held by 'enforcement: impulse' only, remove 'enforcement' or "
            "'tied'");
  }
}

void check_wall(const SceneMap& map, const ContactOptions& contact) {
  if (contact.all || !contact.second.is_wall()) return;
  const std::string wall = "'" + contact.second.text() + "' is a rigid wall";
  if (contact.tied)
    map.at("tied").fail(wall + ": nothing can be tied to it, use 'boundary' to hold nodes");
  if (contact.formulation == Formulation::mortar || contact.formulation == Formulation::two_way) {
    map.at("formulation")
        .fail(wall + ", which has no nodes and no faces: only 'node-face' goes with it");
  }
}

// Of statics alone: a pretension, and overlaps that are pressed apart.
void check_statics(const SceneMap& map, ContactOptions& contact) {
  if (const auto* pretension = map.find("pretension")) {
    if (contact.all || contact.second.is_wall())
      pretension->fail("pulls two surfaces together: name both in 'between'");
    if (const auto* tied = map.find("tied"); tied != nullptr && !contact.tied)
      tied->fail("surfaces with a pretension are tied: remove 'tied', or 'pretension'");
    pretension->map({"force", "shortening"}).exactly_one({"force", "shortening"});
    contact.tied = true;
  }
  if (contact.interference != 0 && contact.all)
    map.at("interference").fail("is a length of two surfaces: name both in 'between'");
  const std::string key = contact.interference != 0 ? "interference" : "overlap";
  if (contact.tied && (contact.interference != 0 || contact.resolves_overlap))
    map.at(key).fail("tied surfaces keep their distance, remove 'tied' or '" + key + "'");
}

// A pressure per depth, or a table of both.
void read_contact_stiffness(const SceneNode& node, const SceneReading&, ForceTable& table) {
  if (node.is_scalar()) {
    table = {{0, 1}, {0, node.number(positive)}};
    return;
  }
  read_force_table(node, table);
  if (table.at.front() != 0 || table.force.front() < 0 || !(table.force.back() > 0))
    node.fail("is no pressure over depth: expected rows from the depth 0 on, and pressures from 0");
}

std::string contact_stiffness_text(const ForceTable& table) {
  const bool is_linear = table.at == std::vector<double>{0, 1} && table.force.front() == 0;
  return is_linear ? number_text(table.force.back()) : force_table_text(table);
}

void read_pressures(const SceneNode& node, const SceneReading&, std::optional<Index>& pressures) {
  if (!node.is_scalar()) node.fail("expected auto, nodes, or a number of functions a face");
  const std::string text = node.text();
  if (text == "auto") return;
  if (text != "nodes" && text.find_first_not_of("0123456789") != std::string::npos)
    node.fail("found '" + text + "', expected auto, nodes, or a number of functions a face");
  pressures = text == "nodes" ? 0 : node.index(1);
}

std::string pressures_text(const std::optional<Index>& pressures) {
  if (!pressures) return "";
  return *pressures == 0 ? "nodes" : std::to_string(*pressures);
}

std::vector<SceneKey> friction_keys(FrictionOptions& f) {
  return {{"static", Number{f.at_rest, positive}, true, true},
          {"kinetic", Number{f.kinetic, not_negative}, true, true},
          {"decay", Number{f.decay, positive}, true, true}};
}

void read_friction(const SceneNode& node, const SceneReading& reading, FrictionOptions& friction) {
  if (node.is_map()) {
    read_keys(node, friction_keys(friction), reading);
  } else {
    friction.at_rest = node.number(not_negative);
  }
}

std::string friction_text(FrictionOptions friction) {
  return friction.kinetic ? flow_map(friction_keys(friction)) : number_text(friction.at_rest);
}

ContactOptions parse_one_contact(const SceneNode& node, const SceneReading& reading) {
  ContactOptions contact;
  contact.source = node.source();
  const SceneMap map = read_keys(node, scene_keys(contact), reading);
  check_statics(map, contact);
  check_tied(map, contact);
  check_enforcement(map, contact);
  check_wall(map, contact);
  return contact;
}

// The same for the same two surfaces, in any order.
std::pair<std::string, std::string> pair_key(const ContactOptions& contact) {
  if (contact.all) return {};
  std::pair<std::string, std::string> key{contact.first.text(), contact.second.text()};
  if (key.second < key.first) std::swap(key.first, key.second);
  return key;
}

}  // namespace

SurfaceName parse_surface_name(const SceneNode& node, const SceneReading& reading) {
  const std::string text = node.text();
  const auto dot = text.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == text.size())
    node.fail("found '" + text + "', expected INSTANCE.SURFACE");
  return {parse_instance_name(node, text.substr(0, dot), reading), text.substr(dot + 1),
          node.source()};
}

std::vector<SceneKey> scene_keys(WallOptions& w) {
  const Own direction{w.direction, read_direction, yaml_vector};
  const bool is_plane = w.kind == WallOptions::Kind::plane,
             is_sphere = w.kind == WallOptions::Kind::sphere,
             is_cylinder = w.kind == WallOptions::Kind::cylinder;
  std::vector<SceneKey> keys{{"plane.point", ThreeNumbers{w.point}, is_plane, true},
                             {"plane.normal", direction, is_plane, true},
                             {"sphere.center", ThreeNumbers{w.point}, is_sphere, true},
                             {"sphere.radius", Number{w.radius, positive}, is_sphere, true},
                             {"sphere.inside", TrueOrFalse{w.inside}, is_sphere},
                             {"cylinder.point", ThreeNumbers{w.point}, is_cylinder, true},
                             {"cylinder.axis", direction, is_cylinder, true},
                             {"cylinder.radius", Number{w.radius, positive}, is_cylinder, true},
                             {"cylinder.inside", TrueOrFalse{w.inside}, is_cylinder}};
  add_motion_keys(keys, motion_words, w.motion, w.value);
  keys.push_back({"history", Own{w.history, history_text}});
  return keys;
}

void parse_walls(const SceneNode& node, SceneReading& reading) {
  Scene& scene = reading.scene;
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    require_plain_name(value, "a wall", name);
    if (reading.instances.contains(name)) {
      const auto instance =
          std::find_if(scene.instances.begin(), scene.instances.end(),
                       [&, wall = name](const Instance& i) { return i.name == wall; });
      value.fail("an instance has the name '" + name + "' too (line " +
                 std::to_string(instance->source.line) + "): give the wall another one");
    }
    scene.walls.push_back(parse_wall(value, reading, name));
    reading.walls.insert(name);
  }
}

std::vector<SceneKey> scene_keys(ContactOptions& c) {
  const auto surfaces = [](const ContactOptions& of) {
    return of.all ? "all" : yaml_words({of.first.text(), of.second.text()});
  };
  return {{"between", Own{c, read_between, surfaces}, true, true},
          {"formulation", OneWord{c.formulation, formulation_words}},
          {"enforcement", OneWord{c.enforcement, enforcement_words}},
          {"friction", Own{c.friction, read_friction, friction_text}},
          {"stiffness", Own{c.stiffness, read_contact_stiffness, contact_stiffness_text}},
          {"damping", Number{c.damping, not_negative}},
          {"restitution", Number{c.restitution, not_negative}},
          {"pressures", Own{c.pressures, read_pressures, pressures_text}},
          {"tied", TrueOrFalse{c.tied}},
          {"adjust", Number{c.adjust, not_negative}},
          {"pretension.force", Number{c.pretension_force, not_negative}},
          {"pretension.shortening", Number{c.shortening}},
          {"overlap", OneWord{c.resolves_overlap, overlap_words}, c.resolves_overlap},
          {"interference", Number{c.interference}, c.interference != 0}};
}

void parse_contact(const SceneNode& node, SceneReading& reading) {
  Scene& scene = reading.scene;
  if (node.is_scalar()) {
    if (node.text() != "all")
      node.fail("found '" + node.text() + "', expected all, or a list of {between: ...}");
    ContactOptions contact;
    contact.all = true;
    contact.source = node.source();
    scene.contact.push_back(contact);
    return;
  }
  std::map<std::pair<std::string, std::string>, int> line_of;
  node.for_each_item([&](const SceneNode& item) {
    ContactOptions contact = parse_one_contact(item, reading);
    const auto [earlier, is_new] = line_of.try_emplace(pair_key(contact), contact.source.line);
    if (!is_new)
      item.fail(
          (contact.all ? "all" : "[" + contact.first.text() + ", " + contact.second.text() + "]") +
          " is listed twice (line " + std::to_string(earlier->second) + " too), remove one");
    scene.contact.push_back(std::move(contact));
  });
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces, rigid walls, contact: what may touch what, and how.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// Of length 1. One that has it already, to rounding, is left alone: what is written is read back to
// the last digit.
Vector3 parse_direction(const SceneNode& node) {
  Vector3 v = node.vector3();
  if (std::abs(v.squaredNorm() - 1) <= 8 * std::numeric_limits<double>::epsilon()) return v;
  const double largest = v.cwiseAbs().maxCoeff();
  if (largest == 0) node.fail("found [0, 0, 0], expected a direction: a vector that is not zero");
  v /= largest;  // no square overflows or vanishes
  return v / v.norm();
}

WallOptions parse_wall(const SceneNode& node, const std::filesystem::path& folder,
                       const Scene& scene, const std::string& name) {
  if (node.is_map())
    if (const SceneNode* mass = SceneMap(node, {}).find("mass"))
      mass->fail(
          "is not known of a wall, whose motion is given: a wall with a mass of its own is an "
          "instance with as: rigid, held by boundary where it does not move");
  const SceneMap map = node.map(
      {"plane", "sphere", "cylinder", "displacement", "velocity", "acceleration", "history"});
  WallOptions wall;
  wall.name = name;
  wall.source = node.source();
  GivenMotion given = parse_motion(map, folder, scene);
  wall.motion = given.motion;
  wall.value = given.value;
  wall.history = std::move(given.history);
  const std::string shape = map.exactly_one({"plane", "sphere", "cylinder"});
  const SceneNode& body = map.at(shape);
  if (shape == "plane") {
    wall.kind = WallOptions::Kind::plane;
    const SceneMap plane = body.map({"point", "normal"});
    wall.point = plane.at("point").vector3();
    wall.direction = parse_direction(plane.at("normal"));
    return wall;
  }
  const bool is_sphere = shape == "sphere";
  wall.kind = is_sphere ? WallOptions::Kind::sphere : WallOptions::Kind::cylinder;
  const SceneMap round = is_sphere ? body.map({"center", "radius", "inside"})
                                   : body.map({"point", "axis", "radius", "inside"});
  wall.point = round.at(is_sphere ? "center" : "point").vector3();
  if (!is_sphere) wall.direction = parse_direction(round.at("axis"));
  wall.radius = round.at("radius").positive();
  if (const auto* inside = round.find("inside")) wall.inside = inside->boolean();
  return wall;
}

std::vector<std::string> wall_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const auto& wall : scene.walls) names.push_back(wall.name);
  return names;
}

// INSTANCE.SURFACE or a wall.
SurfaceName parse_partner(const SceneNode& node, const Scene& scene, const SceneNames& known) {
  const std::string text = node.text();
  const std::size_t dot = text.find('.');
  if (dot != std::string::npos && known.walls.contains(text.substr(0, dot)))
    node.fail("found '" + text + "': '" + text.substr(0, dot) +
              "' is a rigid wall, which has no surfaces: name it alone");
  if (dot != std::string::npos) return parse_surface_name(node, scene, known);
  if (known.walls.contains(text)) return {"", text, node.source()};
  const auto names = wall_names(scene);
  const std::string hint = nearest_name(text, names);
  node.fail("found '" + text + "', expected INSTANCE.SURFACE or the name of a wall" + hint +
            (hint.empty() ? ", " : " ") + "walls: " + (names.empty() ? "none" : join(names)));
}

void parse_between(const SceneNode& node, const Scene& scene, const SceneNames& names,
                   ContactOptions& contact) {
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
  contact.first = parse_partner(surfaces[0], scene, names);
  contact.second = parse_partner(surfaces[1], scene, names);
  if (contact.first.text() == contact.second.text())
    node.fail("'" + contact.first.text() + "' cannot be in contact with itself");
  if (contact.first.is_wall() && contact.second.is_wall())
    node.fail("'" + contact.first.text() + "' and '" + contact.second.text() +
              "' are both rigid walls, expected one surface of an instance");
  if (contact.first.is_wall()) std::swap(contact.first, contact.second);
}

// What a key asks for and the enforcement or the formulation cannot do.
void check_enforcement(const SceneMap& map, const ContactOptions& contact) {
  const bool is_nodal = contact.enforcement == Enforcement::nodal,
             is_penalty = contact.enforcement == Enforcement::penalty;
  if (contact.friction > 0 && is_nodal) {
    map.at("friction").fail("'enforcement: nodal' knows no friction, use impulse or penalty");
  }
  if (contact.damping > 0 && !is_penalty) {
    map.at("damping").fail(
        "damping is that of the springs of 'enforcement: penalty': use it, or remove 'damping'");
  }
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
  if (contact.friction > 0)
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
  if (contact.formulation != Formulation::node_face) {
    map.at("formulation")
        .fail(wall + ", which has no nodes and no faces: only 'node-face' goes with it");
  }
}

// What only statics do: a pretension, and overlaps that are pressed apart.
void parse_statics(const SceneMap& map, ContactOptions& contact) {
  if (const auto* pretension = map.find("pretension")) {
    if (contact.all || contact.second.is_wall())
      pretension->fail("pulls two surfaces together: name both in 'between'");
    if (const auto* tied = map.find("tied"); tied != nullptr && !contact.tied)
      tied->fail("surfaces with a pretension are tied: remove 'tied', or 'pretension'");
    const SceneMap of = pretension->map({"force", "shortening"});
    const std::string kind = of.exactly_one({"force", "shortening"});
    (kind == "force" ? contact.pretension_force : contact.shortening) = of.at(kind).number();
    contact.tied = true;
  }
  const auto* overlap = map.find("overlap");
  if (overlap == nullptr) return;
  contact.resolves_overlap = overlap->one_of<bool>({{"keep", false}, {"resolve", true}});
  if (contact.resolves_overlap && contact.tied)
    overlap->fail("tied surfaces keep their distance, remove 'tied' or 'overlap'");
}

std::optional<Index> parse_pressures(const SceneNode& node) {
  if (!node.is_scalar()) node.fail("expected auto, nodes, or a number of functions a face");
  const std::string text = node.text();
  if (text == "auto") return std::nullopt;
  if (text == "nodes") return 0;
  if (text.find_first_not_of("0123456789") != std::string::npos)
    node.fail("found '" + text + "', expected auto, nodes, or a number of functions a face");
  return node.index(1);
}

ContactOptions parse_one_contact(const SceneNode& node, const Scene& scene,
                                 const SceneNames& names) {
  const SceneMap map =
      node.map({"between", "formulation", "enforcement", "friction", "damping", "tied", "adjust",
                "pretension", "overlap", "pressures"});
  ContactOptions contact;
  contact.source = node.source();
  parse_between(map.at("between"), scene, names, contact);
  if (const auto* formulation = map.find("formulation"))
    contact.formulation = formulation->one_of(formulation_words);
  if (const auto* enforcement = map.find("enforcement"))
    contact.enforcement = enforcement->one_of(enforcement_words);
  if (const auto* friction = map.find("friction")) contact.friction = friction->not_negative();
  if (const auto* damping = map.find("damping")) contact.damping = damping->not_negative();
  if (const auto* tied = map.find("tied")) contact.tied = tied->boolean();
  if (const auto* adjust = map.find("adjust")) contact.adjust = adjust->not_negative();
  if (const auto* pressures = map.find("pressures"))
    contact.pressures = parse_pressures(*pressures);
  parse_statics(map, contact);
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

SurfaceName parse_surface_name(const SceneNode& node, const Scene& scene, const SceneNames& names) {
  const std::string text = node.text();
  const auto dot = text.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == text.size())
    node.fail("found '" + text + "', expected INSTANCE.SURFACE");
  return {parse_instance_name(node, text.substr(0, dot), scene, names), text.substr(dot + 1),
          node.source()};
}

void parse_walls(const SceneNode& node, const std::filesystem::path& folder, Scene& scene,
                 SceneNames& names) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    require_plain_name(value, "a wall", name);
    if (names.instances.contains(name)) {
      const auto instance =
          std::find_if(scene.instances.begin(), scene.instances.end(),
                       [&, wall = name](const Instance& i) { return i.name == wall; });
      value.fail("an instance has the name '" + name + "' too (line " +
                 std::to_string(instance->source.line) + "): give the wall another one");
    }
    scene.walls.push_back(parse_wall(value, folder, scene, name));
    names.walls.insert(name);
  }
}

void parse_contact(const SceneNode& node, const SceneNames& names, Scene& scene) {
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
    ContactOptions contact = parse_one_contact(item, scene, names);
    const auto [earlier, is_new] = line_of.try_emplace(pair_key(contact), contact.source.line);
    if (!is_new)
      item.fail(
          (contact.all ? "all" : "[" + contact.first.text() + ", " + contact.second.text() + "]") +
          " is listed twice (line " + std::to_string(earlier->second) + " too), remove one");
    scene.contact.push_back(std::move(contact));
  });
}

namespace {

bool is_named(const ContactOptions& contact, const Instance& instance) {
  return contact.all || contact.first.instance == instance.name ||
         contact.second.instance == instance.name;
}

using Entries = std::vector<const ContactOptions*>;

// What an interface without a coordinate for each dof cannot do. nodal: the entries that are.
void refuse_characteristic(const Entries& nodal, const Instance& instance) {
  for (const ContactOptions* contact : nodal) {
    if (!is_named(*contact, instance)) continue;
    throw InputError(contact->source.text() + ": contact: instance '" + instance.name +
                     "' (basis: characteristic) has no nodal masses, which 'enforcement: nodal' "
                     "needs: use 'enforcement: "
                     "impulse', or basis: craig-bampton");
  }
}

// What an interface without mass cannot do. other: the entries without impulses.
void refuse_massless(const Scene& scene, const Entries& other, const Instance& instance) {
  const std::string its = "instance '" + instance.name + "' (basis: massless) ",
                    cure = ", or reduce it with basis: craig-bampton";
  if (scene.time->integrator == Integrator::newmark)
    throw InputError(scene.time->source.text() + ": time: " + its +
                     "is not available with integrator: newmark: use exact or central-difference" +
                     cure);
  for (const ContactOptions* contact : other) {
    if (!is_named(*contact, instance)) continue;
    throw InputError(contact->source.text() + ": contact: " + its +
                     "has no mass where it touches, which 'enforcement: " +
                     word_of(enforcement_words, contact->enforcement) +
                     "' needs: use 'enforcement: impulse'" + cure);
  }
}

}  // namespace

void check_contact_with_time(const Scene& scene) {
  if (!scene.time) return;
  // A scene of thousands of instances has as many entries, few of which may be refused
  Entries nodal, other;
  for (const ContactOptions& contact : scene.contact) {
    if (contact.enforcement == Enforcement::nodal) nodal.push_back(&contact);
    if (contact.enforcement != Enforcement::impulse) other.push_back(&contact);
  }
  for (const Instance& instance : scene.instances) {
    const auto component = scene.components.find(instance.component);
    const bool is_reduced =
        instance.as == InstanceKind::superelement && component != scene.components.end();
    if (!is_reduced || !component->second.reduction) continue;
    const ReductionOptions& reduction = *component->second.reduction;
    if (reduction.is_massless()) refuse_massless(scene, other, instance);
    if (reduction.is_characteristic()) refuse_characteristic(nodal, instance);
  }
  for (const ContactOptions& contact : scene.contact) {
    if (contact.enforcement == Enforcement::impulse) continue;
    if (scene.time->mass_scaling)
      throw InputError(contact.source.text() + ": contact: 'enforcement: " +
                       word_of(enforcement_words, contact.enforcement) +
                       "' is not available with time.mass_scaling: use 'enforcement: impulse'");
    if (scene.time->integrator != Integrator::newmark) continue;
    throw InputError(contact.source.text() +
                     ": contact: 'enforcement: " + word_of(enforcement_words, contact.enforcement) +
                     "' requires an explicit integrator: with 'integrator: newmark' use "
                     "'enforcement: impulse', which closes " +
                     "the gaps at the end of each step");
  }
}

}  // namespace cbr

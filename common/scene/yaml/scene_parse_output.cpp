// SPDX-License-Identifier: GPL-3.0-or-later
// Output and sweep: what a run writes down.
#include <algorithm>
#include <set>

#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

CheckpointOptions parse_checkpoint(const SceneNode& node, const std::filesystem::path& folder) {
  const SceneMap map = node.map({"every", "every_steps", "every_minutes", "file"});
  CheckpointOptions checkpoint;
  checkpoint.source = node.source();
  const std::string when = map.exactly_one({"every", "every_steps", "every_minutes"});
  if (when == "every") checkpoint.every = map.at(when).positive();
  if (when == "every_steps") checkpoint.every_steps = map.at(when).index(1);
  if (when == "every_minutes") checkpoint.every_minutes = map.at(when).positive();
  if (const auto* file = map.find("file")) checkpoint.file = resolve_path(*file, folder);
  return checkpoint;
}

// INSTANCE.SET, or {instance: ..., elements: [...], worst: N, envelope: true}.
StressOptions parse_stress(const SceneNode& node, const Scene& scene, const SceneNames& names) {
  StressOptions stress;
  stress.source = node.source();
  if (node.is_scalar()) {
    const SurfaceName name = parse_surface_name(node, scene, names);
    stress.instance = name.instance;
    stress.set = name.surface;
    return stress;
  }
  const SceneMap map = node.map({"instance", "elements", "worst", "envelope"});
  stress.instance = parse_instance_name(map.at("instance"), scene, names);
  if (const auto* elements = map.find("elements")) {
    std::set<Index> seen;
    for (const auto& item : elements->list_or_one()) {
      stress.elements.push_back(item.index(1));
      if (!seen.insert(stress.elements.back()).second)
        item.fail("'" + item.text() + "' is listed twice: remove one");
    }
    if (stress.elements.empty()) elements->fail("is empty, expected ids of elements of the mesh");
  }
  if (const auto* worst = map.find("worst")) stress.worst = worst->index(1);
  if (const auto* envelope = map.find("envelope")) stress.envelope = envelope->boolean();
  if (stress.elements.empty() && stress.worst == 0 && !stress.envelope)
    node.fail(
        "names nothing to write: expected elements: [ID, ...], worst: N or envelope: true beside "
        "the instance");
  return stress;
}

void parse_stresses(const SceneNode& node, const SceneNames& names, Scene& scene) {
  std::set<std::string> seen;
  const auto add = [&](const SceneNode& item) {
    const StressOptions stress = parse_stress(item, scene, names);
    const std::string name =
        stress.set.empty() ? stress.instance : stress.instance + "." + stress.set;
    if (!seen.insert(name).second)
      item.fail("'" + name +
                "' is listed twice: " + (stress.set.empty() ? "join the entries" : "remove one"));
    scene.output.stress.push_back(stress);
  };
  if (node.is_map()) return add(node);
  for (const auto& item : node.list_or_one()) add(item);
}

// Sets that `boundary` names.
void parse_reactions(const SceneNode& node, const SceneNames& names, Scene& scene) {
  std::set<std::string> seen;
  for (const auto& item : node.list_or_one()) {
    const SurfaceName name = parse_surface_name(item, scene, names);
    std::vector<std::string> held;
    for (const BoundaryCondition& condition : scene.boundary)
      if (condition.instance == name.instance) held.push_back(condition.nodes);
    if (held.empty())
      item.fail("instance '" + name.instance + "' has no supports, so that nothing reacts on it");
    if (std::find(held.begin(), held.end(), name.surface) == held.end())
      item.fail("'" + name.surface + "' of instance '" + name.instance +
                "' is not held: expected a set that boundary names (" + join(held) + ")");
    if (!seen.insert(item.text()).second)
      item.fail("'" + item.text() + "' is listed twice: remove one");
    scene.output.reactions.push_back(name);
  }
}

}  // namespace

void parse_output(const SceneNode& node, const std::filesystem::path& folder,
                  const SceneNames& names, Scene& scene) {
  const SceneMap map =
      node.map({"every", "history", "fields", "format", "stress", "reactions", "checkpoint"});
  scene.output.source = node.source();
  if (const auto* every = map.find("every")) scene.output.every = every->not_negative();
  if (const auto* history = map.find("history")) {
    std::set<std::string> seen;
    for (const auto& item : history->list_or_one()) {
      scene.output.history.push_back(parse_surface_name(item, scene, names));
      if (!seen.insert(item.text()).second)
        item.fail("'" + item.text() + "' is listed twice: remove one");
    }
  }
  if (const auto* fields = map.find("fields")) {
    for (const auto& item : fields->list_or_one()) {
      scene.output.fields.push_back(
          item.one_of<std::string>({{"displacement", "displacement"},
                                    {"velocity", "velocity"},
                                    {"stress", "stress"},
                                    {"nodal_stress", "nodal_stress"},
                                    {"contact_pressure", "contact_pressure"}}));
    }
    fields->names();  // none twice
  }
  if (const auto* format = map.find("format")) {
    scene.output.format = format->one_of(field_format_words);
    if (scene.output.fields.empty())
      format->fail("is the format of fields, and there are none: add output.fields");
    for (const std::string& field : scene.output.fields)
      if (field == "nodal_stress" && scene.output.format == FieldFormat::exodus)
        format->fail(
            "has no place for nodal_stress, which differs by material: leave it out, or take xdmf");
  }
  if (const auto* stress = map.find("stress")) parse_stresses(*stress, names, scene);
  if (const auto* reactions = map.find("reactions")) parse_reactions(*reactions, names, scene);
  if (const auto* checkpoint = map.find("checkpoint"))
    scene.output.checkpoint = parse_checkpoint(*checkpoint, folder);
}

void parse_sweep(const SceneNode& node, Scene& scene) {
  const SceneMap map = node.map({"from_hz", "to_hz", "points", "spacing", "modes"});
  SweepOptions sweep;
  sweep.source = node.source();
  sweep.from_hz = map.at("from_hz").positive();
  sweep.to_hz = map.at("to_hz").positive();
  if (!(sweep.to_hz > sweep.from_hz))
    map.at("to_hz").fail("found a frequency up to from_hz, expected one above it");
  if (const auto* points = map.find("points")) sweep.points = points->index(2);
  if (const auto* spacing = map.find("spacing"))
    sweep.is_logarithmic = spacing->one_of<bool>({{"linear", false}, {"log", true}});
  if (const auto* modes = map.find("modes")) sweep.modes = modes->index(1);
  scene.sweep = sweep;
}

}  // namespace cbr

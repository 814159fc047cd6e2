// SPDX-License-Identifier: GPL-3.0-or-later
// Output and sweep.
#include <algorithm>
#include <set>

#include "common/base/error.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

const std::vector<std::string> field_names = {"displacement", "velocity",         "stress",
                                              "nodal_stress", "contact_pressure", "contact_slip"};

void read_elements(const SceneNode& node, const SceneReading&, std::vector<Index>& elements) {
  std::set<Index> seen;
  for (const auto& item : node.list_or_one()) {
    elements.push_back(item.index(1));
    if (!seen.insert(elements.back()).second) item.fail_repeated();
  }
  if (elements.empty()) node.fail("is empty, expected ids of elements of the mesh");
}

std::string elements_text(const std::vector<Index>& elements) {
  std::vector<std::string> ids;
  for (const Index id : elements) ids.push_back(std::to_string(id));
  return ids.empty() ? "" : yaml_list(ids);
}

// INSTANCE.SET, or {instance: ..., elements: [...], worst: N, envelope: true}.
StressOptions parse_stress(const SceneNode& node, const SceneReading& reading) {
  StressOptions stress;
  stress.source = node.source();
  if (node.is_scalar()) {
    const SurfaceName name = parse_surface_name(node, reading);
    stress.instance = name.instance;
    stress.set = name.surface;
    return stress;
  }
  read_keys(node, scene_keys(stress), reading);
  if (stress.elements.empty() && stress.worst == 0 && !stress.envelope)
    node.fail(
        "names nothing to write: expected elements: [ID, ...], worst: N or envelope: true beside "
        "the instance");
  return stress;
}

void read_stresses(const SceneNode& node, const SceneReading& reading,
                   std::vector<StressOptions>& stresses) {
  std::set<std::string> seen;
  const auto items = node.is_map() ? std::vector{node} : node.list_or_one();
  for (const SceneNode& item : items) {
    const StressOptions stress = parse_stress(item, reading);
    const std::string name =
        stress.set.empty() ? stress.instance : stress.instance + "." + stress.set;
    if (!seen.insert(name).second)
      item.fail("'" + name +
                "' is listed twice: " + (stress.set.empty() ? "join the entries" : "remove one"));
    stresses.push_back(stress);
  }
}

std::string stresses_text(const std::vector<StressOptions>& stresses) {
  std::vector<std::string> texts;
  for (StressOptions stress : stresses)
    texts.push_back(stress.set.empty() ? flow_map(scene_keys(stress))
                                       : yaml_word(stress.instance + "." + stress.set));
  return texts.empty() ? "" : yaml_list(texts);
}

void read_surfaces(const SceneNode& node, const SceneReading& reading,
                   std::vector<SurfaceName>& surfaces) {
  for (const auto& item : node.list_or_one()) surfaces.push_back(parse_surface_name(item, reading));
  node.names();  // none twice
}

std::string surfaces_text(const std::vector<SurfaceName>& surfaces) {
  std::vector<std::string> names;
  for (const SurfaceName& surface : surfaces) names.push_back(surface.text());
  return yaml_words(names);
}

// Sets that `boundary` names.
void read_reactions(const SceneNode& node, const SceneReading& reading,
                    std::vector<SurfaceName>& reactions) {
  read_surfaces(node, reading, reactions);
  const auto items = node.list_or_one();
  for (std::size_t i = 0; i < items.size(); ++i) {
    const SurfaceName& name = reactions[i];
    std::vector<std::string> held;
    for (const BoundaryCondition& condition : reading.scene.boundary)
      if (condition.instance == name.instance) held.push_back(condition.nodes);
    if (held.empty())
      items[i].fail("instance '" + name.instance +
                    "' has no supports, so that nothing reacts on it");
    if (std::find(held.begin(), held.end(), name.surface) == held.end())
      items[i].fail("'" + name.surface + "' of instance '" + name.instance +
                    "' is not held: expected a set that boundary names (" + join(held) + ")");
  }
}

void read_fields(const SceneNode& node, const SceneReading&, std::vector<std::string>& fields) {
  for (const auto& item : node.list_or_one()) item.choice(field_names);
  fields = node.names();  // none twice
}

void read_checkpoint(const SceneNode& node, const SceneReading& reading,
                     std::optional<CheckpointOptions>& checkpoint) {
  checkpoint.emplace().source = node.source();
  const SceneMap map = read_keys(node, scene_keys(*checkpoint), reading);
  map.exactly_one({"every", "every_steps", "every_minutes"});
}

std::string checkpoint_text(std::optional<CheckpointOptions> checkpoint) {
  return checkpoint ? flow_map(scene_keys(*checkpoint)) : "";
}

void check_format(const SceneNode& node, const OutputOptions& output) {
  if (output.fields.empty())
    node.fail("is the format of fields, and there are none: add output.fields");
  for (const std::string& field : output.fields)
    if (field == "nodal_stress" && output.format == FieldFormat::exodus)
      node.fail(
          "has no place for nodal_stress, which differs by material: leave it out, or take xdmf");
}

}  // namespace

std::vector<SceneKey> scene_keys(CheckpointOptions& checkpoint) {
  return {{"every", Number{checkpoint.every, positive}},
          {"every_steps", WholeNumber{checkpoint.every_steps, 1}},
          {"every_minutes", Number{checkpoint.every_minutes, positive}},
          {"file", File{checkpoint.file}}};
}

std::vector<SceneKey> scene_keys(StressOptions& stress) {
  return {{"instance", instance_name(stress.instance), true, true},
          {"elements", Own{stress.elements, read_elements, elements_text}},
          {"worst", WholeNumber{stress.worst, 1}, stress.worst > 0},
          {"envelope", TrueOrFalse{stress.envelope}, stress.envelope}};
}

std::vector<SceneKey> scene_keys(OutputOptions& out) {
  return {{"every", Number{out.every, not_negative}},
          {"history", Own{out.history, read_surfaces, surfaces_text}},
          {"fields", Own{out.fields, read_fields, yaml_words}},
          {"format", OneWord{out.format, field_format_words}, out.format != FieldFormat::xdmf},
          {"stress", Own{out.stress, read_stresses, stresses_text}},
          {"reactions", Own{out.reactions, read_reactions, surfaces_text}, !out.reactions.empty()},
          {"checkpoint", Own{out.checkpoint, read_checkpoint, checkpoint_text}}};
}

void parse_output(const SceneNode& node, SceneReading& reading) {
  OutputOptions& output = reading.scene.output;
  output.source = node.source();
  const SceneMap map = read_keys(node, scene_keys(output), reading);
  if (const auto* format = map.find("format")) check_format(*format, output);
}

std::vector<SceneKey> scene_keys(SweepOptions& sweep) {
  return {{"from_hz", Number{sweep.from_hz, positive}, true, true},
          {"to_hz", Number{sweep.to_hz, positive}, true, true},
          {"points", WholeNumber{sweep.points, 2}},
          {"spacing", OneWord{sweep.is_logarithmic, spacing_words}},
          {"modes", WholeNumber{sweep.modes, 1}}};
}

void parse_sweep(const SceneNode& node, SceneReading& reading) {
  SweepOptions& sweep = reading.scene.sweep.emplace();
  sweep.source = node.source();
  const SceneMap map = read_keys(node, scene_keys(sweep), reading);
  if (!(sweep.to_hz > sweep.from_hz))
    map.at("to_hz").fail("found a frequency up to from_hz, expected one above it");
}

}  // namespace cbr

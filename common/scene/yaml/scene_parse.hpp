// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/scene/yaml: the scene read and written.
//
// The sections of a scene: in one file each section's keys, their dependences, and the
// values that are no plain numbers or words. scene_read.cpp and scene_write.cpp put them together.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "common/scene/yaml/scene_node.hpp"

namespace cbr {

// The scene so far. Names are looked up: a scene may have thousands of instances, and name each
// many times.
struct SceneReading {
  Scene& scene;
  std::filesystem::path folder;  // absolute, of relative paths
  std::unordered_set<std::string> instances = {}, walls = {};
};

// The names in a map, for the errors of require_known().
template <typename Value>
std::vector<std::string> keys_of(const std::map<std::string, Value>& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

// Of a key of the map; nothing: it is not given.
std::optional<SceneNode> find_key(const SceneMap& map, const std::vector<SceneKey>& keys,
                                  const SceneKey& key);
void read_value(const SceneKey& key, const SceneNode& node, const SceneReading& reading);
// The keys that are given, into the members that they are bound to; unknown and missing keys are
// InputErrors.
SceneMap read_keys(const SceneNode& node, const std::vector<SceneKey>& keys,
                   const SceneReading& reading);

// Keys and their values as YAML, those of a map in the map on one line.
std::vector<std::pair<std::string, std::string>> written(const std::vector<SceneKey>& keys);
// {key: value, ...}
std::string flow_map(const std::vector<SceneKey>& keys);
// A word, in quotes where it needs them.
std::string yaml_word(const std::string& text);
std::string yaml_path(const std::filesystem::path& file);  // absolute; of none: empty
std::string yaml_list(const std::vector<std::string>& items);
std::string yaml_words(const std::vector<std::string>& texts);
std::string yaml_numbers(const std::vector<double>& values);
std::string yaml_vector(const Vector3& v);
std::string yaml_rows(const Matrix3& axes);  // the first two

// Relative to `folder`, which is absolute.
std::filesystem::path resolve_path(const SceneNode& node, const std::filesystem::path& folder);

// `name`, of an instance. InputError at `node` when there is none of that name.
std::string parse_instance_name(const SceneNode& node, const std::string& name,
                                const SceneReading& reading);
// INSTANCE.SURFACE: the first dot is the cut, for instance names have none and surface names may.
SurfaceName parse_surface_name(const SceneNode& node, const SceneReading& reading);
// Names of components, instances and walls become parts of file and dataset names, and
// INSTANCE.SURFACE is cut at a dot.
void require_plain_name(const SceneNode& node, const std::string& kind, const std::string& name);

// The name of an instance.
Own instance_name(std::string& member);
inline const std::string motion_names[] = {"x", "y", "z", "rx", "ry", "rz"};
// Some of them, or of the first three of them.
void read_motions(const SceneNode& node, const SceneReading& reading, std::span<bool> fix);
std::string motions_text(std::span<const bool> fix);
// {time: [...], value: [...]}, {file: CSV} or {sine: {...}}: a table in each case.
void read_history(const SceneNode& node, const SceneReading& reading, History& history);
// [[x, force], ...] with at least two entries: x ascends, and the force never falls.
void read_force_table(const SceneNode& node, ForceTable& table);
std::string force_table_text(const ForceTable& table);  // empty: no table
std::string history_text(const History& history);
// Keys displacement, velocity and acceleration, or by `turn_words` the rotations of these kinds.
// parse_motion() reads them.
void add_motion_keys(std::vector<SceneKey>& keys, const Words<SupportMotion>& words,
                     const SupportMotion& motion, const Vector3& value);
// At most one of displacement, velocity and acceleration, the rotation of the same kind, and their
// history.
struct GivenMotion {
  SupportMotion motion = SupportMotion::none;
  Vector3 value = Vector3::Zero(), turn = Vector3::Zero();
  History history = {};
};
GivenMotion parse_motion(const SceneMap& map, const SceneReading& reading);

// Whether every entry under `components` is a superelement file alone, or has the materials of its
// mesh file: then the scene needs none.
bool needs_no_materials(const SceneNode& node, const std::filesystem::path& folder);

// The keys of a scene that are maps or lists of maps.
std::vector<SceneKey> scene_keys(Material& material, MaterialDamping& damping);
std::vector<SceneKey> scene_keys(Component& component);
std::vector<SceneKey> scene_keys(Component::BlockOptions& block);
std::vector<SceneKey> scene_keys(Component::Point& point);
std::vector<SceneKey> scene_keys(Instance& instance);
std::vector<SceneKey> scene_keys(SkinOptions& skin);
std::vector<SceneKey> scene_keys(FixedSet& set);
std::vector<SceneKey> scene_keys(BoundaryCondition& condition);
std::vector<SceneKey> scene_keys(Load& load);
std::vector<SceneKey> scene_keys(WallOptions& wall);
std::vector<SceneKey> scene_keys(ContactOptions& contact);
std::vector<SceneKey> scene_keys(LinkOptions& link);
std::vector<SceneKey> scene_keys(TimeOptions& time);
std::vector<SceneKey> scene_keys(SweepOptions& sweep);
std::vector<SceneKey> scene_keys(OutputOptions& output);
std::vector<SceneKey> scene_keys(StressOptions& stress);
std::vector<SceneKey> scene_keys(CheckpointOptions& checkpoint);

void parse_materials(const SceneNode& node, SceneReading& reading);
void parse_components(const SceneNode& node, SceneReading& reading);
void read_points(const SceneNode& node, const SceneReading& reading, Component& component);
// After read_points().
void read_reduction(const SceneNode& node, const SceneReading& reading, Component& component);
void parse_instances(const SceneNode& node, SceneReading& reading);
void parse_skin(const SceneNode& node, SceneReading& reading);
void parse_time(const SceneNode& node, SceneReading& reading);
// After parse_time(): a sine lasts until the run's end.
void parse_boundary(const SceneNode& node, SceneReading& reading);
void parse_loads(const SceneNode& node, SceneReading& reading);
void parse_walls(const SceneNode& node, SceneReading& reading);
void parse_contact(const SceneNode& node, SceneReading& reading);
void parse_links(const SceneNode& node, SceneReading& reading);
void parse_output(const SceneNode& node, SceneReading& reading);
void parse_sweep(const SceneNode& node, SceneReading& reading);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of common/scene/yaml: the scene read and written.
//
// The sections of a scene; scene_read.cpp puts them together.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <unordered_set>
#include <vector>

#include "common/scene/yaml/scene_node.hpp"

namespace cbr {

// What later sections refer to, to be looked up: a scene may have thousands of them, and name each
// many times.
struct SceneNames {
  std::unordered_set<std::string> instances, walls;
};

// The names in a map, for the errors of require_known().
template <typename Value>
std::vector<std::string> keys_of(const std::map<std::string, Value>& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

// Relative to `folder`, which is absolute.
std::filesystem::path resolve_path(const SceneNode& node, const std::filesystem::path& folder);

// `name`, of an instance. InputError at `node` when there is none of that name.
std::string parse_instance_name(const SceneNode& node, const std::string& name, const Scene& scene,
                                const SceneNames& names);
// the node's text
std::string parse_instance_name(const SceneNode& node, const Scene& scene, const SceneNames& names);
// INSTANCE.SURFACE: the first dot is the cut, for instance names have none and surface names may.
SurfaceName parse_surface_name(const SceneNode& node, const Scene& scene, const SceneNames& names);
// Names of components, instances and walls become parts of file and dataset names, and
// INSTANCE.SURFACE is cut at a dot.
void require_plain_name(const SceneNode& node, const std::string& kind, const std::string& name);

// Whether every entry under `components` is a superelement file alone, or has the materials of its
// mesh file: then the scene needs none.
bool needs_no_materials(const SceneNode& node);
void parse_materials(const SceneNode& node, Scene& scene);
void parse_components(const SceneNode& node, const std::filesystem::path& folder, Scene& scene);
void parse_instances(const SceneNode& node, Scene& scene, SceneNames& names);

void parse_skin(const SceneNode& node, const std::filesystem::path& folder, Scene& scene);
// After parse_time(): a sine lasts until the run's end.
void parse_boundary(const SceneNode& node, const std::filesystem::path& folder,
                    const SceneNames& names, Scene& scene);
void parse_loads(const SceneNode& node, const std::filesystem::path& folder,
                 const SceneNames& names, Scene& scene);
// {time: [...], value: [...]}, {file: CSV} or {sine: {...}}: a table in each case.
History parse_history(const SceneNode& node, const std::filesystem::path& folder,
                      const Scene& scene);
// At most one of displacement, velocity and acceleration, the rotation of the same kind, and their
// history.
struct GivenMotion {
  SupportMotion motion = SupportMotion::none;
  Vector3 value = Vector3::Zero(), turn = Vector3::Zero();
  History history = {};
};
GivenMotion parse_motion(const SceneMap& map, const std::filesystem::path& folder,
                         const Scene& scene);
void parse_points(const SceneNode& node, Component& component);
// After parse_points().
void parse_reduction(const SceneNode& node, const std::filesystem::path& folder,
                     Component& component);
// After parse_instances().
void parse_links(const SceneNode& node, const SceneNames& names, Scene& scene);
// after parse_time()
void parse_walls(const SceneNode& node, const std::filesystem::path& folder, Scene& scene,
                 SceneNames& names);
void parse_contact(const SceneNode& node, const SceneNames& names, Scene& scene);
void parse_time(const SceneNode& node, Scene& scene);
void parse_output(const SceneNode& node, const std::filesystem::path& folder,
                  const SceneNames& names, Scene& scene);
void parse_sweep(const SceneNode& node, Scene& scene);

}  // namespace cbr

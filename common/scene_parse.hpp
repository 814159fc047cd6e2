// SPDX-License-Identifier: GPL-3.0-or-later
// The sections of a scene; scene_read.cpp puts them together.
#pragma once

#include <filesystem>

#include "common/scene_node.hpp"

namespace cbr {

// Relative to `folder`, which is absolute.
std::filesystem::path resolve_path(const SceneNode& node, const std::filesystem::path& folder);

void parse_materials(const SceneNode& node, Scene& scene);
void parse_components(const SceneNode& node, const std::filesystem::path& folder, Scene& scene);
void parse_instances(const SceneNode& node, Scene& scene);

void parse_skin(const SceneNode& node, const std::filesystem::path& folder, Scene& scene);
void parse_boundary(const SceneNode& node, Scene& scene);
void parse_loads(const SceneNode& node, Scene& scene);
void parse_contact(const SceneNode& node, Scene& scene);
void parse_time(const SceneNode& node, Scene& scene);
void parse_output(const SceneNode& node, Scene& scene);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>

#include "common/base/error.hpp"
#include "common/mesh/io/mesh_formats.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

// A pipe or a device may have no end: what is no text, or longer than any scene, is not read on.
constexpr std::size_t most_bytes = 1'000'000'000;

[[noreturn]] void refuse_size(const std::string& name, const std::string& found) {
  throw InputError(name + ": is " + found + ", a scene has at most 1 GB: give a scene file (YAML)");
}

std::string read_to_end(std::istream& in, const std::string& name) {
  constexpr std::size_t chunk = std::size_t{1} << 20;
  std::string text;
  for (;;) {
    const std::size_t before = text.size();
    if (before > most_bytes) refuse_size(name, "longer than 1 GB");
    text.resize(before + chunk);
    in.read(text.data() + before, static_cast<std::streamsize>(chunk));
    text.resize(before + static_cast<std::size_t>(in.gcount()));
    if (text.find('\0', before) != std::string::npos)
      throw InputError(name + ": is not a text file, expected a scene file (YAML)" +
                       (text.starts_with("\x89HDF")
                            ? "; cbr-reduce --info describes superelements and results"
                            : ""));
    if (!in) return text;
  }
}

std::string read_text(const std::string& file_or_dash) {
  if (file_or_dash == "-") return read_to_end(std::cin, "<stdin>");
  if (file_or_dash.empty())
    throw InputError("'': an empty name, expected that of a scene file, or - for standard input");
  std::error_code error;
  const auto status = fs::status(file_or_dash, error);
  if (status.type() == fs::file_type::not_found) throw InputError(file_or_dash + ": no such file");
  if (!fs::exists(status))
    throw InputError(file_or_dash + ": cannot be opened: " + error.message());
  if (fs::is_directory(status))
    throw InputError(file_or_dash + ": is a directory, expected a scene file");
  if (fs::is_regular_file(status)) {
    const auto size = fs::file_size(file_or_dash, error);
    if (!error && size > most_bytes)
      refuse_size(file_or_dash, "of " + std::to_string(size) + " bytes");
  }
  errno = 0;
  std::ifstream in(file_or_dash, std::ios::binary);
  if (!in.is_open()) throw InputError(file_or_dash + ": cannot be opened: " + std::strerror(errno));
  std::string text = read_to_end(in, file_or_dash);
  if (in.bad()) throw InputError(file_or_dash + ": cannot be read: " + std::strerror(errno));
  return text;
}

void parse_sections(const SceneMap& map, const fs::path& folder, Scene& scene) {
  const auto* components = map.find("components");
  const bool has_materials = map.find("materials") != nullptr;
  if (has_materials || components == nullptr || !needs_no_materials(*components))
    parse_materials(map.at("materials"), scene);
  parse_components(map.at("components"), folder, scene);
  SceneNames names;
  // The order is that of the references, not of the file.
  if (const auto* node = map.find("instances")) parse_instances(*node, scene, names);
  if (const auto* node = map.find("skin")) parse_skin(*node, folder, scene);
  if (const auto* node = map.find("time")) parse_time(*node, scene);
  if (const auto* node = map.find("boundary")) parse_boundary(*node, folder, names, scene);
  if (const auto* node = map.find("loads")) parse_loads(*node, folder, names, scene);
  if (const auto* node = map.find("walls")) parse_walls(*node, folder, scene, names);
  if (const auto* node = map.find("contact")) parse_contact(*node, names, scene);
  if (const auto* node = map.find("links")) parse_links(*node, names, scene);
  if (const auto* node = map.find("output")) parse_output(*node, folder, names, scene);
  if (const auto* node = map.find("sweep")) parse_sweep(*node, scene);
}

}  // namespace

Scene read_scene(const std::string& file_or_dash) {
  const bool is_stdin = file_or_dash == "-";
  const std::string name = is_stdin ? "<stdin>" : file_or_dash;
  if (const std::string cure = foreign_mesh_cure(file_or_dash); !cure.empty())
    throw InputError(name + ": " + cure);
  std::string text = read_text(file_or_dash);
  const YamlTree tree(text, name);
  std::string().swap(text);  // may be large
  if (tree.empty() || tree.kind(tree.root()) == YamlTree::Kind::null) {
    throw InputError(name + ": is empty, expected a scene" +
                     (is_stdin ? " (did the command before this one fail?)" : ""));
  }
  const fs::path folder = is_stdin ? fs::current_path() : fs::absolute(file_or_dash).parent_path();
  const SceneNode root(tree, tree.root(), "", 1);
  Scene scene;
  scene.file = file_or_dash;
  parse_sections(root.map({"materials", "components", "instances", "skin", "boundary", "loads",
                           "walls", "contact", "links", "time", "output", "sweep"}),
                 folder, scene);
  return scene;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>

#include "common/base/error.hpp"
#include "common/base/text_lines.hpp"
#include "common/mesh/io/mesh_formats.hpp"
#include "common/scene/points_of_file.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

// A pipe or a device may have no end: reading stops at bytes that are no text, or beyond the length
// of any scene.
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
    const std::string_view begin = without_mark(text, name);
    if (text.find('\0', before) != std::string::npos)
      throw InputError(name + ": is not a text file, expected a scene file (YAML)" +
                       (begin.starts_with("\x89HDF")
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

void parse_sections(const SceneMap& map, SceneReading& reading) {
  const auto* components = map.find("components");
  if (map.find("materials") != nullptr || components == nullptr ||
      !needs_no_materials(*components, reading.folder))
    parse_materials(map.at("materials"), reading);
  parse_components(map.at("components"), reading);
  // The order is that of the references, not of the file.
  using Parse = void (*)(const SceneNode&, SceneReading&);
  constexpr std::pair<const char*, Parse> sections[] = {
      {"instances", parse_instances}, {"skin", parse_skin},   {"time", parse_time},
      {"boundary", parse_boundary},   {"loads", parse_loads}, {"walls", parse_walls},
      {"contact", parse_contact},     {"links", parse_links}, {"output", parse_output},
      {"sweep", parse_sweep}};
  for (const auto& [section, parse] : sections)
    if (const SceneNode* node = map.find(section)) parse(*node, reading);
}

struct ReadValue {
  const SceneNode& node;
  const SceneReading& reading;

  void operator()(const OneWord& v) const { v.take(node.choice(v.allowed())); }
  void operator()(const Number& v) const { v.place.set(node.number(v.bounds)); }
  void operator()(const WholeNumber& v) const { v.place.set(node.index(v.least)); }
  void operator()(const TrueOrFalse& v) const { v.member = node.boolean(); }
  void operator()(const NameList& v) const { v.names = node.names(); }
  void operator()(const NamesOrTrue& v) const {
    if (node.is_scalar()) {
      v.member = node.boolean();
      return;
    }
    v.names = node.names();
    if (v.names.empty())
      node.fail("is empty, expected sets or element blocks of the mesh, or true");
    v.member = true;
  }
  void operator()(const ThreeNumbers& v) const { v.place.set(node.vector3()); }
  void operator()(const Text& v) const { v.member = node.text(); }
  void operator()(const File& v) const { v.member = resolve_path(node, reading.folder); }
  void operator()(const Own& v) const {
    if (v.read) v.read(node, reading);
  }
  void operator()(const Retired& v) const { node.fail("is retired: " + v.successor); }
};

}  // namespace

void read_value(const SceneKey& key, const SceneNode& node, const SceneReading& reading) {
  std::visit(ReadValue{node, reading}, key.value);
}

std::optional<SceneNode> find_key(const SceneMap& map, const std::vector<SceneKey>& keys,
                                  const SceneKey& key) {
  const auto found = [&](const SceneMap& in, const std::string& name) {
    const SceneNode* value = key.is_required ? &in.at(name) : in.find(name);
    return value != nullptr ? std::optional(*value) : std::nullopt;
  };
  const auto dot = key.key.find('.');
  if (dot == std::string::npos) return found(map, key.key);
  const std::string head = key.key.substr(0, dot);
  const SceneNode* inside = map.find(head);
  if (inside == nullptr) return std::nullopt;
  return found(inside->map_of(keys, head), key.key.substr(dot + 1));
}

SceneMap read_keys(const SceneNode& node, const std::vector<SceneKey>& keys,
                   const SceneReading& reading) {
  SceneMap map = node.map_of(keys);
  for (const SceneKey& key : keys)
    if (const auto value = find_key(map, keys, key)) read_value(key, *value, reading);
  return map;
}

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
  const SceneNode root(tree, tree.root(), "", 1);
  Scene scene;
  scene.file = file_or_dash;
  SceneReading reading{scene,
                       is_stdin ? fs::current_path() : fs::absolute(file_or_dash).parent_path()};
  parse_sections(root.map({"materials", "components", "instances", "skin", "boundary", "loads",
                           "walls", "contact", "links", "time", "output", "sweep"}),
                 reading);
  drop_idle_points(scene);
  return scene;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include <yaml-cpp/eventhandler.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>

#include "common/error.hpp"
#include "common/scene_parse.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

std::string read_text(const std::string& file_or_dash) {
  if (file_or_dash == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  std::error_code error;
  const auto status = fs::status(file_or_dash, error);
  if (!fs::exists(status)) throw InputError(file_or_dash + ": no such file");
  if (fs::is_directory(status)) throw InputError(file_or_dash + ": is a directory, expected a scene file");
  errno = 0;
  std::ifstream in(file_or_dash, std::ios::binary);
  if (!in.is_open()) throw InputError(file_or_dash + ": cannot be opened: " + std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw InputError(file_or_dash + ": cannot be read: " + std::strerror(errno));
  return text;
}

// Where documents begin, at most two of them.
class DocumentStarts : public YAML::EventHandler {
 public:
  std::vector<int> lines;
  void OnDocumentStart(const YAML::Mark& mark) override { lines.push_back(mark.line + 1); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

// YAML::LoadAll() makes documents without end of a text that begins with what can begin none, such as ']'; YAML::Load() stops after
// the first document whatever follows.
void require_one_document(const std::string& text, const std::string& name) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStarts starts;
  for (int i = 0; i < 2 && parser.HandleNextDocument(starts); ++i) {
  }
  if (starts.lines.size() > 1)
    throw InputError(name + ":" + std::to_string(starts.lines[1]) +
                     ": a second YAML document begins here, or what stands here belongs to none: expected one document");
}

YAML::Node parse_yaml(const std::string& text, const std::string& name) {
  // The parser lets a null character end the file or become part of a word.
  if (text.find('\0') != std::string::npos) throw InputError(name + ": is not a text file");
  try {
    require_one_document(text, name);
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    throw InputError(name + line + ": is not valid YAML: " + error.msg);
  }
}

void parse_sections(const SceneMap& map, const fs::path& folder, Scene& scene) {
  parse_materials(map.at("materials"), scene);
  parse_components(map.at("components"), folder, scene);
  // The order is that of the references, not of the file.
  if (const auto* node = map.find("instances")) parse_instances(*node, scene);
  if (const auto* node = map.find("skin")) parse_skin(*node, folder, scene);
  if (const auto* node = map.find("boundary")) parse_boundary(*node, scene);
  if (const auto* node = map.find("loads")) parse_loads(*node, scene);
  if (const auto* node = map.find("walls")) parse_walls(*node, scene);
  if (const auto* node = map.find("contact")) parse_contact(*node, scene);
  if (const auto* node = map.find("time")) parse_time(*node, scene);
  if (const auto* node = map.find("output")) parse_output(*node, folder, scene);
}

}  // namespace

Scene read_scene(const std::string& file_or_dash) {
  const bool is_stdin = file_or_dash == "-";
  const std::string name = is_stdin ? "<stdin>" : file_or_dash;
  const YAML::Node tree = parse_yaml(read_text(file_or_dash), name);
  if (!tree.IsDefined() || tree.IsNull()) {
    throw InputError(name + ": is empty, expected a scene" + (is_stdin ? " (did the command before this one fail?)" : ""));
  }
  const fs::path folder = is_stdin ? fs::current_path() : fs::absolute(file_or_dash).parent_path();
  const SceneNode root(tree, name, "", 1);
  Scene scene;
  scene.file = file_or_dash;
  try {
    parse_sections(
        root.map({"materials", "components", "instances", "skin", "boundary", "loads", "walls", "contact", "time", "output"}),
        folder, scene);
  } catch (const YAML::Exception& error) {
    throw InputError(name + ": is not a valid scene: " + error.what());
  }
  return scene;
}

}  // namespace cbr

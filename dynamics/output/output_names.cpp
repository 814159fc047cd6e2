// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/output_names.hpp"

#include <fstream>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/netcdf_file.hpp"
#include "common/files/output_file.hpp"
#include "common/files/replaced_file.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/output/exodus_fields.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

constexpr const char* sweep_header = "surface,frequency_hz,";

struct Target {
  fs::path file;
  std::string what, option;  // "the results", "--output"
  bool is_exodus = false;
  std::string cure() const { return "give " + option + " another name"; }
};

std::vector<Target> targets_of(const Scene& scene, const RunFiles& files) {
  const bool fields = !scene.output.fields.empty();
  std::vector<Target> targets{{files.results, "the results", "--output"}};
  if (fields && scene.output.format == FieldFormat::exodus)
    targets.push_back({exodus_file(files.results), "the fields", "--output", true});
  if (fields && scene.output.format == FieldFormat::xdmf) {
    targets.push_back({fields_file(files.results), "the fields", "--output"});
    targets.push_back({xdmf_file(files.results), "the fields", "--output"});
  }
  if (scene.output.checkpoint) {
    const fs::path file = checkpoint_file(*scene.output.checkpoint, files.results, files.restart);
    targets.push_back({file, "the checkpoint", "output.checkpoint.file"});
    if (fields)
      targets.push_back(
          {fields_of_checkpoint(file), "the checkpoint's fields", "output.checkpoint.file"});
  }
  if (!files.table.empty()) targets.push_back({files.table, "the table", "--output"});
  if (!files.timings.empty()) targets.push_back({files.timings, "the timings", "--timings"});
  return targets;
}

void refuse_input(const Target& target, const fs::path& input, const std::string& what) {
  if (input.empty() || !is_same_file(input, target.file)) return;
  throw InputError(target.file.string() + ": " + target.what + " would replace " + what + ": " +
                   target.cure());
}

void refuse_inputs(const Target& target, const Scene& scene, const RunFiles& files) {
  if (scene.file != "-") refuse_input(target, scene.file, "the scene");
  for (const auto& [name, component] : scene.components) {
    refuse_input(target, component.mesh, "the mesh of component '" + name + "'");
    if (component.reduction)
      refuse_input(target, component.reduction->superelement,
                   "the superelement of component '" + name + "'");
  }
  // Checkpoints follow one another under one name
  if (files.restart.empty() || target.option == "output.checkpoint.file") return;
  refuse_input(target, files.restart, "the checkpoint");
  if (!scene.output.fields.empty())
    refuse_input(target, fields_of_checkpoint(files.restart), "the checkpoint's fields");
}

// Files of before there was a format have the groups alone.
bool holds_fields(const fs::path& file) {
  try {
    const Hdf5Reader reader(file);
    return !reader.has_attribute("/", "format") && reader.has("/grids");
  } catch (const InputError&) {
    return false;
  }
}

void refuse_other_text(const Target& target, const std::string& words, const std::string& kind) {
  std::error_code error;
  if (!fs::is_regular_file(target.file, error) || fs::file_size(target.file, error) == 0) return;
  std::string start(200, '\0');
  std::ifstream(target.file).read(start.data(), static_cast<std::streamsize>(start.size()));
  if (start.find(words) != std::string::npos) return;
  throw InputError(target.file.string() + ": exists and is not " + kind + "; " + target.what +
                   " would overwrite it: " + target.cure());
}

// A mesh, and the results of another program: Exodus files are told by their title.
void refuse_other_exodus(const Target& target) {
  std::error_code error;
  if (!fs::is_regular_file(target.file, error) || fs::file_size(target.file, error) == 0) return;
  try {
    if (NetcdfReader(target.file).text("", "title").starts_with(exodus_title)) return;
  } catch (const InputError&) {  // another kind of file
  }
  throw InputError(target.file.string() + ": exists and holds no fields of cbr-dyn; " +
                   target.what + " would overwrite it: " + target.cure());
}

void refuse_other_fields(const Target& target) {
  const std::string suffix = target.file.extension().string();
  if (suffix == ".xdmf") return refuse_other_text(target, "<Xdmf", "an XDMF file");
  if (target.is_exodus) return refuse_other_exodus(target);
  if (!holds_fields(target.file))
    refuse_other_file(target.file, {"cbr-fields"}, target.what, target.cure());
}

}  // namespace

fs::path exodus_file(const fs::path& results) {
  return fs::path(results).replace_extension(".exo");
}
fs::path xdmf_file(const fs::path& results) { return fs::path(results).replace_extension(".xdmf"); }
fs::path fields_file(const fs::path& results) {
  return fs::path(results).replace_extension(".fields.h5");
}

void check_outputs(const Scene& scene, const RunFiles& files) {
  const std::vector<Target> targets = targets_of(scene, files);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if (is_same_file(targets[i].file, targets[j].file))
        throw InputError(targets[i].file.string() + ": is the file of both " + targets[j].what +
                         " and " + targets[i].what + ": " + targets[i].cure());
    refuse_inputs(targets[i], scene, files);
  }
  for (const Target& target : targets) {
    if (target.what == "the results")
      refuse_other_file(target.file, {files.format}, target.what, target.cure());
    if (target.what == "the fields" || target.what == "the checkpoint's fields")
      refuse_other_fields(target);
    if (target.what == "the table") refuse_other_text(target, sweep_header, "a table of a sweep");
    const TemporaryFile probe(target.file);
  }
}

}  // namespace cbr

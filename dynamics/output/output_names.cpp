// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/output/output_names.hpp"

#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/files/checked_files.hpp"
#include "common/files/output_file.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/output/field_formats.hpp"

namespace cbr {
namespace {

namespace fs = std::filesystem;

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
  // The checkpoints of a run share one name
  if (files.restart.empty() || target.option == "output.checkpoint.file") return;
  refuse_input(target, files.restart, "the checkpoint");
  if (!scene.output.fields.empty())
    refuse_input(target, fields_of_checkpoint(files.restart), "the checkpoint's fields");
}

// Kind of file that each output may replace.
FileKind kind_of(const Target& target, const RunFiles& files) {
  if (target.is_exodus)
    return {.noun = "an Exodus file", .netcdf_title = std::string(exodus_title) + "( .*)?"};
  if (target.what == "the table")
    return {.noun = "a table of a sweep", .start = "^surface,frequency_hz,"};
  if (target.file.extension() == ".xdmf")
    return {.noun = "an XDMF file",
            .start = "<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"time\""};
  if (target.what == "the results") return {.noun = "results", .hdf5_formats = {files.format}};
  return {.noun = "fields", .hdf5_formats = {"cbr-fields"}};
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
    // checkpoint_file() and Report have checked these
    if (target.what != "the checkpoint" && target.what != "the timings")
      refuse_other_file(target.file, kind_of(target, files), target.what, target.cure());
    const TemporaryFile probe(target.file);
  }
}

}  // namespace cbr

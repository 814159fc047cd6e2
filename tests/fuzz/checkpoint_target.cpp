// SPDX-License-Identifier: GPL-3.0-or-later
// A damaged checkpoint: `cbr-dyn --restart` refuses it, or goes on as if nothing had been.
#include <algorithm>
#include <optional>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/linalg/blas_threads.hpp"
#include "dynamics/output/checkpoint.hpp"
#include "dynamics/program.hpp"
#include "tests/fuzz/hdf5_edits.hpp"
#include "tests/fuzz/run_scene.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::fuzz {
namespace {

namespace fs = std::filesystem;

// What there is of a run.
struct Ran {
  Vector total;
  Points momentum;
  bool operator==(const Ran& other) const {
    return total == other.total && momentum == other.momentum;
  }
};

Ran read_results(const fs::path& file) {
  const Hdf5Reader reader(file);
  return {reader.read_vector("/energy/total"), reader.read_points("/instances/b/momentum")};
}

// A folder with a scene, which goes on from `checkpoint` and its fields; what they were after step
// 10 of 13.
struct Base {
  fs::path scene, results, checkpoint, fields;
  std::string checkpoint_bytes, fields_bytes;
  Ran whole;
};

void run(const Base& base, const fs::path& scene, const fs::path& restart) {
  Report report("cbr-dyn", Verbosity::quiet);
  run_scene(scene.string(), base.results, report, {}, restart);
}

Base make_base() {
  set_threads(1);
  const fs::path folder = scratch().path() / "checkpoint";
  fs::create_directories(folder);
  Base base{folder / "scene.yaml",
            folder / "run.h5",
            folder / "kept.h5",
            folder / "kept.fields.h5",
            "",
            "",
            {}};
  write_mesh(test::block_mesh({{1, 1, 2}}), folder / "block.exo");
  const std::string text =
      R"(materials: {rubber: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}
components:
  block: {mesh: block.exo, material: rubber, reduction: {interface: [z_min, z_max], modes: 5}}
instances:
  a: {component: block, as: superelement, velocity: [0.1, 0, 1]}
  b: {component: block, as: mesh, position: [0.3, 0.2, 1.0001]}
contact: [{between: [a.z_max, b.z_min], friction: 0.2}]
time: {end: 0.13, step: 0.01}
output: {every: 0.02, fields: [displacement])";
  test::write_bytes(base.scene, text + "}\n");
  const fs::path keeps = folder / "keeps.yaml";
  test::write_bytes(keeps, text + ", checkpoint: {every_steps: 10, file: kept.h5}}\n");
  reduced_scene(base.scene.string());
  run(base, keeps, {});
  base.whole = read_results(base.results);
  base.checkpoint_bytes = test::bytes_of(base.checkpoint);
  base.fields_bytes = test::bytes_of(base.fields);
  run(base, base.scene, base.checkpoint);
  require(read_results(base.results) == base.whole,
          "a run that goes on differs from one that was not interrupted");
  return base;
}

// Single bytes changed, and the end cut off half of the times.
std::string damaged(std::string file, ByteSource& source) {
  const bool cut = source.below(2) == 0;
  if (cut) file.resize(source.take<std::uint32_t>() % (file.size() + 1));
  for (int n = 0; n < 8 && !source.empty() && !file.empty(); ++n) {
    const std::size_t at = source.take<std::uint32_t>() % file.size();
    file[at] = source.take<char>();
  }
  return file;
}

}  // namespace

void checkpoint(Bytes bytes) {
  static const Base base = make_base();
  ByteSource source(bytes);
  std::string kept = base.checkpoint_bytes, fields = base.fields_bytes;
  const std::size_t kind = source.below(4);
  if (kind == 0) kept = damaged(kept, source);
  if (kind == 1) fields = damaged(fields, source);
  test::write_bytes(base.checkpoint, kept);
  test::write_bytes(base.fields, fields);
  if (kind >= 2) edit_hdf5(kind == 2 ? base.checkpoint : base.fields, source);
  try {
    threads_of_checkpoint(base.checkpoint);
    run(base, base.scene, base.checkpoint);
  } catch (const InputError&) {
    return;
  } catch (const RunError&) {
    return;
  }
  require(read_results(base.results) == base.whole,
          "a run goes on from a damaged checkpoint as another");
}

}  // namespace cbr::fuzz

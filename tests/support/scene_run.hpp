// SPDX-License-Identifier: GPL-3.0-or-later
// Whole scenes inside a test: generated meshes and a scene in YAML, reduced, built and run in this
// process.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/setup/build.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/block_mesh.hpp"

namespace cbr::test {

// "1.2345678901234567e-07", and "[1, 2, 3]": text for YAML that reads back exactly.
std::string text(double value);
std::string text(const Vector3& value);

struct Ran {
  Scene scene;
  BuiltScene built;  // with simulation.pairs as after the run
  RunResult result;

  // "left.x_max", in output.history
  const RunResult::OfMonitor& monitor(const std::string& surface) const;
  const RunResult::OfBody& body(const std::string& instance) const;
  double mass(const std::string& instance) const;
};

// A temporary folder with meshes, superelements and scenes.
class SceneFolder {
 public:
  SceneFolder() { set_threads(1); }  // small scenes; other tests run at the same time

  // `file` with a suffix of write_mesh: .exo allows names up to 32 characters.
  void add(const std::string& file, const Mesh& mesh) { write_mesh(mesh, folder_ / file); }

  // Reduces and runs a scene as cbr-reduce and cbr-dyn do; mesh files by their plain name. Reuses
  // components that were reduced in this folder. Throws the programs' errors.
  Ran run(const std::string& yaml, const RunOptions& options = {}) const;
  // The same without the run.
  Ran prepare(const std::string& yaml) const;

  const TemporaryFolder& folder() const { return folder_; }

  std::optional<Index> diagonal_limit;  // --diagonal-limit of both programs

 private:
  TemporaryFolder folder_;
};

// Row i of a series.
inline Vector3 at(const Series3& series, std::size_t i) {
  return Eigen::Map<const Vector3>(series.values.data() + 3 * i);
}

inline double last(const Series3& series, int axis = 0) {
  return series.values[series.values.size() - 3 + static_cast<std::size_t>(axis)];
}

// Sum over all bodies with the series, at output k; and its largest change since the start.
Vector3 total(const RunResult& result, Series3 RunResult::OfBody::*series, std::size_t k);
double largest_change(const RunResult& result, Series3 RunResult::OfBody::*series);

// Integral of a series times the intervals since the last output: an impulse from mean forces.
Vector3 integral(const RunResult& result, const Series3& series);

// sqrt(mean over the outputs of |value(t) - expected(t)|^2), in units of the series.
double rms(const RunResult& result, const Series3& series,
           const std::function<Vector3(double)>& expected);

// Largest |total - total(0) - work_external - work_contact - work_friction - ...| of the run,
// relative to the largest total or work.
double energy_residual(const RunResult& result);

// Slope of log(error) over log(h), by least squares.
double observed_order(const std::vector<double>& h, const std::vector<double>& error);

}  // namespace cbr::test

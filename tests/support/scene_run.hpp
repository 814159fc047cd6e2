// SPDX-License-Identifier: GPL-3.0-or-later
// Whole scenes inside a test: meshes made in code, a scene in YAML, reduced, built and run in this
// process.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/linalg/blas_threads.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/setup/build.hpp"
#include "tests/formats/temporary_folder.hpp"

namespace cbr::test {

// A block of hex8 from the origin to `size`, n elements along each edge, then moved by `map` (which
// must not turn elements inside out). Block "block"; sidesets x_min, x_max, y_min, y_max, z_min,
// z_max, contact loads and supports find them by name.
struct BlockShape {
  std::array<Index, 3> n{1, 1, 1};
  Vector3 size = Vector3::Ones();
  std::function<Vector3(const Vector3&)> map = {};
};
Mesh block_mesh(const BlockShape& shape);

// Random order and ids of nodes and elements, and random corners that the hexes start at, by
// `seed`: the same body. hex8 only.
Mesh renumbered(const Mesh& mesh, unsigned seed);

// "1.2345678901234567e-07", and "[1, 2, 3]": numbers for YAML that read back the same.
std::string text(double value);
std::string text(const Vector3& value);

struct Ran {
  Scene scene;
  BuiltScene built;  // simulation.pairs as the run has left them
  RunResult result;

  // "left.x_max", in output.history
  const RunResult::OfMonitor& monitor(const std::string& surface) const;
  const RunResult::OfBody& body(const std::string& instance) const;
  double mass(const std::string& instance) const;
};

// A folder of its own with meshes, superelements and scenes, gone with the object.
class SceneFolder {
 public:
  SceneFolder() { set_threads(1); }  // small scenes, and other tests run beside this one

  // `file` with a suffix that write_mesh knows: .exo holds names up to 32 characters.
  void add(const std::string& file, const Mesh& mesh) { write_mesh(mesh, folder_ / file); }

  // What cbr-reduce and cbr-dyn do with this scene; mesh files by their plain name. A component
  // that has been reduced in this folder is taken as it is. Throws what they throw.
  Ran run(const std::string& yaml, const RunOptions& options = {}) const;
  // The same, without the run.
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

// Over all bodies that have the series, at output k; and its largest change since the start.
Vector3 total(const RunResult& result, Series3 RunResult::OfBody::*series, std::size_t k);
double largest_change(const RunResult& result, Series3 RunResult::OfBody::*series);

// Integral of a series times the intervals since the last output: an impulse from mean forces.
Vector3 integral(const RunResult& result, const Series3& series);

// sqrt(mean over the outputs of |value(t) - expected(t)|^2), in units of the series.
double rms(const RunResult& result, const Series3& series,
           const std::function<Vector3(double)>& expected);

// Largest |total - total(0) - work_external - work_contact - work_friction - ...| of the run, as a
// share of the largest total or work.
double energy_residual(const RunResult& result);

// Slope of log(error) over log(h), by least squares.
double observed_order(const std::vector<double>& h, const std::vector<double>& error);

}  // namespace cbr::test

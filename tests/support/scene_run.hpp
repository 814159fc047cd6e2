// SPDX-License-Identifier: GPL-3.0-or-later
// Whole scenes inside a test: generated meshes and a scene in YAML, reduced, built and run in this
// process.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/mesh/mesh.hpp"
#include "common/scene/scene.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/setup/build.hpp"
#include "tests/formats/temporary_folder.hpp"

namespace cbr::test {

// A block of hex8 from the origin to `size`, n elements along each edge, then moved by `map` (which
// must not invert elements). Block "block"; sidesets x_min, x_max, y_min, y_max, z_min, z_max for
// contact, loads and supports.
struct BlockShape {
  std::array<Index, 3> n{1, 1, 1};
  Vector3 size = Vector3::Ones();
  std::function<Vector3(const Vector3&)> map = {};
};
Mesh block_mesh(const BlockShape& shape);

// The same body with random order and ids of nodes and elements, and random first corners of the
// hexes, by `seed`. hex8 only.
Mesh renumbered(const Mesh& mesh, unsigned seed);

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

// Old index of each new one: a permutation of 0 .. n - 1.
// Random orders of nodes and elements.
std::vector<Index> random_order(Index n, std::mt19937& random);
std::vector<Index> inverse(const std::vector<Index>& order);

}  // namespace cbr::test

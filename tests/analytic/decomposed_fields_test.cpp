// SPDX-License-Identifier: GPL-3.0-or-later
// Fields of a component in domains are those of the component in one piece, point by point and cell
// by cell.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "common/files/hdf5_file.hpp"
#include "dynamics/output/fields.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::test::decomposed_fields_test {
namespace {

// in steps far above round-off, far below the distance of nodes
using Place = std::array<Index, 3>;

Place place_of(const Vector3& x) {
  Place place;
  for (int i = 0; i < 3; ++i) place[i] = std::llround(1e6 * x[i]);
  return place;
}

struct Fields {
  std::map<Place, Vector> at_points;  // displacement, velocity
  std::map<Place, Vector> of_cells;   // stress, by the cell's centre
};

struct Case {
  Index domains = 1, modes = 0;
  std::string more, integrator;
};

Fields run(const Case& c) {
  SceneFolder folder;
  if (c.integrator != "exact") folder.diagonal_limit = 0;
  folder.add("part.exo", block_mesh({{5, 3, 4}, Vector3(1, 0.6, 0.8), [](const Vector3& x) {
                                       return Vector3(x[0], x[1] * (1 + 0.1 * x[0]),
                                                      x[2] + 0.05 * x[0] * x[1]);
                                     }}));
  Ran ran = folder.prepare(
      "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
      "components:\n  part: {mesh: part.exo, material: m, reduction: {interface: [x_min, x_max], "
      "recovery: true, modes: " +
      std::to_string(c.modes) + ", domains: " + std::to_string(c.domains) + c.more + "}}\n" +
      "instances:\n  a: {component: part, rotation: [0, 0, 30]}\n"
      "  b: {component: part, mirror: y, position: [0.97, 2.61, 0.013], rotation: [10, 0, 30], "
      "velocity: [-0.3, -0.2, 0.05]}\n"
      "boundary: [{instance: a, nodes: x_min, fix: [x, z]}]\n"
      "loads:\n  - {instance: a, surface: x_max, traction: [2, -1, 3]}\n  - {instance: b, surface: "
      "x_max, traction: [1, 1, -3]}\n"
      "time: {end: 0.1, step: 1.0e-3, integrator: " +
      c.integrator + "}\noutput: {every: 0.05, fields: [displacement, velocity, stress]}\n");
  Report report("test", Verbosity::quiet);
  FieldWriter writer(ran.scene, ran.built, folder.folder() / "results.h5", report);
  RunOptions options;
  options.on_output = [&](Index, double t) { writer.add(t); };
  cbr::run(ran.built.simulation, options);
  writer.commit();
  const Hdf5Reader file(folder.folder() / "results.fields.h5");
  Fields fields;
  for (const std::string& grid : file.children("/grids")) {
    const std::string step = "/steps/2/" + grid + "/";
    const Points x = file.read_points("/grids/" + grid + "/points");
    const Points u = file.read_points(step + "displacement"),
                 v = file.read_points(step + "velocity");
    if (!file.has(step + "stress_xx")) continue;
    const IndexTable cells = file.read_index_table("/grids/" + grid + "/cells");
    Matrix stress(cells.rows(), 7);
    for (Index i = 0; i < 7; ++i)
      stress.col(i) = file.read_matrix(step + datasets_of("stress")[i]).col(0);
    for (Index i = 0; i < x.rows(); ++i) {
      Vector motion(6);
      motion << u.row(i).transpose(), v.row(i).transpose();
      const auto [known, is_new] = fields.at_points.try_emplace(place_of(x.row(i)), motion);
      // A node that domains share moves in one way.
      EXPECT_LT((known->second - motion).norm(), 1e-12) << grid;
    }
    for (Index e = 0; e < cells.rows(); ++e) {
      const Vector3 center = x(cells.row(e), Eigen::all).colwise().mean();
      EXPECT_TRUE(fields.of_cells.try_emplace(place_of(center), stress.row(e)).second);
    }
  }
  return fields;
}

void expect_same(const std::map<Place, Vector>& one, const std::map<Place, Vector>& many,
                 std::size_t size) {
  ASSERT_EQ(one.size(), size);
  ASSERT_EQ(many.size(), size);
  double scale = 0;
  for (const auto& [place, value] : one) scale = std::max(scale, value.norm());
  ASSERT_GT(scale, 1e-3);
  for (const auto& [place, value] : one) {
    const auto other = many.find(place);
    ASSERT_NE(other, many.end());
    EXPECT_LT((other->second - value).norm(), 1e-9 * scale);
  }
}

class DecomposedFields : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Integrators, DecomposedFields,
                         testing::Values("exact", "central-difference", "newmark"),
                         [](const auto& of) {
                           return of.param == "central-difference" ? "central" : of.param;
                         });

TEST_P(DecomposedFields, AreThoseOfThePartInOnePiece) {
  constexpr std::size_t nodes = 2 * 6 * 4 * 5, cells = 2 * 5 * 3 * 4;
  constexpr Index interior = 3 * 4 * 4 * 5;
  const Fields one = run({1, interior, "", GetParam()});
  for (const Case& c :
       {Case{4, 100000, "", GetParam()},
        Case{3, 100000, ", second_reduction: {modes: " + std::to_string(interior) + "}",
             GetParam()}}) {
    const Fields many = run(c);
    expect_same(one.at_points, many.at_points, nodes);
    expect_same(one.of_cells, many.of_cells, cells);
  }
}

}  // namespace
}  // namespace cbr::test::decomposed_fields_test

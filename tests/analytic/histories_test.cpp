// SPDX-License-Identifier: GPL-3.0-or-later
// Loads as users write them: pressure, sine and CSV histories, against closed forms and against the
// same load written out.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "common/base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::histories_test {
namespace {

using test::at;
using test::Ran;
using test::SceneFolder;
using test::text;

// A bar of one element between a wall and a face that swings along x: omega = 20, stiffness 200.
constexpr double omega = 20, stiffness = 200, zeta = 0.05;

class OfHistories : public ::testing::Test {
 protected:
  OfHistories() { folder.add("one.exo", test::block_mesh({{1, 1, 1}, {1, 1, 1}})); }

  std::string scene(const std::string& load, double end = 1, double every = 0.02,
                    const std::string& placed = "", const std::string& as = "superelement") const {
    return "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1, damping: "
           "{alpha: 2}}\ncomponents:\n"
           "  bar: {mesh: one.exo, material: soft, mass: lumped, reduction: {interface: [x_min, "
           "x_max, y_max], modes: 0}}\n"
           "instances:\n  bar: {component: bar, as: " +
           as + placed +
           "}\nboundary:\n  - {instance: bar, nodes: x_min, fix: [x, y, z]}\nloads:\n  - "
           "{instance: bar, " +
           load + "}\ntime: {end: " + text(end) + "}\noutput: {every: " + text(every) +
           ", history: [bar.x_max]}\n";
  }

  std::string refusal(const std::string& load) const {
    return test::refusal_of([&] { folder.prepare(scene(load)); });
  }

  void write(const std::string& file, const std::string& lines) const {
    std::ofstream(folder.folder().path() / file) << lines;
  }

  SceneFolder folder;
};

// Of the steady swing under a force of amplitude 1, from the last of 20 periods after all else has
// died away.
double steady_amplitude(const SceneFolder& folder, const std::string& yaml, double frequency) {
  const Ran ran = folder.run(yaml);
  const auto& moved = ran.monitor("bar.x_max").mean_position;
  const std::size_t n = 40, last = ran.result.time.size() - 1;
  std::complex<double> sum = 0;
  for (std::size_t i = last - n + 1; i <= last; ++i)
    sum += (at(moved, i)[0] - 1) *
           std::polar(1.0, -2 * std::numbers::pi * frequency * ran.result.time[i]);
  return 2 * std::abs(sum) / n;
}

// The peak is at sqrt(1 - 2 zeta^2) omega, its half-power points at r^2 = 1 - 2 zeta^2 +- 2 zeta
// sqrt(1 - zeta^2).
TEST_F(OfHistories, HalfPowerWidthUnderASine) {
  const double width = 2 * zeta * std::sqrt(1 - zeta * zeta), peak = 1 / (stiffness * width);
  const auto amplitude = [&](double r2) {
    const double frequency = std::sqrt(r2) * omega / (2 * std::numbers::pi),
                 every = 1 / frequency / 40;
    const std::string load =
        "surface: x_max, traction: [1, 0, 0], history: {sine: {frequency_hz: " + text(frequency) +
        "}}";
    return steady_amplitude(folder, scene(load, 2400 * every, every), frequency);
  };
  const double r2 = 1 - 2 * zeta * zeta;
  EXPECT_NEAR(amplitude(r2), peak, 2e-4 * peak);
  EXPECT_NEAR(amplitude(r2 - width), peak / std::sqrt(2), 2e-4 * peak);
  EXPECT_NEAR(amplitude(r2 + width), peak / std::sqrt(2), 2e-4 * peak);
}

TEST_F(OfHistories, SineHasPhaseStartAndEnd) {
  folder.prepare(scene("surface: x_max, force: [1, 0, 0]"));
  const Ran ran =
      folder.prepare(scene("surface: x_max, force: [1, 0, 0], history: {sine: {frequency_hz: 5, "
                           "phase: 90, start: 0.1, cycles: 1.5}}"));
  const History& history = ran.scene.loads[0].history;
  EXPECT_EQ(history_value(history, 0.05), 0);
  EXPECT_EQ(history_value(history, 0.5), 0);
  for (const double t : {0.1, 0.17, 0.3, 0.4})
    EXPECT_NEAR(history_value(history, t), std::cos(2 * std::numbers::pi * 5 * (t - 0.1)), 1.3e-4)
        << t;
}

TEST_F(OfHistories, CsvIsTheTableThatItHolds) {
  write("pulse.csv", "time, value\n# a comment\n0, 0\n\n0.1; 1.5\r\n0.25 -1\n");
  const Ran csv = folder.run(scene("surface: x_max, force: [1, 0, 0], history: {file: pulse.csv}"));
  const Ran table = folder.run(scene(
      "surface: x_max, force: [1, 0, 0], history: {time: [0, 0.1, 0.25], value: [0, 1.5, -1]}"));
  EXPECT_EQ(csv.monitor("bar.x_max").mean_position.values,
            table.monitor("bar.x_max").mean_position.values);
}

// Into the face, however the instance is turned and mirrored.
TEST_F(OfHistories, PressurePushesAgainstTheOutwardNormal) {
  for (const char* as : {"superelement", "mesh"})
    for (const std::string placed :
         {"", ", rotation: [10, 20, 90]", ", mirror: x", ", mirror: y, rotation: [0, 35, 0]"}) {
      const Ran pressure = folder.run(scene("surface: x_max, pressure: 3", 1, 0.02, placed, as));
      const Matrix3 T = pressure.scene.instances[0].transformation();
      const Ran traction =
          folder.run(scene("surface: x_max, traction: " + text(Vector3(T * Vector3(-3, 0, 0))), 1,
                           0.02, placed, as));
      const auto &a = pressure.monitor("bar.x_max").mean_position.values,
                 &b = traction.monitor("bar.x_max").mean_position.values;
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-13);
      EXPECT_GT((at(pressure.monitor("bar.x_max").mean_position, 5) -
                 at(pressure.monitor("bar.x_max").mean_position, 0))
                    .norm(),
                1e-3);
    }
}

// A free body under gravity a sin(w t): the mean of its acceleration between outputs is a (cos(w
// t_1) - cos(w t_2)) / (w dt).
TEST_F(OfHistories, AccelerationsAreMeansBetweenOutputs) {
  const double w = 2 * std::numbers::pi * 3, every = 0.01;
  for (const std::string as : {"superelement", "mesh"}) {
    const Ran ran = folder.run(
        "materials:\n  soft: {youngs_modulus: 200, poissons_ratio: 0, density: 1}\ncomponents:\n  "
        "bar: {mesh: one.exo, material: "
        "soft, mass: lumped, reduction: {interface: [x_min, x_max], modes: 0}}\ninstances:\n  bar: "
        "{component: bar, as: " +
        as +
        "}\nloads:\n  - {gravity: [0, 0, 2], history: {sine: {frequency_hz: 3}}}\ntime: {end: 1, "
        "step: 0.0005}\noutput: {every: " +
        text(every) + ", history: [bar.x_max]}\n");
    const auto& found = ran.monitor("bar.x_max").mean_acceleration;
    ASSERT_EQ(found.values.size(), 3 * ran.result.time.size());
    EXPECT_EQ(at(found, 0), Vector3::Zero());
    for (std::size_t i = 1; i < ran.result.time.size(); ++i) {
      const double t = ran.result.time[i];
      const Vector3 expected(0, 0, 2 * (std::cos(w * (t - every)) - std::cos(w * t)) / (w * every));
      EXPECT_LT((at(found, i) - expected).norm(), 1e-3) << as << " " << t;
    }
  }
}

// What a filter hands on is the same scene.
TEST_F(OfHistories, ScenesAreWrittenAsTheyWereRead) {
  write("pulse.csv", "0 0\n0.1 1.5\n");
  const Ran ran =
      folder.prepare(scene("surface: x_max, pressure: 2.5, history: {file: pulse.csv}", 1, 0.02,
                           ", damping: {frequency_hz: [1, 2], ratio: [0.25, 0.5]}"));
  std::ostringstream text;
  write_scene(ran.scene, text);
  const std::string file = (folder.folder().path() / "again.yaml").string();
  std::ofstream(file) << text.str();
  const Scene again = read_scene(file);
  EXPECT_EQ(again.damping, ran.scene.damping);
  EXPECT_EQ(again.damping.at("soft").alpha, 2);
  EXPECT_EQ(again.instances[0].damping.ratio, (std::vector<double>{0.25, 0.5}));
  EXPECT_EQ(again.loads[0].kind, Load::Kind::pressure);
  EXPECT_EQ(again.loads[0].value[0], 2.5);
  EXPECT_EQ(again.loads[0].history.value, (std::vector<double>{0, 1.5}));
}

TEST_F(OfHistories, WhatCannotBeIsRefusedByName) {
  write("down.csv", "0, 0\n0, 1\n");
  write("words.csv", "time, value\n0, none\n");
  write("empty.csv", "# nothing\n");
  write("excel.csv", std::string("\xFF\xFE"
                                 "0\0,\0"
                                 "1\0",
                                 8));
  const auto names = [&](const std::string& load, const std::string& what) {
    EXPECT_SAYS(refusal(load), what);
  };
  names("surface: x_max, force: [1, 0, 0], history: {file: down.csv}", "down.csv:2: not above");
  names("surface: x_max, force: [1, 0, 0], history: {file: words.csv}",
        "words.csv:2: found '0, none'");
  names("surface: x_max, force: [1, 0, 0], history: {file: empty.csv}", "has no line");
  names("surface: x_max, force: [1, 0, 0], history: {file: none.csv}", "none.csv: no such file");
  names("surface: x_max, force: [1, 0, 0], history: {file: excel.csv}", "excel.csv: is UTF-16");
  names("surface: x_max, force: [1, 0, 0], history: {file: a.csv, time: [0]}", "stands alone");
  names("surface: x_max, force: [1, 0, 0], history: {sine: {frequency_hz: 1e6}}", "5000 cycles");
  names("surface: x_max, pressure: [1, 0, 0]", "expected a number");
  names("surface: x_max, pressure: 1, force: [1, 0, 0]", "pressure");
  folder.add("one.exo", test::block_mesh({{3, 3, 3}, {1, 1, 1}}));
  names("surface: z_max, pressure: 1", "add the sideset to reduction.interface");
}

}  // namespace
}  // namespace cbr::histories_test

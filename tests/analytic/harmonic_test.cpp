// SPDX-License-Identifier: GPL-3.0-or-later
// cbr-dyn --sweep against a dense solution of the whole mesh: (K + i w C - w^2 M) u = f.
#include "dynamics/setup/modal/harmonic.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <utility>

#include "common/files/hdf5_file.hpp"
#include "common/linalg/dense.hpp"
#include "common/mesh/face_weights.hpp"
#include "dynamics/output/results.hpp"
#include "dynamics/setup/modal/scene_modes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"
#include "tests/support/solve.hpp"

namespace cbr::test::harmonic_test {
namespace {

using Complex = std::complex<double>;

constexpr double alpha = 0.3, beta = 2e-4;
const std::string material =
    "materials: {soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1, damping: {alpha: "
    "0.3, beta: 2.0e-4}}}\n";
// The cantilever's first bending frequency is 0.23 Hz
const std::string sweep =
    "time: {end: 1}\nsweep: {from_hz: 0.05, to_hz: 6, points: 10, spacing: log}\n";

// A cantilever along x from 0 to 1, of hex8; mean displacement of its end over frequencies.
class Dense {
 public:
  Dense()
      : mesh_(block_mesh({{12, 2, 2}, {1, 0.1, 0.1}})),
        model_(assemble(mesh_, {{Material{200, 0.3, 1}}}, MassKind::lumped)) {}

  // Under a force on the end, or an acceleration of the base.
  Eigen::Vector3cd tip(double hz, const Vector3& force, const Vector3& base) const {
    const double w = 2 * std::numbers::pi * hz;
    const std::vector<Index> dofs =
        free_dofs(mesh_, model_, [](const Vector3& x, int) { return x[0] < 1e-9; });
    const Matrix K = submatrix(model_.K, dofs), M = submatrix(model_.M, dofs);
    const Index n = dofs.size();
    Vector f = Vector::Zero(n);
    const Surface end = extract_surface(mesh_, mesh_.sidesets[find_sideset(mesh_, "x_max")]);
    const Vector weight = face_weights(end, mesh_.coordinates);
    const std::vector<Index> nodes = surface_nodes(end);
    for (Index i = 0; i < n; ++i) {
      const Index dof = dofs[i];
      f[i] = weight[dof / 3] / weight.sum() * force[dof % 3] - M.row(i).sum() * base[dof % 3];
    }
    // Real and imaginary parts
    Matrix A(2 * n, 2 * n);
    A << K - w * w * M, -w * (alpha * M + beta * K), w * (alpha * M + beta * K), K - w * w * M;
    Vector b = Vector::Zero(2 * n);
    b.head(n) = f;
    const Vector u = Lu(std::move(A)).solve(b);
    Eigen::Vector3cd mean = -base.cast<Complex>() / (w * w);
    for (Index i = 0; i < n; ++i) {
      const Index dof = dofs[i];
      if (std::find(nodes.begin(), nodes.end(), dof / 3) != nodes.end())
        mean[dof % 3] += Complex(u[i], u[n + i]) / static_cast<double>(nodes.size());
    }
    return mean;
  }

 private:
  Mesh mesh_;
  FiniteElementModel model_;
};

class Harmonic : public testing::Test {
 protected:
  Harmonic() {
    folder_.add("beam.exo", block_mesh({{12, 2, 2}, {1, 0.1, 0.1}}));
    folder_.add("half.exo", block_mesh({{6, 2, 2}, {0.5, 0.1, 0.1}}));
  }
  HarmonicResponse respond(const std::string& yaml) const {
    Report report("test", Verbosity::quiet);
    return harmonic_response(folder_.prepare(yaml).scene, report);
  }
  // Largest error over the frequencies, of the response there.
  double error(const HarmonicResponse& response, const Vector3& force, const Vector3& base) const {
    const Dense dense;
    double worst = 0;
    for (Index i = 0; i < response.frequency_hz.size(); ++i) {
      const Eigen::Vector3cd expected = dense.tip(response.frequency_hz[i], force, base);
      worst =
          std::max(worst, (response.sets.at(0).displacement.row(i).transpose() - expected).norm() /
                              expected.norm());
    }
    return worst;
  }
  static std::string beam(const std::string& component, const std::string& rest) {
    return material + "components:\n  beam: {mesh: beam.exo, material: soft, mass: lumped" +
           component + "}\ninstances: {b: {component: beam, rotation: [0, 0, 90]}}\n" + rest +
           sweep + "output: {history: [b.x_max]}\n";
  }

  SceneFolder folder_;
};

// In the scene's axes the beam points along y.
const std::string push =
    "boundary: [{instance: b, nodes: x_min, fix: [x, y, z]}]\nloads: [{instance: b, surface: "
    "x_max, force: [-2, 1, 3]}, {gravity: "
    "[0, 0, -9.81]}]\n";
const Vector3 push_of_beam(1, 2, 3);
const std::string shake =
    "boundary: [{instance: b, nodes: x_min, fix: [x, y, z], acceleration: [0, 5, 2]}]\n";

Eigen::Matrix3d turned() { return (Matrix3() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished(); }

HarmonicResponse in_beam_axes(HarmonicResponse response) {
  for (auto& set : response.sets)
    set.displacement = (set.displacement * turned().cast<Complex>()).eval();
  return response;
}

TEST_F(Harmonic, IsThatOfADenseSolutionOfTheMesh) {
  struct Case {
    std::string component;
    double pushed, shaken;  // largest errors
  };
  // All modes there are; the mesh in its modes up to 12 Hz and six terms for the others
  for (const Case& c : {Case{", reduction: {interface: [x_min, x_max], modes: 297}", 2e-10, 2e-10},
                        Case{"", 6e-10, 3e-10}}) {
    const double pushed =
        error(in_beam_axes(respond(beam(c.component, push))), push_of_beam, Vector3::Zero());
    const double shaken =
        error(in_beam_axes(respond(beam(c.component, shake))), Vector3::Zero(), Vector3(5, 0, 2));
    std::printf("%-70s pushed %.2g, shaken %.2g\n", c.component.c_str(), pushed, shaken);
    EXPECT_LT(pushed, c.pushed) << c.component;
    EXPECT_LT(shaken, c.shaken) << c.component;
  }
}

// Two halves tied node by node are the whole: superelements and small meshes have all of their
// modes.
TEST_F(Harmonic, OfTiedHalvesIsThatOfTheWhole) {
  for (const auto& [a, b] : {std::pair("superelement", "superelement"), std::pair("mesh", "mesh"),
                             std::pair("superelement", "mesh")}) {
    const std::string yaml = material +
                             "components:\n  half: {mesh: half.exo, material: soft, mass: lumped, "
                             "reduction: {interface: [x_min, x_max], modes: 135}}\n"
                             "instances:\n  a: {component: half, as: " +
                             a + "}\n  b: {component: half, as: " + b +
                             ", position: [0.5, 0, 0]}\n"
                             "contact: [{between: [a.x_max, b.x_min], tied: true}]\nboundary: "
                             "[{instance: a, nodes: x_min, fix: [x, y, z]}]\n"
                             "loads: [{instance: b, surface: x_max, force: [1, 2, 3]}]\n" +
                             sweep + "output: {history: [b.x_max]}\n";
    const double found = error(respond(yaml), push_of_beam, Vector3::Zero());
    std::printf("tied %s and %s: %.2g\n", a, b, found);
    EXPECT_LT(found, 8e-11) << a << " " << b;
  }
}

// Clamped halves, pressed together by their interference and damped by stiffness alone: every mode
// has the ratio omega beta / 2, and motion far below all resonances is that of statics over 1 + i w
// beta.
TEST_F(Harmonic, StiffnessDampsResidualCompliance) {
  const double slow_hz = 1e-5, slow = 1 / (2 * std::numbers::pi * slow_hz);
  Report report("test", Verbosity::quiet);
  for (const std::string basis :
       {"craig-bampton", "massless", "massless, massless_modes: tapered", "characteristic"}) {
    const auto scene = [&](double delay) {
      return "materials: {soft: {youngs_modulus: 200, poissons_ratio: 0.3, density: 1, damping: "
             "{beta: " +
             text(delay) +
             "}}}\ncomponents: {half: {mesh: half.exo, material: soft, reduction: {modes: 13, "
             "interface: [x_min, x_max], basis: " +
             basis +
             "}}}\ninstances:\n  a: {component: half, as: superelement}\n  b: {component: half, "
             "as: "
             "superelement, position: [1, 0.1, 0], rotation: [0, 0, 180]}\n"
             "contact: [{between: [a.x_max, b.x_max], friction: 0.3, interference: 1.0e-3}]\n"
             "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}, {instance: b, nodes: x_min, "
             "fix: [x, y, z]}]\nloads: [{instance: a, surface: x_max, force: [1, 2, 3], history: "
             "{time: [0, 1], value: [0, 1]}}]\noutput: {history: [b.x_max]}\n"
             "time: {end: 1.0e-9}\nsweep: {from_hz: 1.0e-5, to_hz: 2.0e-5, points: 2}\n";
    };
    const auto tip = [&](double delay) {
      return Eigen::RowVector3cd(respond(scene(delay)).sets.at(0).displacement.row(0));
    };
    const double creep = (tip(slow) * Complex(1, 1) - tip(0)).norm() / tip(0).norm();
    const InstanceModes modes =
        scene_modes(folder_.prepare(scene(beta)).scene, 20, report).instances.at(0);
    const Vector ratio = std::numbers::pi * beta * modes.frequency_hz;
    const double damped = (modes.damping_ratio.array() / ratio.array() - 1).abs().maxCoeff();
    std::printf("%s: %td modes %.1e, sweep %.1e\n", basis.c_str(), ratio.size(), damped, creep);
    EXPECT_LT(damped, 1e-14) << basis;
    EXPECT_LT(creep, 3e-10) << basis;
  }
}

// Two halves that the preload presses together are the whole. A constant load presses and excites,
// gravity presses alone, and a load whose history begins with 0 excites alone.
TEST_F(Harmonic, OfPressedHalvesIsThatOfTheWhole) {
  struct Case {
    std::string loads;
    Vector3 force;
  };
  const std::string on_end = "{instance: b, surface: x_max, force: ";
  for (const Case& c : {Case{on_end + "[-1.0e-3, 0, 0]}", Vector3(-1e-3, 0, 0)},
                        Case{"{gravity: [-1, 0, 0]}, " + on_end +
                                 "[1, 2, 3], history: {time: [0, 1], value: [0, 1]}}",
                             push_of_beam}})
    for (const std::string as : {"superelement", "mesh"}) {
      std::string yaml =
          material +
          "components:\n  half: {mesh: half.exo, material: soft, mass: lumped, reduction: "
          "{interface: [x_min, x_max], modes: 135}}\ninstances:\n  a: {component: half, as: " +
          as + "}\n  b: {component: half, as: " + as +
          ", position: [0.5, 0, 0]}\n"
          "contact: [{between: [a.x_max, b.x_min], friction: 0.3}]\n"
          "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\nloads: [" +
          c.loads + "]\n" + sweep + "output: {history: [b.x_max]}\n";
      yaml.replace(yaml.find("end: 1}"), 7, "end: 1, preload: 1}");
      const double found = error(respond(yaml), c.force, Vector3::Zero());
      std::printf("pressed, %s: %.2g\n", as.c_str(), found);
      EXPECT_LT(found, 1e-9) << as << c.loads;
    }
}

// Larger meshes in some modes and a series: the half that is tied is free by itself. Against the
// whole in its modes and its series.
TEST_F(Harmonic, OfTiedLargeMeshesIsThatOfTheWhole) {
  folder_.add("fine.exo", block_mesh({{10, 6, 6}, {0.5, 0.1, 0.1}}));
  folder_.add("whole.exo", block_mesh({{20, 6, 6}, {1, 0.1, 0.1}}));
  const auto scene = [&](const std::string& mesh, const std::string& more,
                         const std::string& loaded) {
    return material + "components:\n  part: {mesh: " + mesh +
           ", material: soft, mass: lumped}\ninstances:\n  a: {component: part, as: mesh}\n" +
           more +
           "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\nloads: [{instance: " + loaded +
           ", surface: x_max, force: [1, 2, 3]}]\n" +
           "time: {end: 1}\nsweep: {from_hz: 0.05, to_hz: 6, points: 10, spacing: log, modes: "
           "60}\noutput: {history: [" +
           loaded + ".x_max]}\n";
  };
  const HarmonicResponse whole = respond(scene("whole.exo", "", "a")),
                         tied = respond(
                             scene("fine.exo",
                                   "  b: {component: part, as: mesh, position: [0.5, 0, 0]}\n"
                                   "contact: [{between: [a.x_max, b.x_min], tied: true}]\n",
                                   "b"));
  double worst = 0;
  for (Index i = 0; i < whole.frequency_hz.size(); ++i)
    worst = std::max(worst,
                     (whole.sets[0].displacement.row(i) - tied.sets[0].displacement.row(i)).norm() /
                         whole.sets[0].displacement.row(i).norm());
  std::printf("tied large meshes: %.2g\n", worst);
  EXPECT_LT(worst, 8e-8);
}

TEST_F(Harmonic, FilesHaveWhatWasComputed) {
  const HarmonicResponse response =
      respond(beam(", reduction: {interface: [x_min, x_max], modes: 20}", push));
  write_sweep(folder_.folder() / "sweep.h5", response);
  const Hdf5Reader file(folder_.folder() / "sweep.h5");
  EXPECT_EQ(file.read_string("/", "format"), "cbr-sweep");
  EXPECT_EQ(file.read_vector("/frequency_hz"), response.frequency_hz);
  EXPECT_EQ(file.read_points("/surfaces/b.x_max/displacement_imag"),
            Points(response.sets[0].displacement.imag()));
  std::ifstream table(folder_.folder() / "sweep.csv");
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "surface,frequency_hz,x_real,x_imag,y_real,y_imag,z_real,z_imag");
  int rows = 0;
  while (std::getline(table, line)) rows += line.rfind("b.x_max,", 0) == 0;
  EXPECT_EQ(rows, 10);
}

TEST_F(Harmonic, WhatCannotBeIsRefused) {
  const std::string reduction = ", reduction: {interface: [x_min, x_max], modes: 20}";
  const auto expect = [&](const std::string& yaml, const std::string& words) {
    const std::string message = refusal_of([&] { respond(yaml); });
    EXPECT_SAYS(message, words);
  };
  expect(beam(reduction,
              "boundary: [{instance: b, nodes: x_min, fix: [x, y, z]}]\nloads: [{gravity: [0, 0, "
              "-9.81]}]\n"),
         "nothing excites");
  expect(beam(reduction, push + "walls: {w: {plane: {point: [0, 0, -1], normal: [0, 0, "
                                "1]}}}\ncontact: [{between: [b.x_max, w]}]\n"),
         "contact that is not tied does not go with --sweep");
  std::string none = beam(reduction, push);
  none.replace(none.find("sweep:"), sweep.size() - sweep.find("sweep:"), "");
  expect(none, "needs sweep: {from_hz");
  std::string nowhere = beam(reduction, push);
  nowhere.replace(nowhere.find("output:"), std::string::npos, "");
  expect(nowhere, "needs output.history");
}

}  // namespace
}  // namespace cbr::test::harmonic_test

// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <thread>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/superelement/superelement.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/formats/temporary_folder.hpp"
#include "tests/support/refusal.hpp"

namespace cbr::superelement_file_test {
namespace {

using test::sample_superelement;
using test::TemporaryFolder;

TEST(SuperelementFile, readsBackWhatWasWritten) {
  const TemporaryFolder folder;
  for (const bool optional_parts : {true, false}) {
    Superelement written = sample_superelement();
    if (!optional_parts) {
      written.omega.resize(0);
      written.V.resize(0, 0);
      written.recovery.clear();
      written.nodesets.clear();
    }
    write_superelement(written, folder / "s.h5");
    EXPECT_TRUE(test::identical(read_superelement(folder / "s.h5"), written)) << optional_parts;
    EXPECT_EQ(read_content_hash(folder / "s.h5"), written.content_hash);
    EXPECT_EQ(folder.n_entries(), 1u);
  }
}

TEST(SuperelementFile, facesOfNineNodesAreKept) {
  Superelement s = sample_superelement();
  Surface& surface = s.surfaces[0];
  surface.kind = FaceKind::quad9;
  surface.faces.resize(1, 9);
  surface.faces << 0, 1, 2, 3, 0, 1, 2, 3, 2;
  const TemporaryFolder folder;
  write_superelement(s, folder / "nine.cbr.h5");
  const Superelement read = read_superelement(folder / "nine.cbr.h5");
  EXPECT_TRUE(test::identical(read, s));
}

TEST(SuperelementFile, partsThatAreNotAskedForAreNotRead) {
  const TemporaryFolder folder;
  const Superelement written = sample_superelement();
  write_superelement(written, folder / "s.h5");
  const auto nothing =
      read_superelement(folder / "s.h5", {.matrices = false, .diagonal = false, .recovery = false});
  EXPECT_EQ(nothing.K_cc.size() + nothing.M_cc.size() + nothing.M_kc.size() + nothing.V.size(), 0);
  EXPECT_TRUE(nothing.recovery.empty());
  EXPECT_EQ(nothing.k(), 4);
  EXPECT_EQ(nothing.c(), 12);
  const auto diagonal =
      read_superelement(folder / "s.h5", {.matrices = false, .diagonal = true, .recovery = false});
  EXPECT_EQ(diagonal.V, written.V);
}

Superelement massless_sample() {
  Superelement s = sample_superelement();
  s.basis = "massless";
  s.massless.F = s.M_cc;
  s.massless.V = s.M_kc.transpose();
  s.massless.omega_closed = 100;
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
  s.omega.resize(0);
  s.V.resize(0, 0);
  s.recovery.clear();
  return s;
}

TEST(SuperelementFile, basisMasslessHasMatricesOfItsOwn) {
  const TemporaryFolder folder;
  const Superelement written = massless_sample();
  write_superelement(written, folder / "s.h5");
  EXPECT_EQ(Hdf5Reader(folder / "s.h5").read_string("/", "format_version"), "1.16");
  EXPECT_FALSE(Hdf5Reader(folder / "s.h5").has("/matrices/K_cc"));
  const Superelement read = read_superelement(folder / "s.h5");
  EXPECT_TRUE(test::identical(read, written));
  EXPECT_EQ(read.massless.F, written.massless.F);
  EXPECT_EQ(read.massless.V, written.massless.V);
  EXPECT_EQ(read.massless.omega_closed, written.massless.omega_closed);
  EXPECT_EQ(read_superelement(folder / "s.h5", {false, false, false}).massless.F.size(), 0);
}

TEST(SuperelementFile, SpinCouplingsComeBackAsTheyWere) {
  const TemporaryFolder folder;
  Superelement written = sample_superelement();
  write_superelement(written, folder / "without.h5");
  EXPECT_FALSE(Hdf5Reader(folder / "without.h5").has("/spin_couplings"));
  EXPECT_EQ(read_superelement(folder / "without.h5").spin_couplings.size(), 0);
  const Matrix A = written.K_cc.topLeftCorner(9, 9);
  written.spin_couplings = A * A;
  write_superelement(written, folder / "with.h5");
  const Superelement read = read_superelement(folder / "with.h5");
  EXPECT_EQ(read.spin_couplings, written.spin_couplings);
  EXPECT_TRUE(test::identical(read, written));
}

// Files before 1.5 say which modes they are in /provenance, or not at all.
TEST(SuperelementFile, basisMasslessTellsItsModes) {
  const TemporaryFolder folder;
  const auto again = [&](const Superelement& s) {
    write_superelement(s, folder / "s.h5");
    return read_superelement(folder / "s.h5").massless;
  };
  Superelement s = massless_sample();
  EXPECT_EQ(again(s).modes, "");
  EXPECT_FALSE(Hdf5Reader(folder / "s.h5").has("/massless/omega_fall"));
  s.provenance["massless_modes"] = "tapered";
  EXPECT_EQ(again(s).modes, "tapered");
  s.massless.modes = "free";
  EXPECT_EQ(again(s).modes, "free");
  s.massless.modes = "tapered";
  s.massless.omega_fall = 40.5;
  EXPECT_EQ(again(s).omega_fall, 40.5);
  s.massless.modes = "fixed";  // of older files
  s.massless.omega_fall = 0;
  EXPECT_EQ(again(s).modes, "fixed");
}

Superelement sample_with_extras() {
  Superelement s = sample_superelement();
  Superelement::Accuracy a;
  a.rho_res = Vector3(0.1, 0.2, 0.3);
  a.rho_floor = Vector3(0.01, 0.02, 0.03);
  a.strain_left_out << 1, 2, 3, 4, 5, 6;
  a.largest_left_out = 7;
  a.covered_hz = 8;
  a.complete_hz = 9;
  a.tolerance = 0.5;
  a.surfaces["contact"] = {0.25, 0.125};
  a.frequency_hz = Vector3(1, 2, 3);
  a.eigenvalue_error = Vector3(0.1, 0.2, 0.4);
  a.worst_of_ten = 0.75;
  a.interface_share = Vector3(1, 0.5, 0.25);
  s.accuracy = a;
  s.loads["inside"] = {2.5, Matrix(s.V.leftCols(3))};
  s.n_residual = 2;
  return s;
}

TEST(SuperelementFile, accuracyAndLoadsAreKept) {
  const TemporaryFolder folder;
  const Superelement written = sample_with_extras();
  write_superelement(written, folder / "s.h5");
  const Superelement read = read_superelement(folder / "s.h5");
  EXPECT_TRUE(test::identical(read, written));
  ASSERT_TRUE(read.accuracy);
  const Superelement::Accuracy &a = *read.accuracy, &b = *written.accuracy;
  EXPECT_EQ(a.rho_res, b.rho_res);
  EXPECT_EQ(a.rho_floor, b.rho_floor);
  EXPECT_EQ(a.strain_left_out, b.strain_left_out);
  EXPECT_EQ(a.frequency_hz, b.frequency_hz);
  EXPECT_EQ(a.eigenvalue_error, b.eigenvalue_error);
  EXPECT_EQ(a.worst_of_ten, b.worst_of_ten);
  EXPECT_EQ(a.interface_share, b.interface_share);
  EXPECT_EQ(std::vector<double>({a.largest_left_out, a.covered_hz, a.complete_hz, a.tolerance}),
            std::vector<double>({7, 8, 9, 0.5}));
  ASSERT_EQ(a.surfaces.size(), 1U);
  EXPECT_EQ(a.surfaces.at("contact").impact, 0.25);
  EXPECT_EQ(a.surfaces.at("contact").strain_left_out, 0.125);
  ASSERT_EQ(read.loads.size(), 1U);
  EXPECT_EQ(read.loads.at("inside").weight, 2.5);
  EXPECT_EQ(read.loads.at("inside").force, written.loads.at("inside").force);
  EXPECT_EQ(read.n_residual, 2);
}

TEST(SuperelementFile, accuracyAndLoadsAreChecked) {
  const auto expect = [&](const std::string& field, auto&& damage) {
    Superelement s = sample_with_extras();
    damage(s);
    EXPECT_SAYS(test::refusal_of([&] { check(s, "s.h5"); }), "s.h5: " + field);
  };
  expect("attribute 'n_residual'", [](Superelement& s) { s.n_residual = s.k() + 1; });
  expect("/loads/inside/force",
         [](Superelement& s) { s.loads["inside"].force.conservativeResize(5, 3); });
  expect("/loads/inside/force", [](Superelement& s) { s.loads["inside"].force(2, 1) = NAN; });
  expect("/loads/inside/weight", [](Superelement& s) { s.loads["inside"].weight = 0; });
  expect("/accuracy/rho_res", [](Superelement& s) { s.accuracy->rho_res(1) = NAN; });
  expect("/accuracy/strain_left_out",
         [](Superelement& s) { s.accuracy->strain_left_out.resize(4); });
  expect("/accuracy/eigenvalue_error",
         [](Superelement& s) { s.accuracy->eigenvalue_error.resize(2); });
  expect("/accuracy/interface_share",
         [](Superelement& s) { s.accuracy->interface_share.resize(2); });
  expect("/accuracy/worst_of_ten", [](Superelement& s) { s.accuracy->worst_of_ten = NAN; });
  expect("/accuracy", [](Superelement& s) { s.accuracy->covered_hz = INFINITY; });
  expect("/accuracy/surfaces/contact",
         [](Superelement& s) { s.accuracy->surfaces["contact"].impact = NAN; });
}

TEST(SuperelementFile, basisMasslessIsChecked) {
  const auto refusal = [](auto&& damage) {
    Superelement s = massless_sample();
    damage(s);
    return test::refusal_of([&] { check(s, "s.h5"); });
  };
  const auto expect = [&](const std::string& field, auto&& damage) {
    EXPECT_SAYS(refusal(damage), "s.h5: " + field) << field;
  };
  EXPECT_EQ(refusal([](Superelement&) {}), "no error");
  expect("/massless/V", [](Superelement& s) { s.massless.V.conservativeResize(11, 4); });
  expect("/massless/V", [](Superelement& s) { s.massless.V(3, 2) = NAN; });
  expect("/massless/F", [](Superelement& s) { s.massless.F.conservativeResize(11, 11); });
  expect("/massless/F", [](Superelement& s) { s.massless.F(3, 2) *= 1.1; });
  expect("/massless/F", [](Superelement& s) {
    s.massless.F.row(5).setZero();
    s.massless.F.col(5).setZero();
  });
  expect("/massless/omega_closed", [](Superelement& s) { s.massless.omega_closed = 31; });
  expect("/massless/omega_closed", [](Superelement& s) { s.massless.omega_closed = INFINITY; });
  expect("/massless/omega_fall", [](Superelement& s) { s.massless.omega_fall = 31; });
  expect("/massless/omega_fall", [](Superelement& s) { s.massless.omega_fall = INFINITY; });
  expect("/matrices/eigenvalues",
         [](Superelement& s) { std::swap(s.eigenvalues(0), s.eigenvalues(3)); });
  expect("/diagonal", [](Superelement& s) {
    s.omega = Vector::Ones(16);
    s.V = RowMatrix::Identity(16, 16);
  });
  expect("attribute 'n_modes'", [](Superelement& s) {
    s.eigenvalues.resize(0);
    s.massless.V.resize(12, 0);
  });
}

Superelement characteristic_sample() {
  Superelement s = sample_superelement();
  s.basis = "characteristic";
  s.characteristic.V = s.M_kc.transpose();
  StaticShare& statics = s.characteristic.statics;
  statics.node = {0, 0, 0, 2};
  statics.direction.resize(4, 3);
  statics.direction << 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.6, -0.8;
  statics.F = s.M_cc.topLeftCorner(4, 4);
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
  s.omega.resize(0);
  s.V.resize(0, 0);
  return s;
}

TEST(SuperelementFile, basisCharacteristicHasTheInterfaceInItsCoordinates) {
  const TemporaryFolder folder;
  const Superelement written = characteristic_sample();
  write_superelement(written, folder / "s.h5");
  EXPECT_FALSE(Hdf5Reader(folder / "s.h5").has("/matrices/K_cc"));
  const Superelement read = read_superelement(folder / "s.h5");
  EXPECT_TRUE(test::identical(read, written));
  EXPECT_EQ(read.characteristic.V, written.characteristic.V);
  EXPECT_EQ(read.characteristic.statics.node, written.characteristic.statics.node);
  EXPECT_EQ(read.characteristic.statics.direction, written.characteristic.statics.direction);
  EXPECT_EQ(read.characteristic.statics.F, written.characteristic.statics.F);
  EXPECT_EQ(read.n_coordinates(), read.k());
  EXPECT_EQ(read_superelement(folder / "s.h5", {false, false, false}).characteristic.V.size(), 0);
}

TEST(SuperelementFile, ComplianceInLevelsComesBackAndIsChecked) {
  const TemporaryFolder folder;
  Superelement written = characteristic_sample();
  StaticShare& statics = written.characteristic.statics;
  const SparseMatrix P = Matrix{{0.5, 0, 1, -0.25}, {0.5, 1, 0, 1.25}}.sparseView(),
                     S = Matrix{{2, -1}, {-1, 3}}.sparseView(),
                     near = Matrix(statics.F.diagonal().asDiagonal()).sparseView();
  statics.levels = {{P, S}, {Matrix::Identity(4, 4).sparseView(), near}};
  statics.F.resize(0, 0);
  write_superelement(written, folder / "s.h5");
  const Superelement read = read_superelement(folder / "s.h5");
  EXPECT_TRUE(test::identical(read, written));
  const Matrix one = Matrix::Identity(4, 4);
  EXPECT_EQ(compliance_product(read.characteristic.statics.levels, one),
            compliance_product(statics.levels, one));
  const auto refused = [&](const std::string& dataset, const auto& damage) {
    Superelement damaged = written;
    damage(damaged.characteristic.statics.levels);
    const std::string message = test::refusal_of([&] {
      write_superelement(damaged, folder / "damaged.h5");
      read_superelement(folder / "damaged.h5");
    });
    EXPECT_SAYS(message, "/characteristic/statics/levels/" + dataset);
  };
  refused("0/P", [](auto& levels) { levels[0].P = Matrix::Ones(3, 4).sparseView(); });
  refused("1/P", [](auto& levels) { levels[1].P = Matrix::Ones(4, 3).sparseView(); });
  refused("0/S", [](auto& levels) { levels[0].S.coeffRef(0, 0) = NAN; });
}

TEST(SuperelementFile, FixedDofsComeBackAndAreChecked) {
  const TemporaryFolder folder;
  for (Superelement s : {sample_superelement(), characteristic_sample()}) {
    s.fixed.resisted = Matrix::Identity(2, 6);
    s.fixed.momentum = Matrix::Random(s.is_characteristic() ? s.k() : s.n(), 6);
    write_superelement(s, folder / "s.h5");
    EXPECT_TRUE(test::identical(read_superelement(folder / "s.h5"), s));
    const auto expect = [&](const std::string& field, auto&& damage) {
      Superelement damaged = s;
      damage(damaged.fixed);
      EXPECT_SAYS(test::refusal_of([&] { check(damaged, "s.h5"); }), "s.h5: /fixed/" + field);
    };
    expect("resisted", [](auto& fixed) { fixed.resisted(0, 0) = 1.1; });
    expect("resisted", [](auto& fixed) { fixed.resisted = Matrix::Identity(2, 5); });
    expect("momentum", [](auto& fixed) { fixed.momentum(1, 1) = NAN; });
    expect("momentum", [](auto& fixed) { fixed.momentum.conservativeResize(3, 6); });
  }
}

TEST(SuperelementFile, basisCharacteristicIsChecked) {
  const auto expect = [&](const std::string& field, auto&& damage) {
    Superelement s = characteristic_sample();
    damage(s);
    EXPECT_SAYS(test::refusal_of([&] { check(s, "s.h5"); }), "s.h5: " + field) << field;
  };
  check(characteristic_sample(), "s.h5");
  expect("/characteristic/V",
         [](Superelement& s) { s.characteristic.V.conservativeResize(11, 4); });
  expect("/characteristic/V", [](Superelement& s) { s.characteristic.V(3, 2) = NAN; });
  const auto expect_statics = [&](const std::string& field, auto&& damage) {
    expect("/characteristic/statics/" + field,
           [&](Superelement& s) { damage(s.characteristic.statics); });
  };
  expect_statics("node", [](StaticShare& statics) { statics.node[3] = 100; });
  expect_statics("direction", [](StaticShare& statics) { statics.direction(3, 1) = 0.61; });
  expect_statics("direction", [](StaticShare& statics) { statics.direction(3, 1) = NAN; });
  expect_statics("direction",
                 [](StaticShare& statics) { statics.direction.conservativeResize(3, 3); });
  expect_statics("F", [](StaticShare& statics) { statics.F.conservativeResize(4, 3); });
  expect_statics("F", [](StaticShare& statics) { statics.F(1, 2) += 0.1 * statics.F.maxCoeff(); });
  expect_statics("F", [](StaticShare& statics) { statics.F(1, 1) = -1e-20; });
  expect("/matrices/eigenvalues",
         [](Superelement& s) { std::swap(s.eigenvalues(0), s.eigenvalues(3)); });
  expect("/diagonal", [](Superelement& s) {
    s.omega = Vector::Ones(16);
    s.V = RowMatrix::Identity(16, 16);
  });
  expect("attribute 'n_modes'", [](Superelement& s) {
    s.eigenvalues.resize(0);
    s.characteristic.V.resize(12, 0);
    for (auto& recovery : s.recovery) recovery.Phi.resize(recovery.Phi.rows(), 0);
  });
}

TEST(SuperelementFile, noModesAndNoInterfaceAreRead) {
  const TemporaryFolder folder;
  Superelement s = sample_superelement();
  s.omega.resize(0);
  s.V.resize(0, 0);
  s.recovery.clear();
  Superelement no_modes = s;
  no_modes.eigenvalues.resize(0);
  no_modes.M_kc.resize(0, 12);
  write_superelement(no_modes, folder / "k0.h5");
  EXPECT_TRUE(test::identical(read_superelement(folder / "k0.h5"), no_modes));
  Superelement no_interface = s;
  no_interface.dof_node.clear();
  no_interface.dof_component.clear();
  no_interface.node_ids.clear();
  no_interface.coordinates.resize(0, 3);
  no_interface.surfaces.clear();
  no_interface.nodesets.clear();
  no_interface.K_cc.resize(0, 0);
  no_interface.M_cc.resize(0, 0);
  no_interface.M_kc.resize(4, 0);
  write_superelement(no_interface, folder / "c0.h5");
  EXPECT_TRUE(test::identical(read_superelement(folder / "c0.h5"), no_interface));
}

TEST(SuperelementFile, sameContentsSameBytesWheneverAndWhereverWritten) {
  const TemporaryFolder folder;
  const Superelement s = sample_superelement();
  write_superelement(s, folder / "a.h5");
  // time stamps of HDF5 count seconds
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  std::thread([&] { write_superelement(s, folder / "a longer name.h5"); }).join();
  Superelement reordered = s;
  std::reverse(reordered.surfaces.begin(), reordered.surfaces.end());
  write_superelement(reordered, folder / "c.h5");
  EXPECT_EQ(test::bytes_of(folder / "a.h5"), test::bytes_of(folder / "a longer name.h5"));
  EXPECT_EQ(test::bytes_of(folder / "a.h5"), test::bytes_of(folder / "c.h5"));
}

TEST(ReducedMatrices, areThoseOfTheDiagonalForm) {
  const Superelement s = sample_superelement();
  const Matrix K = reduced_stiffness(s), M = reduced_mass(s);
  EXPECT_LT((s.V.transpose() * M * s.V - Matrix::Identity(16, 16)).norm(), 1e-11);
  EXPECT_LT((s.V.transpose() * K * s.V - Matrix(s.omega.cwiseAbs2().asDiagonal())).norm(),
            1e-11 * K.norm());
}

TEST(ReducedRigidModes, areTheMotionsOfTheInterfacesPoints) {
  const Superelement s = sample_superelement();
  const Vector3 center(0.2, -0.3, 0.4), shift(1, 2, 3), turn(-0.5, 0.25, 2);
  Vector motion(6);
  motion << shift, turn;
  const Vector u = reduced_rigid_modes(s, center) * motion;
  EXPECT_EQ(u.head(s.k()).norm(), 0);
  for (Index node = 0; node < 4; ++node) {
    const Vector3 expected =
        shift + turn.cross(Vector3(s.coordinates.row(node).transpose()) - center);
    EXPECT_LT((u.segment<3>(s.k() + 3 * node) - expected).norm(), 1e-14);
  }
}

TEST(ResidualMassShare, isTheMassThatNoModeMoves) {
  const Superelement s = sample_superelement();
  const Matrix M_res = s.M_cc - s.M_kc.transpose() * s.M_kc;
  const Vector3 share = residual_mass_share(s);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector r = reduced_rigid_modes(s, Vector3::Zero()).col(axis).tail(12);
    EXPECT_NEAR(share(axis), r.dot(M_res * r) / r.dot(s.M_cc * r), 1e-13);
  }
}

}  // namespace
}  // namespace cbr::superelement_file_test

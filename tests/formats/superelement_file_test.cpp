// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <thread>

#include "common/superelement.hpp"
#include "tests/formats/sample_superelement.hpp"
#include "tests/formats/temporary_folder.hpp"

namespace cbr {
namespace {

using test::sample_superelement;
using test::TemporaryFolder;

TEST(SuperelementFile, readsBackWhatWasWritten) {
  const TemporaryFolder folder;
  for (const bool optional_parts : {true, false}) {
    Superelement written = sample_superelement();
    if (!optional_parts) written.omega.resize(0), written.V.resize(0, 0), written.recovery.clear(), written.nodesets.clear();
    write_superelement(written, folder / "s.h5");
    EXPECT_TRUE(test::identical(read_superelement(folder / "s.h5"), written)) << optional_parts;
    EXPECT_EQ(read_content_hash(folder / "s.h5"), written.content_hash);
    EXPECT_EQ(folder.n_entries(), 1u);
  }
}

TEST(SuperelementFile, partsThatAreNotAskedForAreNotRead) {
  const TemporaryFolder folder;
  const Superelement written = sample_superelement();
  write_superelement(written, folder / "s.h5");
  const auto nothing = read_superelement(folder / "s.h5", {.matrices = false, .diagonal = false, .recovery = false});
  EXPECT_EQ(nothing.K_cc.size() + nothing.M_cc.size() + nothing.M_kc.size() + nothing.V.size(), 0);
  EXPECT_TRUE(nothing.recovery.empty());
  EXPECT_EQ(nothing.k(), 4);
  EXPECT_EQ(nothing.c(), 12);
  const auto diagonal = read_superelement(folder / "s.h5", {.matrices = false, .diagonal = true, .recovery = false});
  EXPECT_EQ(diagonal.V, written.V);
}

TEST(SuperelementFile, noModesAndNoInterfaceAreRead) {
  const TemporaryFolder folder;
  Superelement s = sample_superelement();
  s.omega.resize(0), s.V.resize(0, 0), s.recovery.clear();
  Superelement no_modes = s;
  no_modes.eigenvalues.resize(0), no_modes.M_kc.resize(0, 12);
  write_superelement(no_modes, folder / "k0.h5");
  EXPECT_TRUE(test::identical(read_superelement(folder / "k0.h5"), no_modes));
  Superelement no_interface = s;
  no_interface.dof_node.clear(), no_interface.dof_component.clear(), no_interface.node_ids.clear();
  no_interface.coordinates.resize(0, 3), no_interface.surfaces.clear(), no_interface.nodesets.clear();
  no_interface.K_cc.resize(0, 0), no_interface.M_cc.resize(0, 0), no_interface.M_kc.resize(4, 0);
  write_superelement(no_interface, folder / "c0.h5");
  EXPECT_TRUE(test::identical(read_superelement(folder / "c0.h5"), no_interface));
}

TEST(SuperelementFile, sameContentsSameBytesWheneverAndWhereverWritten) {
  const TemporaryFolder folder;
  const Superelement s = sample_superelement();
  write_superelement(s, folder / "a.h5");
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // time stamps of HDF5 count seconds
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
  EXPECT_LT((s.V.transpose() * K * s.V - Matrix(s.omega.cwiseAbs2().asDiagonal())).norm(), 1e-11 * K.norm());
}

TEST(ReducedRigidModes, areTheMotionsOfTheInterfacesPoints) {
  const Superelement s = sample_superelement();
  const Vector3 center(0.2, -0.3, 0.4), shift(1, 2, 3), turn(-0.5, 0.25, 2);
  Vector motion(6);
  motion << shift, turn;
  const Vector u = reduced_rigid_modes(s, center) * motion;
  EXPECT_EQ(u.head(s.k()).norm(), 0);
  for (Index node = 0; node < 4; ++node) {
    const Vector3 expected = shift + turn.cross(Vector3(s.coordinates.row(node).transpose()) - center);
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
}  // namespace cbr

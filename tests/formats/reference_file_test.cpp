// SPDX-License-Identifier: GPL-3.0-or-later
// Files of every format version that was ever written are read for ever.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "common/superelement/superelement.hpp"

namespace cbr::reference_file_test {
namespace {

// A box of 3 x 1 x 2 m in 3 x 1 x 2 hexes, steel of 7800 kg/m^3, its face at x = 3 kept, 6 modes:
// make_reference.cpp.
class ReferenceFile : public testing::TestWithParam<const char*> {
 protected:
  const Superelement s =
      read_superelement(std::string(CBR_SOURCE_DIR "/tests/formats/data/") + GetParam());
  static constexpr double mass = 3 * 1 * 2 * 7800.0;
};

TEST_P(ReferenceFile, isWhatItWasMadeFrom) {
  EXPECT_EQ(s.basis, "craig-bampton");
  EXPECT_EQ(s.content_hash, "00000000000000000000000000000001");
  EXPECT_EQ(s.provenance.at("mesh"), "box 3 x 1 x 2");
  EXPECT_EQ(s.k(), 6);
  EXPECT_EQ(s.c(), 18);
  EXPECT_EQ(s.node_ids.size(), 6u);
  EXPECT_EQ(s.coordinates.col(0), Vector::Constant(6, 3.0));
  EXPECT_NEAR(s.rigid_body.mass, mass, 1e-9 * mass);
  EXPECT_LT((s.rigid_body.center - Vector3(1.5, 0.5, 1)).norm(), 1e-12);
}

TEST_P(ReferenceFile, rigidMotionsAreFreeOfForceAndCarryTheMass) {
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center), K = reduced_stiffness(s),
               M = reduced_mass(s);
  EXPECT_LT((K * R).cwiseAbs().maxCoeff(), 1e-10 * K.cwiseAbs().maxCoeff());
  // diag(m, m, m) and the inertia about the centre   (6 x 6)
  const Matrix rigid_mass = R.transpose() * M * R;
  Matrix expected = Matrix::Zero(6, 6);
  expected.topLeftCorner(3, 3).diagonal().setConstant(mass);
  expected.bottomRightCorner(3, 3) = s.rigid_body.inertia;
  EXPECT_LT((rigid_mass - expected).norm(), 1e-10 * expected.norm());
}

TEST_P(ReferenceFile, modesAreThoseKnown) {
  ASSERT_TRUE(s.has_diagonal_form());
  EXPECT_EQ(s.omega.head(6).norm(), 0);
  EXPECT_GT(s.omega(6), 0);
  EXPECT_TRUE(std::is_sorted(s.eigenvalues.begin(), s.eigenvalues.end()));
  // Of the day the file was made (version 0.1.0): rad/s, held and free.
  EXPECT_NEAR(std::sqrt(s.eigenvalues(0)), 512.0858543714135, 1e-9 * 512);
  EXPECT_NEAR(s.omega(6), 1927.9713583169425, 1e-9 * 1927);
}

TEST_P(ReferenceFile, facesLookOutwards) {
  const auto contact = std::find_if(s.surfaces.begin(), s.surfaces.end(),
                                    [](const Surface& surface) { return surface.name == "x_max"; });
  ASSERT_NE(contact, s.surfaces.end());
  EXPECT_EQ(contact->kind, FaceKind::quad4);
  Vector3 area = Vector3::Zero();
  for (Index i = 0; i < contact->n_faces(); ++i) {
    const auto corner = [&](Index j) {
      return Vector3(s.coordinates.row(contact->faces(i, j)).transpose());
    };
    area += 0.5 * (corner(2) - corner(0)).cross(corner(3) - corner(1));
    EXPECT_EQ(contact->side[i], 2);
  }
  EXPECT_LT((area - Vector3(2, 0, 0)).norm(), 1e-12);
}

TEST_P(ReferenceFile, interiorFollowsRigidMotions) {
  ASSERT_EQ(s.recovery.size(), 1u);
  const auto& recovery = s.recovery[0];
  EXPECT_EQ(recovery.node_ids.size(), 18u);
  ASSERT_EQ(recovery.blocks.size(), 1u);
  EXPECT_EQ(recovery.blocks[0].connectivity.rows(), 6);
  const Matrix R_c = reduced_rigid_modes(s, Vector3::Zero()).bottomRows(s.c());
  EXPECT_LT((recovery.Psi * R_c - rigid_modes(recovery.coordinates, Vector3::Zero()))
                .cwiseAbs()
                .maxCoeff(),
            1e-10);
}

INSTANTIATE_TEST_SUITE_P(Version, ReferenceFile,
                         testing::Values("superelement-1.0.cbr.h5", "superelement-1.4.cbr.h5",
                                         "superelement-1.5.cbr.h5", "superelement-1.6.cbr.h5",
                                         "superelement-1.8.cbr.h5", "superelement-1.9.cbr.h5"));

// What 1.4 has beyond 1.0: checksums, errors, conditioning.
TEST(ReferenceFiles, ErrorsAndConditioningAreRead) {
  const Superelement s =
      read_superelement(CBR_SOURCE_DIR "/tests/formats/data/superelement-1.4.cbr.h5");
  ASSERT_TRUE(s.accuracy.has_value());
  ASSERT_EQ(s.accuracy->eigenvalue_error.size(), 1);
  EXPECT_NEAR(s.accuracy->eigenvalue_error(0), 0.11556431, 1e-8);
  EXPECT_FALSE(s.accuracy->worst_of_ten);  // since 1.5
  EXPECT_EQ(s.accuracy->interface_share.size(), 0);
  ASSERT_TRUE(s.conditioning.has_value());
  EXPECT_EQ(s.conditioning->n_rigid, 6);
  EXPECT_EQ(s.conditioning->n_zero, 6);
  EXPECT_EQ(s.conditioning->weakest, "node id 87 of block 'solid' in y");
}

// What 1.8 has beyond 1.6. Of a rigid rotation about axis a, u = a x x, the moments are
// sym(sum rho x (a x x)^T).
TEST(ReferenceFiles, SpinMomentsAreRead) {
  const Superelement s =
      read_superelement(CBR_SOURCE_DIR "/tests/formats/data/superelement-1.8.cbr.h5");
  ASSERT_EQ(s.spin_moments.rows(), s.n());
  ASSERT_EQ(s.spin_moments.cols(), 6);
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  const Matrix moments = s.spin_moments.transpose() * R;  // 6 x 6
  const double scale = s.spin_moments.cwiseAbs().maxCoeff();
  // x is from the centre of mass: a translation has none
  EXPECT_LT(moments.leftCols(3).cwiseAbs().maxCoeff(), 1e-9 * scale);
  // integral of rho x x^T = tr(J) / 2 - J of the inertia J about the centre
  const Matrix3& J = s.rigid_body.inertia;
  const Matrix3 S = 0.5 * J.trace() * Matrix3::Identity() - J;
  for (Index a = 0; a < 3; ++a) {
    Matrix3 turn;  // turn x = a x x
    for (Index j = 0; j < 3; ++j) turn.col(j) = Vector3::Unit(a).cross(Vector3::Unit(j));
    const Matrix3 expected = 0.5 * (S * turn.transpose() + turn * S);
    const Vector found = moments.col(3 + a);
    EXPECT_NEAR(found(0), expected(0, 0), 1e-9 * scale);
    EXPECT_NEAR(found(1), expected(1, 1), 1e-9 * scale);
    EXPECT_NEAR(found(2), expected(2, 2), 1e-9 * scale);
    EXPECT_NEAR(found(3), expected(0, 1), 1e-9 * scale);
    EXPECT_NEAR(found(4), expected(1, 2), 1e-9 * scale);
    EXPECT_NEAR(found(5), expected(0, 2), 1e-9 * scale);
  }
}

}  // namespace
}  // namespace cbr::reference_file_test

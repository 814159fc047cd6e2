// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/assembly.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test::assembly_test {
namespace {

const Material steel = {210e9, 0.3, 7850};

// Every node inside moved at random, corners and (for quadratic elements) the middle nodes on their
// own: curved edges.
Mesh distorted_box(ElementType type) {
  const Vector3 L(1.2, 1, 0.8);
  Random random(3);
  const auto inside = [&](const Vector3& x) {
    return (x.array() > 1e-9).all() && (x.array() < L.array() - 1e-9).all();
  };
  const auto moved = [&](const Vector3& x, double share) -> Vector3 {
    return inside(x) ? Vector3(x + share * Vector3(random(), random(), random())) : x;
  };
  Mesh mesh = box_mesh(type, {3, 2, 2}, L, [&](const Vector3& x) { return moved(x, 0.06); });
  std::set<Index> corners;
  const Block& block = mesh.blocks[0];
  for (Index e = 0; e < block.connectivity.rows(); ++e)
    for (Index i = 0; i < n_corners(block.type); ++i) corners.insert(block.connectivity(e, i));
  for (Index i = 0; i < mesh.coordinates.rows(); ++i)
    if (!corners.contains(i))
      mesh.coordinates.row(i) = moved(mesh.coordinates.row(i).transpose(), 0.015).transpose();
  return mesh;
}

std::vector<bool> on_boundary(const Mesh& mesh) {
  const Points& X = mesh.coordinates;
  std::vector<bool> flags;
  for (Index i = 0; i < X.rows(); ++i) {
    bool touches = false;
    for (Index c = 0; c < 3; ++c)
      touches =
          touches || X(i, c) < X.col(c).minCoeff() + 1e-9 || X(i, c) > X.col(c).maxCoeff() - 1e-9;
    flags.push_back(touches);
  }
  return flags;
}

class Assembly : public testing::TestWithParam<ElementKind> {
 protected:
  FiniteElementModel model(const Mesh& mesh, MassKind mass = MassKind::consistent) const {
    return assemble(mesh, {{steel, GetParam().hex}}, mass);
  }
};

TEST_P(Assembly, PatchTest) {
  const Mesh mesh = distorted_box(GetParam().type);
  Matrix3 H;
  H << 3e-4, -2e-4, 5e-4, 1e-4, 7e-4, -4e-4, 2e-4, 6e-4, -1e-4;
  Points u = mesh.coordinates * H.transpose();
  const Points exact = u;
  const Matrix K = model(mesh).K;
  std::vector<Index> I, C;
  const auto boundary = on_boundary(mesh);
  for (Index i = 0; i < u.rows(); ++i)
    for (Index c = 0; c < 3; ++c) (boundary[i] ? C : I).push_back(3 * i + c);
  ASSERT_GE(I.size(), 6u);
  Eigen::Map<Vector> q(u.data(), u.size());
  // u_I = -K_II^-1 K_IC u_C
  q(I) = -Cholesky(K(I, I)).solve(K(I, C) * Vector(q(C)));
  EXPECT_LE((u - exact).cwiseAbs().maxCoeff(), 1e-12 * exact.cwiseAbs().maxCoeff());

  const double lambda = 210e9 * 0.3 / (1.3 * 0.4), mu = 210e9 / 2.6;
  const Matrix3 S = lambda * H.trace() * Matrix3::Identity() + mu * (H + H.transpose());
  Eigen::Matrix<double, 6, 1> stress;
  stress << S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(1, 2), S(0, 2);
  const Block& block = mesh.blocks[0];
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    Points u_e(block.connectivity.cols(), 3);
    for (Index i = 0; i < u_e.rows(); ++i) u_e.row(i) = u.row(block.connectivity(e, i));
    const auto found =
        element_stress(block.type, GetParam().hex, points_of(mesh, block, e), steel, u_e);
    EXPECT_LE((found - stress).norm(), 1e-12 * stress.norm()) << "element " << e;
  }
}

TEST_P(Assembly, SixRigidMotionsAndNoOther) {
  const Mesh mesh = distorted_box(GetParam().type);
  const auto fe = model(mesh);
  const Matrix R = rigid_modes(mesh.coordinates, Vector3(0.6, 0.5, 0.4));
  EXPECT_LE((fe.K * R).cwiseAbs().maxCoeff(), 1e-13 * Vector(fe.K.diagonal()).maxCoeff());
  const Vector lambda = symmetric_eigenvalues(Matrix(fe.K));
  EXPECT_LE(lambda.head(6).cwiseAbs().maxCoeff(), 1e-13 * lambda.maxCoeff());
  EXPECT_GE(lambda(6), 1e-6 * lambda.maxCoeff());
}

TEST_P(Assembly, IsTheSumOfItsElements) {
  const Mesh mesh = distorted_box(GetParam().type);
  const auto fe = model(mesh);
  const Block& block = mesh.blocks[0];
  Matrix K = Matrix::Zero(fe.K.rows(), fe.K.cols()), M = K;
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    const Points X = points_of(mesh, block, e);
    const Matrix k = element_stiffness(block.type, GetParam().hex, X, steel),
                 m = element_mass(block.type, X, steel.density);
    for (Index i = 0; i < X.rows(); ++i)
      for (Index j = 0; j < X.rows(); ++j) {
        const Index p = 3 * block.connectivity(e, i), q = 3 * block.connectivity(e, j);
        K.block<3, 3>(p, q) += k.block<3, 3>(3 * i, 3 * j);
        M.block<3, 3>(p, q) += m(i, j) * Matrix3::Identity();
      }
  }
  EXPECT_EQ(Matrix(fe.K), K);  // the same sums in the same order
  EXPECT_EQ(Matrix(fe.M), M);
  EXPECT_TRUE(fe.K.isCompressed());
  EXPECT_EQ(K, Matrix(K.transpose()));
  EXPECT_EQ(M, Matrix(M.transpose()));
  for (Index j = 0; j < fe.K.cols(); ++j)
    for (Index k = fe.K.outerIndexPtr()[j] + 1; k < fe.K.outerIndexPtr()[j + 1]; ++k)
      ASSERT_LT(fe.K.innerIndexPtr()[k - 1], fe.K.innerIndexPtr()[k]);
}

TEST_P(Assembly, SameBytesWithOneThreadAndMany) {
  const Mesh mesh = distorted_box(GetParam().type);
  set_threads(1);
  const auto one = model(mesh);
  set_threads(3);
  const auto many = model(mesh);
  set_threads(0);
  EXPECT_EQ(Matrix(one.K), Matrix(many.K));
  EXPECT_EQ(Matrix(one.M), Matrix(many.M));
}

TEST_P(Assembly, NumbersOfNodesAndElementsDoNotMatter) {
  const Mesh mesh = distorted_box(GetParam().type);
  Mesh other = mesh;
  const Index n = mesh.coordinates.rows(), n_e = mesh.blocks[0].connectivity.rows();
  std::vector<Index> place = first_numbers(n);
  Random random(11);
  for (Index i = n - 1; i > 0; --i)
    std::swap(place[i], place[static_cast<Index>((random() + 1) / 2 * static_cast<double>(i + 1))]);
  for (Index i = 0; i < n; ++i) other.coordinates.row(place[i]) = mesh.coordinates.row(i);
  for (Index e = 0; e < n_e; ++e)
    for (Index i = 0; i < mesh.blocks[0].connectivity.cols(); ++i)
      other.blocks[0].connectivity(n_e - 1 - e, i) = place[mesh.blocks[0].connectivity(e, i)];
  const auto first = model(mesh), second = model(other);
  std::vector<Index> dofs;
  for (Index i = 0; i < n; ++i)
    for (Index c = 0; c < 3; ++c) dofs.push_back(3 * place[i] + c);
  const Matrix K = first.K, M = first.M;
  EXPECT_LE((Matrix(second.K)(dofs, dofs) - K).cwiseAbs().maxCoeff(),
            1e-14 * K.cwiseAbs().maxCoeff());
  EXPECT_LE((Matrix(second.M)(dofs, dofs) - M).cwiseAbs().maxCoeff(),
            1e-14 * M.cwiseAbs().maxCoeff());
}

TEST_P(Assembly, LumpedMassIsDiagonalAndOfTheSameTotal) {
  const Mesh mesh = distorted_box(GetParam().type);
  const auto lumped = model(mesh, MassKind::lumped), consistent = model(mesh);
  EXPECT_EQ(lumped.M.nonZeros(), lumped.M.rows());
  EXPECT_GT(Vector(lumped.M.diagonal()).minCoeff(), 0);
  EXPECT_EQ(Matrix(lumped.K), Matrix(consistent.K));
  const double total = 3 * steel.density * 1.2 * 0.8;
  EXPECT_NEAR(Vector(lumped.M.diagonal()).sum(), total, 1e-13 * total);
  EXPECT_NEAR(consistent.M.sum(), total, 1e-13 * total);
}

INSTANTIATE_TEST_SUITE_P(All, Assembly, testing::ValuesIn(element_kinds()));

TEST(AssemblyOfBlocks, NodesWithoutVolumeElementsGetNoDofs) {
  Mesh mesh = box_mesh(ElementType::hex8, {2, 1, 1}, Vector3(2, 1, 1));
  const Index n = mesh.coordinates.rows();
  // A stray node in front, and a shell on it.
  Points X(n + 1, 3);
  X << 9, 9, 9, mesh.coordinates;
  mesh.coordinates = X;
  mesh.node_ids.push_back(n + 1);
  mesh.blocks[0].connectivity.array() += 1;
  Block skin;
  skin.name = "skin";
  skin.type = ElementType::tri3;
  skin.connectivity.resize(1, 3);
  skin.connectivity << 0, 1, 2;
  skin.element_ids = {99};
  mesh.blocks.insert(mesh.blocks.begin(), skin);
  const auto fe = assemble(mesh, {{}, {steel}}, MassKind::lumped);
  ASSERT_EQ(fe.nodes.size(), static_cast<std::size_t>(n));
  EXPECT_EQ(fe.row[0], -1);
  for (std::size_t i = 0; i < fe.nodes.size(); ++i)
    EXPECT_EQ(fe.row[fe.nodes[i]], static_cast<Index>(i));
  EXPECT_EQ(fe.K.rows(), 3 * n);
  mesh.blocks.pop_back();
  EXPECT_SAYS(refusal_of([&] { assemble(mesh, {{}}, MassKind::lumped); }), "no volume elements");
}

TEST(AssemblyOfBlocks, EachHasItsMaterial) {
  const Mesh whole = box_mesh(ElementType::hex8, {2, 1, 1}, Vector3(2, 1, 1));
  Mesh mesh = whole;
  mesh.blocks.push_back(mesh.blocks[0]);
  for (std::size_t b = 0; b < 2; ++b) {
    const IndexTable row = whole.blocks[0].connectivity.row(static_cast<Index>(b));
    mesh.blocks[b].connectivity = row;
    mesh.blocks[b].element_ids = {static_cast<Index>(b) + 1};
  }
  const auto fe = assemble(mesh, {{{1, 0.3, 1}}, {{1e12, 0.3, 1e9}}}, MassKind::consistent);
  const RigidBody body = rigid_body(fe.M, mesh.coordinates);
  EXPECT_NEAR(body.mass, 1 + 1e9, 1e-6);
  EXPECT_NEAR(body.center(0), (0.5 + 1.5e9) / (1 + 1e9), 1e-14);
  EXPECT_EQ(Matrix(fe.K), Matrix(fe.K.transpose()));
}

class Refusal : public testing::Test {
 protected:
  Mesh mesh = box_mesh(ElementType::hex8, {2, 2, 1}, Vector3(2, 2, 1));
  Block& block = mesh.blocks[0];
  std::string message(const Material& material = steel) {
    block.element_ids = {11, 12, 13, 14};
    return refusal_of([&] { assemble(mesh, {{material}}, MassKind::lumped); });
  }
  void expect(const std::vector<std::string>& parts, const Material& material = steel) {
    const std::string found = message(material);
    for (const auto& part : parts) EXPECT_SAYS(found, part) << "'" << part << "' in: " << found;
    EXPECT_EQ(found.find('\n'), std::string::npos);
  }
};

TEST_F(Refusal, NothingWhenSound) { EXPECT_EQ(message(), "no error"); }

TEST_F(Refusal, InvertedElementByItsIdAndBlock) {
  const IndexTable row = block.connectivity.row(2);
  block.connectivity.row(2) << row.rightCols(4), row.leftCols(4);
  expect({"'solid'", "element 13", "hex8", "inverted"});
}

TEST_F(Refusal, FlatElement) {
  for (Index i = 4; i < 8; ++i) mesh.coordinates(block.connectivity(0, i), 2) = 0;
  expect({"'solid'", "element 11", "degenerate"});
}

TEST_F(Refusal, RepeatedNode) {
  block.connectivity(1, 7) = block.connectivity(1, 6);
  mesh.node_ids[block.connectivity(1, 6)] = 777;
  expect({"element 12", "node 777", "twice"});
}

TEST_F(Refusal, CoordinateThatIsNoNumber) {
  const Index node = block.connectivity(3, 2);
  mesh.node_ids[node] = 4711;
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    mesh.coordinates(node, 1) = bad;
    expect({"node 4711", "not a finite number"});
  }
}

TEST_F(Refusal, TheSameElementTwiceInAnyOrderOfNodes) {
  for (Index i = 0; i < 8; ++i)
    block.connectivity(3, i) = block.connectivity(0, 4 * (i / 4) + (i + 1) % 4);
  expect({"element 14", "same nodes as", "element 11"});
}

TEST_F(Refusal, MagnitudesThatNoDoubleHolds) {
  expect({"'solid'", "youngs_modulus", "units"}, {1e300, 0.3, 1});
  expect({"'solid'", "density", "units"}, {1, 0.3, 1e-300});
  mesh.coordinates *= 1e-150;
  expect({"'solid'", "size", "mass", "units"});
}

TEST_F(Refusal, MaterialsThatThereAreNot) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  expect({"'solid'", "youngs_modulus"}, {0, 0.3, 1});
  expect({"youngs_modulus"}, {nan, 0.3, 1});
  expect({"youngs_modulus"}, {infinity, 0.3, 1});
  expect({"poissons_ratio", "0.5"}, {1, 0.5, 1});
  expect({"poissons_ratio"}, {1, -1, 1});
  expect({"poissons_ratio"}, {1, nan, 1});
  expect({"density"}, {1, 0.3, 0});
  expect({"density"}, {1, 0.3, infinity});
}

TEST(RigidBody, OfPointMasses) {
  Points x(4, 3);
  x << 1, 2, 3, -1, 0.5, 2, 4, -2, 1, 0, 0, 7;
  const Vector m = (Vector(4) << 1, 2, 3, 0.5).finished();
  SparseMatrix M(12, 12);
  M.setIdentity();
  Vector3 center = Vector3::Zero();
  for (Index i = 0; i < 4; ++i) {
    for (Index c = 0; c < 3; ++c) M.coeffRef(3 * i + c, 3 * i + c) = m(i);
    center += m(i) * x.row(i).transpose() / m.sum();
  }
  Matrix3 inertia = Matrix3::Zero();
  for (Index i = 0; i < 4; ++i) {
    const Vector3 r = x.row(i).transpose() - center;
    inertia += m(i) * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  const RigidBody body = rigid_body(M, x);
  EXPECT_NEAR(body.mass, m.sum(), 1e-15 * m.sum());
  EXPECT_LE((body.center - center).norm(), 1e-14);
  EXPECT_LE((body.inertia - inertia).norm(), 1e-14 * inertia.norm());
}

}  // namespace
}  // namespace cbr::test::assembly_test

// SPDX-License-Identifier: GPL-3.0-or-later
// Statics that basis characteristic keeps, against dense matrices of the whole component.
#include "reducer/bases/characteristic/statics.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>

#include "common/fem/assembly.hpp"
#include "reducer/bases/characteristic/free_shapes.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::statics_test {
namespace {

ReductionOptions touching(const std::vector<std::string>& sets, std::map<std::string, bool> slides,
                          Index fixed = 8) {
  ReductionOptions options;
  options.basis = Basis::characteristic;
  options.interface_sets = sets;
  options.modes = fixed;
  options.characteristic.modes = 4;
  options.characteristic.needs.touching = std::move(slides);
  return options;
}

// Answers of the free component to forces (N x s), the inertia of its rigid motions in balance with
// them, dense and whole:
//   U = (1 - N N^T M) G (1 - M N N^T) B,   G = (K + scale M N N^T M)^-1,   N^T M N = 1
Matrix dense_answers(const Mesh& mesh, MassKind mass, const Matrix& B) {
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), mass);
  const Matrix K(model.K), M(model.M);
  Points x(static_cast<Index>(model.nodes.size()), 3);
  for (Index i = 0; i < x.rows(); ++i) x.row(i) = mesh.coordinates.row(model.nodes[i]);
  const Matrix R = rigid_modes(x, rigid_body(model.M, x).center);
  Matrix N = R;
  Cholesky(R.transpose() * M * R).divide_by_upper(N);
  const Matrix P = M * N;
  const double scale = K.diagonal().mean() / P.squaredNorm();
  const Ldlt factor(K + scale * P * P.transpose());
  const Matrix U = factor.solve(B - P * (N.transpose() * B));
  return U - N * (P.transpose() * U);
}

// The superelement's forces on the component's dofs   (N x s)
Matrix forces_on_component(const Mesh& mesh, const Superelement& s) {
  const FiniteElementModel model = number_nodes(mesh);
  const StaticShare& statics = s.characteristic.statics;
  Matrix B = Matrix::Zero(3 * static_cast<Index>(model.nodes.size()), statics.size());
  for (Index i = 0; i < statics.size(); ++i) {
    const Index id = s.node_ids[statics.node[i]];
    const auto found = std::find(mesh.node_ids.begin(), mesh.node_ids.end(), id);
    const Index row = model.row[found - mesh.node_ids.begin()];
    B.block(3 * row, i, 3, 1) = statics.direction.row(i).transpose();
  }
  return B;
}

Matrix of_modes(const Superelement& s) {
  const Matrix G = forces_on_dofs(s.characteristic.statics, s).transpose() *
                   s.characteristic.V.rightCols(s.k() - 6);
  return G * s.eigenvalues.tail(s.k() - 6).cwiseInverse().asDiagonal() * G.transpose();
}

TEST(Statics, OfAnyForceOnAFaceAreExact) {
  const Mesh mesh = skewed();
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    for (const bool slides : {false, true}) {
      for (const Index fixed : {Index{0}, Index{8}}) {
        const Superelement s =
            reduced(mesh, touching({"x_max", "y_max"}, {{"x_max", slides}}, fixed), mass);
        const StaticShare& statics = s.characteristic.statics;
        ASSERT_EQ(statics.size(), (slides ? 3 : 1) * 20);
        const Matrix B = forces_on_component(mesh, s),
                     exact = B.transpose() * dense_answers(mesh, mass, B);
        const double largest = exact.cwiseAbs().maxCoeff();
        EXPECT_LT((of_modes(s) + statics.F - exact).cwiseAbs().maxCoeff(), 1e-9 * largest)
            << slides << fixed;
        // Shapes are a part of what the component can do, so that nothing negative is left
        const Vector left = symmetric_eigenvalues(statics.F);
        EXPECT_GT(left.minCoeff(), -1e-11 * largest) << slides << fixed;
        EXPECT_GT(left.maxCoeff(), 1e-3 * largest) << slides << fixed;
      }
    }
  }
}

// The way of large interfaces, which forms no dense matrix of them, on a small one.
TEST(Statics, OfSparseSolvesAreExactToo) {
  const Mesh mesh = skewed();
  for (const bool one_factor : {false, true}) {
    const bool slides = one_factor;
    const ReductionOptions options = touching({"x_max", "y_max"}, {{"x_max", slides}}, 0);
    Superelement s = reduced(mesh, options);
    FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
    const Partition p = partition(model, interface_nodes(mesh, model, {"x_max", "y_max"}));
    Points x(static_cast<Index>(model.nodes.size()), 3);
    for (Index i = 0; i < x.rows(); ++i) x.row(i) = mesh.coordinates.row(model.nodes[i]);
    Report report("test", Verbosity::quiet);
    const FreeComponent component{model.K, model.M, x};
    // Many forces make one factor with the interface last the cheaper way
    const FreeFactor factor = free_factor(component, p, one_factor ? 1'000'000 : 0);
    ASSERT_EQ(factor.interior.has_value(), one_factor);
    auto shapes = free_shapes(options.characteristic, component, factor, p,
                              s.characteristic.statics, s, report);
    ASSERT_TRUE(shapes);
    const Matrix B = forces_on_component(mesh, s),
                 exact = B.transpose() * dense_answers(mesh, MassKind::lumped, B);
    const double largest = exact.cwiseAbs().maxCoeff();
    EXPECT_LT((shapes->compliance - exact).cwiseAbs().maxCoeff(), 1e-9 * largest);
    const SparseCholesky own(p.K_II);
    follow_statically(p, one_factor ? *factor.interior : own, *shapes);
    const Matrix none(p.n_interior(), 0);
    take_free_shapes(*shapes, Vector(0), none, p, s, nullptr);
    check(s, "test");
    EXPECT_EQ(s.k(), 6 + 4 + 1);
    EXPECT_LT((of_modes(s) + s.characteristic.statics.F - exact).cwiseAbs().maxCoeff(),
              1e-9 * largest);
    EXPECT_GT(symmetric_eigenvalues(s.characteristic.statics.F).minCoeff(), -1e-11 * largest);
  }
}

// Of many forces, normal to a face or in all directions: against the dense matrix of the same face.
TEST(Statics, OfManyForcesComeInLevels) {
  const Mesh mesh = box_mesh({{18, 18, 3}, {18, 18, 3}, {0, 0, 0}, 0.1});
  for (const bool slides : {false, true}) {
    const ReductionOptions options = touching({"z_max"}, {{"z_max", slides}}, 0);
    const auto with_statics = [&](Index most_dense) {
      Superelement s = reduced(mesh, options);
      FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
      const Partition p = partition(model, interface_nodes(mesh, model, {"z_max"}));
      Points x(static_cast<Index>(model.nodes.size()), 3);
      for (Index i = 0; i < x.rows(); ++i) x.row(i) = mesh.coordinates.row(model.nodes[i]);
      Report report("test", Verbosity::quiet);
      const FreeComponent component{model.K, model.M, x};
      const FreeFactor factor = free_factor(component, p, 0);
      auto shapes = free_shapes(options.characteristic, component, factor, p,
                                s.characteristic.statics, s, report, most_dense);
      follow_statically(p, SparseCholesky(p.K_II), *shapes);
      take_free_shapes(*shapes, Vector(0), Matrix(p.n_interior(), 0), p, s, nullptr);
      return s;
    };
    const Superelement dense = with_statics(5000), s = with_statics(300);
    const Matrix& F = dense.characteristic.statics.F;
    const std::vector<ComplianceLevel>& levels = s.characteristic.statics.levels;
    ASSERT_GE(levels.size(), 3U);
    const Index n = F.rows();
    // Nothing gains energy
    EXPECT_GT(symmetric_eigenvalues(compliance_product(levels, Matrix::Identity(n, n))).minCoeff(),
              -1e-4 * F.diagonal().maxCoeff());
    const Matrix C = of_modes(dense) + F;
    const StaticShare& forces = dense.characteristic.statics;
    for (const double radius : {0.5, 1.5, 3.0, 6.0, 100.0})
      for (const Vector3& at : {Vector3(9, 9, 3), Vector3(3, 14, 3), Vector3(0, 0, 3)})
        for (const Vector3& direction : {Vector3(0, 0, 1), Vector3(0.6, 0.8, 0)}) {
          Vector p(n);
          for (Index i = 0; i < n; ++i) {
            const Index node = forces.node[i];
            const double r = (s.coordinates.row(node).transpose() - at).norm() / radius;
            p[i] = std::sqrt(std::max(0.0, 1 - r * r)) * forces.direction.row(i).dot(direction);
          }
          if (!slides && direction.z() == 0) continue;  // normals have hardly a part along it
          const double work = p.dot(C * p),
                       error = p.dot(Vector(compliance_product(levels, p) - F * p));
          EXPECT_LT(std::abs(error), (radius > 2 ? 0.01 : 0.05) * work)
              << slides << " " << radius << " at " << at.transpose() << ", "
              << direction.transpose();
        }
  }
}

TEST(Statics, NodesOfTwoFacesHaveBothDirections) {
  const Mesh mesh = skewed();
  const Superelement s =
      reduced(mesh, touching({"x_max", "y_max"}, {{"x_max", false}, {"y_max", false}}));
  const StaticShare& statics = s.characteristic.statics;
  ASSERT_EQ(statics.size(), 20 + 24);
  const Matrix B = forces_on_component(mesh, s),
               exact = B.transpose() * dense_answers(mesh, MassKind::lumped, B);
  EXPECT_LT((of_modes(s) + statics.F - exact).cwiseAbs().maxCoeff(),
            1e-9 * exact.cwiseAbs().maxCoeff());
  // One of them with friction: all directions, once
  EXPECT_EQ(reduced(mesh, touching({"x_max", "y_max"}, {{"x_max", true}, {"y_max", false}}))
                .characteristic.statics.size(),
            3 * 20 + 24 - 4);
}

TEST(Statics, KeptAndHeldNodesNeedNone) {
  const Mesh mesh = skewed();
  ReductionOptions options = touching({"x_max", "y_max"}, {{"x_max", false}});
  options.characteristic.needs.held = {"y_max", "a set that the interface does not keep"};
  const Superelement s = reduced(mesh, options);
  EXPECT_EQ(s.characteristic.statics.size(), 20 - 4);
  EXPECT_EQ(s.k(), 8 + 3 * 24 + 4 + 1 + 6);  // six of inertia
  options.characteristic.needs.held.clear();
  options.characteristic.keep = {"x_max"};
  EXPECT_TRUE(reduced(mesh, options).characteristic.statics.empty());
}

TEST(Statics, AreOfWhatIsAskedFor) {
  const Mesh mesh = skewed();
  ReductionOptions options = touching({"x_max", "y_max"}, {});
  const auto size = [&] { return reduced(mesh, options).characteristic.statics.size(); };
  EXPECT_EQ(size(), 0);
  options.characteristic.statics = {"y_max"};
  EXPECT_EQ(size(), 24);
  options.characteristic.shear = true;
  EXPECT_EQ(size(), 3 * 24);
  options.characteristic = {};
  options.characteristic.needs.all_touch = false;
  EXPECT_EQ(size(), 20 + 24);
  options.characteristic.needs.all_touch = true;
  EXPECT_EQ(size(), 3 * (20 + 24 - 4));
  options.characteristic.statics = {"y_mx"};
  EXPECT_EQ(refusal_of([&] { reduced(mesh, options); }),
            "characteristic.statics: the interface keeps no sideset 'y_mx', did you mean 'y_max'? "
            "allowed: x_max, y_max");
}

}  // namespace
}  // namespace cbr::test::statics_test

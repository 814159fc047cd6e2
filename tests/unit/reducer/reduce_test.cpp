// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/reduce.hpp"
#include "common/linalg/dense.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/linalg/eigen/eigenpairs.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/partition/partition.hpp"
#include "tests/support/refusal.hpp"
#include "tests/unit/reducer/reduced.hpp"

namespace cbr::test::reduce_test {
namespace {

ReductionOptions with_modes(std::vector<std::string> sets, Index modes) {
  ReductionOptions options;
  options.interface_sets = std::move(sets);
  options.modes = modes;
  return options;
}

Vector full_eigenvalues(const Mesh& mesh, MassKind mass) {
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), mass);
  return dense_eigenpairs(Matrix(model.K), Matrix(model.M), model.K.rows()).lambda;
}

Vector reduced_eigenvalues(const Superelement& s) {
  return dense_eigenpairs(reduced_stiffness(s), reduced_mass(s), s.n()).lambda;
}

std::string message_of(const Mesh& mesh, const ReductionOptions& options) {
  return refusal_of([&] { reduced(mesh, options); });
}

class BothMasses : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Reduce, BothMasses,
                         testing::Values(MassKind::lumped, MassKind::consistent));

TEST_P(BothMasses, AllModesGiveTheFullModel) {
  const Mesh mesh = skewed({3, 3, 2});
  const Vector full = full_eigenvalues(mesh, GetParam());
  for (const char* set : {"x_max", "surface", "z_min"}) {
    const Index n_I = full.size() - 3 * static_cast<Index>(set_nodes(mesh, set).size());
    const Superelement s = reduced(mesh, with_modes({set}, n_I), GetParam());
    EXPECT_EQ(s.n(), full.size());
    const Vector lambda = reduced_eigenvalues(s);
    for (Index j = 6; j < full.size(); ++j)
      EXPECT_NEAR(lambda(j), full(j), 1e-9 * full(j)) << set << " " << j;
    EXPECT_LT(lambda.head(6).cwiseAbs().maxCoeff(), 1e-12 * full(full.size() - 1));
  }
}

TEST_P(BothMasses, FrequenciesFallToTheFullOnesWithTheNumberOfModes) {
  const Mesh mesh = skewed();
  const Vector full = full_eigenvalues(mesh, GetParam()).segment(6, 12);
  Vector before = Vector::Constant(12, INFINITY), first;
  for (const Index k : {Index{0}, Index{5}, Index{10}, Index{20}, Index{40}}) {
    const Vector lambda =
        reduced_eigenvalues(reduced(mesh, with_modes({"x_max"}, k), GetParam())).segment(6, 12);
    EXPECT_TRUE((lambda.array() <= before.array() * (1 + 1e-10)).all()) << k;
    EXPECT_TRUE((lambda.array() >= full.array() * (1 - 1e-10)).all()) << k;
    before = lambda;
    if (k == 0) first = lambda;
  }
  EXPECT_LT((before - full)(0), 0.02 * (first - full)(0));
}

TEST_P(BothMasses, RigidMotionsAreFreeOfForceAndCarryTheMass) {
  const Mesh mesh = skewed();
  const Superelement s = reduced(mesh, with_modes({"x_max", "y_min"}, 7), GetParam());
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  EXPECT_LT((reduced_stiffness(s) * R).cwiseAbs().maxCoeff(),
            1e-12 * s.K_cc.cwiseAbs().maxCoeff() * R.cwiseAbs().maxCoeff());
  const Matrix m = R.transpose() * reduced_mass(s) * R;
  EXPECT_LT(relative(m.topLeftCorner(3, 3), s.rigid_body.mass * Matrix3::Identity()), 1e-12);
  EXPECT_LT(relative(m.bottomRightCorner(3, 3), s.rigid_body.inertia), 1e-12);
  EXPECT_LT(m.topRightCorner(3, 3).cwiseAbs().maxCoeff(), 1e-12 * m.cwiseAbs().maxCoeff());
}

TEST_P(BothMasses, WaysOfCondensationAgree) {
  const Mesh mesh = skewed();
  ReductionOptions options = with_modes({"x_max", "z_max"}, 12);
  ReduceSettings product, solve, memory, fronts;
  fronts.way = CondensationWay::fronts;
  product.way = CondensationWay::product;
  solve.way = CondensationWay::second_solve;
  solve.panel = 17;
  memory.memory = 3000;
  const Superelement a = reduced(mesh, options, GetParam(), product),
                     b = reduced(mesh, options, GetParam(), solve);
  ReductionFigures figures;
  const Superelement c = reduced(mesh, options, GetParam(), memory, &figures);
  EXPECT_EQ(figures.way, CondensationWay::second_solve);
  EXPECT_EQ(figures.panel, 1);
  const Superelement d = reduced(mesh, options, GetParam(), fronts, &figures);
  EXPECT_EQ(figures.way, CondensationWay::fronts);
  EXPECT_GT(figures.front_flops, 0);
  for (const Superelement* other : {&b, &c, &d}) {
    EXPECT_LT(relative(other->K_cc, a.K_cc), 1e-14);
    EXPECT_LT(relative(other->M_cc, a.M_cc), 1e-13);
    EXPECT_LT(relative(other->M_kc, a.M_kc), 1e-13);
  }
  for (const Superelement* s : {&a, &b, &d}) {
    EXPECT_EQ(s->K_cc, Matrix(s->K_cc.transpose()));
    EXPECT_EQ(s->M_cc, Matrix(s->M_cc.transpose()));
  }
}

TEST_P(BothMasses, AgreesWithTheTransformedFullMatrices) {
  // K^ = T^T K T, M^ = T^T M T with T = [Phi Psi; 0 I] from the recovery data, however right the
  // modes are.
  const Mesh mesh = skewed();
  for (const bool exact : {false, true}) {
    ReductionOptions options = with_modes({"x_max"}, 9);
    options.recovery = true;
    options.exact_modes = exact;
    const Superelement s = reduced(mesh, options, GetParam());
    const FiniteElementModel model = assemble(mesh, properties(mesh, soft), GetParam());
    const Partition p = partition(model, interface_nodes(mesh, model, {"x_max"}));
    ASSERT_EQ(s.recovery.size(), 1u);
    const Matrix &Psi = s.recovery[0].Psi, &Phi = s.recovery[0].Phi;
    Matrix T = Matrix::Zero(model.K.rows(), s.n());
    const std::vector<Index> I = dofs_of(p.interior_nodes), C = dofs_of(p.interface_nodes);
    T(I, Eigen::seqN(0, s.k())) = Phi;
    T(I, Eigen::seqN(s.k(), s.c())) = Psi;
    T(C, Eigen::seqN(s.k(), s.c())) = Matrix::Identity(s.c(), s.c());
    EXPECT_LT(relative(T.transpose() * (model.K * T), reduced_stiffness(s)), 1e-12);
    EXPECT_LT(relative(T.transpose() * (model.M * T), reduced_mass(s)), 1e-12);
    EXPECT_LT((p.K_II * Psi + p.K_IC).norm(), 1e-13 * p.K_IC.norm());
    if (!exact) continue;
    // From K_II Phi = M_II Phi Lambda:  M_kc = Phi^T M_IC - Lambda^-1 Phi^T K_IC
    const Matrix other = Phi.transpose() * p.M_IC -
                         s.eigenvalues.cwiseInverse().asDiagonal() * (Phi.transpose() * p.K_IC);
    EXPECT_LT(relative(other, s.M_kc), 1e-11);
  }
}

TEST_P(BothMasses, DiagonalFormIsOrthonormalWithExactRigidModes) {
  const Mesh mesh = skewed();
  const Superelement s = reduced(mesh, with_modes({"x_max"}, 15), GetParam());
  ASSERT_TRUE(s.has_diagonal_form());
  const Matrix M = reduced_mass(s), K = reduced_stiffness(s);
  EXPECT_LT((s.V.transpose() * M * s.V - Matrix::Identity(s.n(), s.n())).cwiseAbs().maxCoeff(),
            1e-12);
  const Vector lambda = s.omega.cwiseAbs2();
  EXPECT_LT((s.V.transpose() * K * s.V - Matrix(lambda.asDiagonal())).cwiseAbs().maxCoeff(),
            1e-11 * lambda.maxCoeff());
  EXPECT_EQ(s.omega.head(6), Vector::Zero(6));
  EXPECT_GT(s.omega(6), 0);
  EXPECT_TRUE(std::is_sorted(s.omega.begin(), s.omega.end()));
  // The first six columns span the rigid motions exactly.
  EXPECT_EQ(s.V.topLeftCorner(s.k(), 6).cwiseAbs().maxCoeff(), 0);
  const Matrix R = reduced_rigid_modes(s, s.rigid_body.center);
  const Matrix back = s.V.leftCols(6) * (s.V.leftCols(6).transpose() * (M * R));
  EXPECT_LT(relative(back, R), 1e-13);
  check(s, "test");
}

// A square face, whose bending modes come in pairs.
TEST(Reduce, LowestModesAloneAreThoseOfTheDiagonalForm) {
  const Mesh mesh = box_mesh({{3, 12, 12}, {1.5, 4, 4}, {0, 0, 0}, 0});
  ReduceSettings none;
  none.is_diagonal_read = false;
  const Superelement all = reduced(mesh, with_modes({"x_max"}, 20));
  const Superelement lowest = reduced(mesh, with_modes({"x_max"}, 20), MassKind::lumped, none);
  ASSERT_GT(all.n(), 500);
  EXPECT_TRUE(all.has_diagonal_form());
  EXPECT_FALSE(lowest.has_diagonal_form());
  EXPECT_EQ(lowest.V.size(), 0);
  EXPECT_EQ(all.K_cc, lowest.K_cc);
  const auto &a = *all.accuracy, &b = *lowest.accuracy;
  ASSERT_GT(a.frequency_hz.size(), 5);
  ASSERT_EQ(a.frequency_hz.size(), b.frequency_hz.size());
  EXPECT_LT((a.frequency_hz - b.frequency_hz).cwiseAbs().maxCoeff(), 1e-9 * a.frequency_hz(0));
  EXPECT_LT((a.eigenvalue_error - b.eigenvalue_error).cwiseAbs().maxCoeff(),
            1e-4 * a.eigenvalue_error.maxCoeff());
  EXPECT_EQ(all.conditioning->n_zero, 6);
  EXPECT_EQ(lowest.conditioning->n_zero, 6);
  EXPECT_NEAR(all.conditioning->lowest_omega, lowest.conditioning->lowest_omega,
              1e-9 * all.conditioning->lowest_omega);
  EXPECT_NEAR(all.conditioning->largest_omega, lowest.conditioning->largest_omega,
              1e-6 * all.conditioning->largest_omega);
}

TEST(Reduce, LowestModesAloneTellAMechanism) {
  const Mesh mesh = box_mesh({{3, 12, 12}, {1.5, 4, 4}, {0, 0, 0}, 0});
  Superelement s = reduced(mesh, with_modes({"x_max"}, 20));
  const std::vector<Index> part(s.node_ids.size(), 0);
  // Nothing resists w any more, and rigid motions are as free as before: K <- K - (K w) (K w)^T /
  // (w^T K w)
  const Vector w = Vector::Unit(s.c(), 7), Kw = s.K_cc * w;
  s.K_cc -= Kw * Kw.transpose() / w.dot(Kw);
  s.omega.resize(0);
  Superelement whole = s;
  add_lowest_modes(s, part, 20);
  add_diagonal_form(whole, part);
  EXPECT_EQ((whole.omega.array() == 0).count(), 7);
  EXPECT_EQ((s.omega.array() == 0).count(), 7);
}

TEST(Reduce, CutoffKeepsEveryModeBelowIt) {
  const Mesh mesh = skewed();
  const Superelement all = reduced(mesh, with_modes({"x_max"}, 40));
  const auto hz = [&](double lambda) { return std::sqrt(lambda) / (2 * M_PI); };
  ReductionOptions options = with_modes({"x_max"}, 0);
  options.modes.reset();
  options.cutoff_hz = 0.5 * (hz(all.eigenvalues(20)) + hz(all.eigenvalues(21)));
  EXPECT_EQ(reduced(mesh, options).k(), 21);
  options.cutoff_hz = 0.5 * hz(all.eigenvalues(0));
  EXPECT_EQ(reduced(mesh, options).k(), 0);
}

TEST(Reduce, ACubeLosesNoCopyOfItsMultipleModes) {
  // 6 x 6 x 6 elements held all around: 375 interior dofs in threefold and twofold families, found
  // by ARPACK.
  const Mesh mesh = box_mesh({{6, 6, 6}, {1, 1, 1}, {0, 0, 0}, 0});
  const Index k = 30;
  ReductionOptions options = with_modes({"surface"}, k);
  ReductionFigures figures;
  const Superelement of_basis = reduced(mesh, options, MassKind::lumped, {}, &figures);
  EXPECT_TRUE(figures.modes_proven);
  options.exact_modes = true;
  const Superelement s = reduced(mesh, options, MassKind::lumped, {}, &figures);
  EXPECT_TRUE(figures.modes_proven);
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  const Partition p = partition(model, interface_nodes(mesh, model, {"surface"}));
  const Vector dense = dense_eigenpairs(Matrix(p.K_II), Vector(p.M_II.diagonal()), k).lambda;
  EXPECT_LT((s.eigenvalues - dense).cwiseAbs().maxCoeff(), 1e-10 * dense(0));
  EXPECT_LT((of_basis.eigenvalues - dense).cwiseQuotient(dense).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Reduce, IdenticalPartsLoseNoCopyOfTheirModes) {
  // 24 equal blocks apart from each other: every frequency is 24 times there.
  const Mesh one = box_mesh({{2, 2, 3}, {1, 1, 2}, {0, 0, 0}, 0.05});
  const Index parts = 24, n = one.coordinates.rows(), elements = one.blocks[0].connectivity.rows();
  Mesh mesh = one;
  mesh.nodesets.clear();
  mesh.coordinates = one.coordinates.replicate(parts, 1);
  mesh.blocks[0].connectivity = one.blocks[0].connectivity.replicate(parts, 1);
  for (Index i = 1; i < parts; ++i) {
    mesh.coordinates.middleRows(i * n, n).col(0).array() += 3.0 * static_cast<double>(i);
    mesh.blocks[0].connectivity.middleRows(i * elements, elements).array() += i * n;
    for (const Index id : one.node_ids) mesh.node_ids.push_back(id + 1000 * i);
    for (const Index id : one.blocks[0].element_ids)
      mesh.blocks[0].element_ids.push_back(id + 1000 * i);
    for (std::size_t s = 0; s < one.sidesets.size(); ++s) {
      for (Side side : one.sidesets[s].sides) {
        side.element += i * elements;
        mesh.sidesets[s].sides.push_back(side);
      }
    }
  }
  ReduceSettings no_diagonal;
  no_diagonal.diagonal_limit = 0;
  const Index k = 60;
  const Superelement s = reduced(mesh, with_modes({"z_min"}, k), MassKind::lumped, no_diagonal);
  const Superelement part = reduced(one, with_modes({"z_min"}, 3), MassKind::lumped, no_diagonal);
  for (Index j = 0; j < k; ++j)
    EXPECT_NEAR(s.eigenvalues(j), part.eigenvalues(j / parts), 1e-9 * part.eigenvalues(0)) << j;
}

TEST(Reduce, ParticipationPicksTheModesThatTheInterfaceDrives) {
  const Mesh mesh = skewed();
  ReductionOptions options = with_modes({"x_max"}, 10);
  const Superelement lowest = reduced(mesh, options);
  options.pick = Pick::participation;
  const Superelement picked = reduced(mesh, options);
  ASSERT_EQ(picked.k(), 10);
  EXPECT_GT(picked.M_kc.squaredNorm(), lowest.M_kc.squaredNorm());
  EXPECT_TRUE(std::is_sorted(picked.eigenvalues.begin(), picked.eigenvalues.end()));
  options.pick = Pick::frequency;
  options.modes = 180;
  const Superelement all = reduced(mesh, options);
  // No mode left out among the candidates has more participation than one that was kept.
  const std::vector<Index> kept = modes_by_participation(all.M_kc, 10);
  const Vector participation = all.M_kc.rowwise().squaredNorm();
  double least = INFINITY;
  for (const Index j : kept) least = std::min(least, participation(j));
  EXPECT_EQ((participation.array() >= least).count(), 10);
}

// Of a mesh for which the sparse solver is the one.
TEST(Reduce, ParticipationPicksOfSparseCandidates) {
  const Mesh mesh = box_mesh({{6, 5, 16}, {0.9, 0.7, 2.3}, {0, 0, 0}, 0.05});
  ReductionOptions options = with_modes({"x_max"}, 10);
  options.pick = Pick::participation;
  ReductionFigures figures;
  const Superelement of_basis = reduced(mesh, options, MassKind::lumped, {}, &figures);
  ASSERT_EQ(figures.mode_method, "block lanczos");
  EXPECT_TRUE(figures.modes_proven);
  options.exact_modes = true;
  const Superelement picked = reduced(mesh, options);
  options.pick = Pick::frequency;
  options.modes = 200;
  const Superelement all = reduced(mesh, options);
  const std::vector<Index> kept = modes_by_participation(all.M_kc, 10);
  EXPECT_GT(kept.back(), 9);  // not the lowest ten
  for (Index j = 0; j < 10; ++j) {
    const double lambda = all.eigenvalues(kept[j]);
    EXPECT_NEAR(picked.eigenvalues(j), lambda, 1e-11 * lambda) << j;
    EXPECT_NEAR(of_basis.eigenvalues(j), lambda, 1e-6 * lambda) << j;
  }
  EXPECT_LT(relative(picked.M_kc, Matrix(all.M_kc(kept, Eigen::all))), 1e-7);
}

TEST(Reduce, NoModesIsStaticCondensation) {
  const Mesh mesh = skewed();
  const Superelement s = reduced(mesh, with_modes({"z_max"}, 0));
  EXPECT_EQ(s.k(), 0);
  // K_cc is the Schur complement: a load on the interface gives the full model's displacement
  // there.
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  const Partition p = partition(model, interface_nodes(mesh, model, {"z_max"}));
  const Matrix K_cc =
      Matrix(p.K_CC) - Matrix(p.K_IC).transpose() * Ldlt(Matrix(p.K_II)).solve(Matrix(p.K_IC));
  EXPECT_LT(relative(s.K_cc, K_cc), 1e-12);
  EXPECT_TRUE(s.has_diagonal_form());
}

TEST(Reduce, AllNodesOnTheInterface) {
  const Mesh mesh = box_mesh({{1, 1, 3}, {1, 1, 3}, {0, 0, 0}, 0.05});
  const Superelement s = reduced(mesh, with_modes({"surface"}, 0));
  const FiniteElementModel model = assemble(mesh, properties(mesh, soft), MassKind::lumped);
  EXPECT_EQ(s.K_cc, Matrix(model.K));
  EXPECT_EQ(s.M_cc, Matrix(model.M));
  EXPECT_EQ(s.surfaces.size(), 7u);
  EXPECT_SAYS(message_of(mesh, with_modes({"surface"}, 1)), "only 0");
}

// As one domain of a small mesh may be: nothing to bring back, and a file that can be written all
// the same.
TEST(Reduce, AllNodesOnTheInterfaceWithRecovery) {
  ReductionOptions options = with_modes({"x_min", "x_max"}, 0);
  options.recovery = true;
  const Superelement s = reduced(box_mesh({{1, 2, 2}, {1, 1, 1}, {0, 0, 0}, 0}), options);
  ASSERT_EQ(s.recovery.size(), 1u);
  EXPECT_EQ(s.recovery[0].Psi.cols(), s.c());
  EXPECT_NO_THROW(check(s, "s"));
}

TEST(Reduce, KeepsTheSetsInsideTheInterface) {
  const Mesh mesh = skewed();
  const Superelement s = reduced(mesh, with_modes({"surface"}, 2));
  ASSERT_EQ(s.surfaces.size(), 7u);
  EXPECT_EQ(s.surfaces[1].name, "x_max");
  EXPECT_EQ(s.nodesets.size(), 2u);
  const Superelement face = reduced(mesh, with_modes({"x_min"}, 2));
  ASSERT_EQ(face.surfaces.size(), 1u);
  EXPECT_EQ(face.surfaces[0].name, "x_min");
  EXPECT_EQ(face.nodesets.size(), 2u);  // corner and edge lie on x_min
  // Faces point outwards: normal against the direction to the centre.
  for (Index f = 0; f < face.surfaces[0].n_faces(); ++f) {
    const auto at = [&](Index a) {
      return Vector3(face.coordinates.row(face.surfaces[0].faces(f, a)));
    };
    const Vector3 normal = (at(2) - at(0)).cross(at(3) - at(1));
    EXPECT_GT(normal.dot(at(0) - face.rigid_body.center), 0);
  }
}

TEST(Reduce, TwoPartsHaveTwelveRigidModes) {
  const Mesh mesh = both(box_mesh({{2, 2, 3}, {2, 2, 3}, {0, 0, 0}, 0}),
                         box_mesh({{2, 3, 2}, {2, 3, 2}, {5, 0, 0}, 0}));
  const Superelement s = reduced(mesh, with_modes({"x_max", "x_min_2"}, 6));
  EXPECT_EQ(s.omega.head(12), Vector::Zero(12));
  EXPECT_GT(s.omega(12), 1e-3 * s.omega.maxCoeff());
  const Matrix M = reduced_mass(s);
  EXPECT_LT((s.V.transpose() * M * s.V - Matrix::Identity(s.n(), s.n())).cwiseAbs().maxCoeff(),
            1e-12);
}

TEST(Reduce, RefusesAnInteriorThatCanMoveFreely) {
  const Mesh mesh = skewed();
  EXPECT_SAYS(message_of(mesh, with_modes({"corner"}, 1)), "has 1 node on the part");
  const Mesh straight = box_mesh({});
  EXPECT_SAYS(message_of(straight, with_modes({"edge"}, 1)), "not three that are off one line");
  const Mesh two = both(mesh, box_mesh({{2, 2, 2}, {1, 1, 1}, {50, 0, 0}, 0}));
  EXPECT_SAYS(message_of(two, with_modes({"x_max"}, 1)), "node id 100007",
              "not connected to the interface");
}

TEST(Reduce, RefusesAHingeInTheInterior) {
  // A second block that hangs on an edge of the first: it can swing about it.
  Mesh mesh = both(box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0}),
                   box_mesh({{2, 2, 2}, {2, 2, 2}, {2, 2, 0}, 0}));
  const Index n = 27;
  for (Index& node : mesh.blocks[1].connectivity.reshaped()) {
    const Vector3 x = mesh.coordinates.row(node);
    if (x(0) == 2 && x(1) == 2) node = 2 + 3 * (2 + 3 * static_cast<Index>(x(2)));
  }
  ASSERT_LT(mesh.blocks[1].connectivity.minCoeff(), n);
  EXPECT_SAYS(message_of(mesh, with_modes({"x_min"}, 3)), "singular at node id ");
}

TEST(Reduce, RefusesWrongOptions) {
  const Mesh mesh = skewed();
  EXPECT_SAYS(message_of(mesh, with_modes({"nonsense"}, 1)), "x_max");
  EXPECT_SAYS(message_of(mesh, with_modes({}, 1)), "no interface");
  EXPECT_SAYS(message_of(mesh, with_modes({"x_max"}, 100000)), "at most that many");
  ReductionOptions options = with_modes({"x_max"}, 3);
  options.cutoff_hz = 1;
  EXPECT_SAYS(message_of(mesh, options), "exactly one");
  options.modes.reset();
  options.pick = Pick::participation;
  EXPECT_SAYS(message_of(mesh, options), "participation");
}

TEST(Reduce, TwoRunsWriteTheSameBytes) {
  const Mesh mesh = skewed();
  std::string bytes[2];
  for (auto& content : bytes) {
    const auto file = std::filesystem::temp_directory_path() /
                      ("cbr-same-bytes-" + std::to_string(::getpid()) + ".cbr.h5");
    write_superelement(reduced(mesh, with_modes({"x_max"}, 12)), file);
    std::ifstream stream(file, std::ios::binary);
    content.assign(std::istreambuf_iterator<char>(stream), {});
    std::filesystem::remove(file);
  }
  EXPECT_FALSE(bytes[0].empty());
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

}  // namespace
}  // namespace cbr::test::reduce_test

// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement as other makers write them: nodes inside are clamped, so that it has no rigid
// motions.
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <cmath>
#include <memory>
#include <numbers>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"
#include "common/superelement/superelement_check.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::held_inside_test {
namespace {

// x_max the interface, eight modes, x = 0 clamped.
Superelement clamped() {
  const Mesh mesh = test::block_mesh(
      {{4, 3, 2}, Vector3(1, 0.8, 0.7), [](const Vector3& x) -> Vector3 { return x; }});
  const std::vector<BlockProperties> properties = {{{100, 0.3, 1}, HexFormulation::incompatible}};
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 8;
  Report report("test", Verbosity::quiet);
  Superelement s = reduce(mesh, properties, MassKind::consistent, options, {}, report);
  const FiniteElementModel model = assemble(mesh, properties, MassKind::consistent);
  const Partition p = partition(model, interface_nodes(mesh, model, {"x_max"}));
  std::vector<Index> I;
  for (std::size_t i = 0; i < p.interior_nodes.size(); ++i)
    if (mesh.coordinates(model.nodes[p.interior_nodes[i]], 0) > 1e-6)
      for (Index d = 0; d < 3; ++d) I.push_back(3 * static_cast<Index>(i) + d);
  const Matrix K_II = Matrix(p.K_II)(I, I), M_II = Matrix(p.M_II)(I, I),
               K_IC = Matrix(p.K_IC)(I, Eigen::all), M_IC = Matrix(p.M_IC)(I, Eigen::all);
  const Matrix Psi = -Cholesky(K_II).solve(K_IC), Y = M_IC + M_II * Psi;
  const Eigenpairs modes = dense_eigenpairs(K_II, M_II, 8);
  s.K_cc = Matrix(p.K_CC) + K_IC.transpose() * Psi;
  s.M_cc = Matrix(p.M_CC) + Psi.transpose() * Y + M_IC.transpose() * Psi;
  s.K_cc = (0.5 * (s.K_cc + s.K_cc.transpose())).eval();
  s.M_cc = (0.5 * (s.M_cc + s.M_cc.transpose())).eval();
  s.M_kc = modes.Phi.transpose() * Y;
  s.eigenvalues = modes.lambda;
  s.omega.resize(0);
  s.V.resize(0, 0);
  s.accuracy.reset();
  s.conditioning.reset();
  return s;
}

SymmetricEigen reference(const Superelement& s) {
  return generalized_eigen(reduced_stiffness(s), reduced_mass(s));
}

TEST(HeldInside, IsReadAndHasNoRigidMotions) {
  Superelement s = clamped();
  EXPECT_TRUE(is_held_inside(s));
  EXPECT_EQ(resisted_rigid_motions(s).rows(), 6);
  check(s, "s.h5");
  check_rigid_motions(s, "s.h5");  // throws if it asks for the rigid motions that there are not
  const auto dense = reference(s);
  const Vector omega = dense.values.cwiseSqrt();
  const Matrix E =
      dense.vectors.transpose() * reduced_mass(s) * reduced_rigid_modes(s, s.rigid_body.center);
  const ModalForm form = free_modal_form(s, "s.h5");
  EXPECT_EQ(form.n_rigid, 0);
  EXPECT_LT((form.omega - omega).cwiseQuotient(omega).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((form.E.transpose() * form.E - E.transpose() * E).norm(), 1e-9 * E.squaredNorm());
  // The maker's own diagonal form, with and without the matrices beside it
  for (const bool with_matrices : {true, false}) {
    Superelement stored = clamped();
    stored.omega = omega;
    stored.V = dense.vectors;
    if (!with_matrices) {
      stored.K_cc.resize(0, 0);
      stored.M_cc.resize(0, 0);
      stored.M_kc.resize(0, 0);
    }
    EXPECT_TRUE(is_held_inside(stored));
    check_rigid_motions(stored, "s.h5");
    const ModalForm of_file = free_modal_form(stored, "s.h5");
    EXPECT_EQ(of_file.n_rigid, 0);
    EXPECT_LT((of_file.E - E).norm(), 1e-9 * E.norm());
  }
}

// All of it starts with one velocity: half a period of the lowest mode later, against all modes of
// the dense matrices.
TEST(HeldInside, SwingsAsItsMatricesSay) {
  const auto s = std::make_shared<Superelement>(clamped());
  const auto dense = reference(*s);
  const Vector omega = dense.values.cwiseSqrt();
  Placement placement;
  placement.velocity = Vector3(0.3, -1, 0.5);
  Vector start = Vector::Zero(s->n());
  for (Index i = 0; i < s->c(); ++i) start(s->k() + i) = placement.velocity[s->dof_component[i]];
  const Vector rates = dense.vectors.transpose() * reduced_mass(*s) * start;
  Superelement copy = *s;
  const auto form = std::make_shared<ModalForm>(free_modal_form(copy, "s.h5"));
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference, Scheme::newmark}) {
    ModalBody body("body", s, form, placement, scheme);
    const double end = std::numbers::pi / omega(0);
    const auto steps = static_cast<int>(std::ceil(end * omega(omega.size() - 1) / 0.05));
    const double h = end / steps;
    std::vector<Index> nodes(body.n_nodes());
    for (Index i = 0; i < body.n_nodes(); ++i) nodes[i] = i;
    const Index set = body.track(nodes);
    double difference = 0, size = 0;
    for (int step = 0; step < steps; ++step) {
      body.predict(step * h, h);
      body.accept();
      if (step % 10 != 9) continue;
      const double t = (step + 1) * h;
      const Vector q =
          dense.vectors *
          rates.cwiseProduct(omega.unaryExpr([&](double w) { return std::sin(w * t) / w; }));
      Points x;
      body.positions(set, x);
      const Points u = x - body.reference_positions();
      for (Index i = 0; i < s->c(); ++i) {
        difference =
            std::max(difference, std::abs(u(s->dof_node[i], s->dof_component[i]) - q(s->k() + i)));
        size = std::max(size, std::abs(q(s->k() + i)));
      }
    }
    EXPECT_LT(difference, (scheme == Scheme::exact ? 1e-9 : 5e-3) * size)
        << static_cast<int>(scheme);
    EXPECT_GT(size, 0.1 / omega(0));
  }
}

// One node held beside: a free body could still turn about it.
TEST(HeldInside, MoreDirectionsHeldLeaveNoRigidMotions) {
  const Superelement s = clamped();
  const std::vector<HeldDirection> held = {
      {0, Vector3::UnitX()}, {0, Vector3::UnitY()}, {0, Vector3::UnitZ()}};
  std::vector<Index> left;
  for (Index i = 0; i < s.n(); ++i)
    if (i < s.k() || s.dof_node[i - s.k()] != 0) left.push_back(i);
  const Matrix K = reduced_stiffness(s)(left, left), M = reduced_mass(s)(left, left);
  const Vector dense = generalized_eigen(K, M).values;
  const Vector omega = dense.cwiseSqrt();
  const ModalForm form = held_modal_form(s, held, "s.h5");
  EXPECT_EQ(form.n_rigid, 0);
  ASSERT_EQ(form.omega.size(), omega.size());
  EXPECT_LT((form.omega - omega).cwiseQuotient(omega).cwiseAbs().maxCoeff(), 1e-9);
}

// Coordinates that are not those of the matrices are resisted in rotation, and still refused.
TEST(HeldInside, IsNotWhatWrongCoordinatesMake) {
  const Mesh mesh = test::block_mesh(
      {{4, 3, 2}, Vector3(1, 0.8, 0.7), [](const Vector3& x) -> Vector3 { return x; }});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 8;
  Report report("test", Verbosity::quiet);
  Superelement s = reduce(mesh, {{{100, 0.3, 1}, HexFormulation::incompatible}}, MassKind::lumped,
                          options, {}, report);
  EXPECT_FALSE(is_held_inside(s));
  EXPECT_EQ(resisted_rigid_motions(s).rows(), 0);
  s.coordinates.col(1) *= 1.3;
  EXPECT_FALSE(is_held_inside(s));
  EXPECT_GT(resisted_rigid_motions(s).rows(), 0);
  EXPECT_THROW(check_rigid_motions(s, "s.h5"), InputError);
}

// A block from y = -0.5, cut at y = 0: its half, whose y_min is the plane of symmetry.
Mesh part_of_block(bool is_half) {
  const double y = is_half ? 0 : -0.5;
  return test::block_mesh({{4, is_half ? 2 : 4, 3},
                           Vector3(1, is_half ? 0.5 : 1, 0.6),
                           [y](const Vector3& x) -> Vector3 { return x + Vector3(0, y, 0); }});
}

const std::vector<FixedSet> plane = {{"y_min", {false, true, false}, {}}};

// Squared frequencies of the whole block's motions that are symmetric to y = 0, all modes.
Vector symmetric_eigenvalues(MassKind mass) {
  const Mesh mesh = part_of_block(false);
  const FiniteElementModel model =
      assemble(mesh, {{{100, 0.3, 1}, HexFormulation::incompatible}}, mass);
  const Points x = mesh.coordinates(model.nodes, Eigen::all);
  Matrix G = Matrix::Zero(3 * x.rows(), 3 * x.rows());
  Index column = 0;
  for (Index i = 0; i < x.rows(); ++i) {
    if (x(i, 1) < -1e-9) continue;
    Index twin = 0;
    (x.rowwise() - Eigen::RowVector3d(x(i, 0), -x(i, 1), x(i, 2)))
        .rowwise()
        .squaredNorm()
        .minCoeff(&twin);
    for (Index d = 0; d < 3; ++d) {
      if (d == 1 && twin == i) continue;
      G(3 * i + d, column) = 1;
      G(3 * twin + d, column++) = d == 1 ? -1 : 1;
    }
  }
  G.conservativeResize(Eigen::NoChange, column);
  return generalized_eigen(G.transpose() * model.K * G, G.transpose() * model.M * G).values;
}

Superelement half_block(ReductionOptions options, MassKind mass = MassKind::lumped) {
  if (options.interface_sets.empty()) options.interface_sets = {"x_max"};
  Report report("test", Verbosity::quiet);
  return reduce(part_of_block(true), {{{100, 0.3, 1}, HexFormulation::incompatible}}, mass, options,
                {}, report);
}

double largest_error(const Vector& found, const Vector& wanted) {
  return (found - wanted).cwiseQuotient(wanted).cwiseAbs().maxCoeff();
}

// A plane of symmetry leaves two translations and a rotation.
TEST(FixedDofs, GiveTheSymmetricFrequenciesOfTheWhole) {
  constexpr Index n_rigid = 3, n = 12;
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    const Vector wanted = symmetric_eigenvalues(mass).segment(n_rigid, n);
    ReductionOptions all;
    all.fixed = plane;
    all.cutoff_hz = 1e6;
    const Superelement s = half_block(all, mass);
    EXPECT_EQ(s.c(), 4 * 3 * 3 - 4) << "the interface without y of its four nodes on the plane";
    EXPECT_EQ(s.fixed.resisted.rows(), 3);
    EXPECT_EQ((s.omega.array() == 0).count(), n_rigid);
    EXPECT_LT(largest_error(s.omega.segment(n_rigid, n).cwiseAbs2(), wanted), 1e-8);
    ReductionOptions massless;
    massless.fixed = plane;
    massless.basis = Basis::massless;
    massless.modes = n;
    const Superelement m = half_block(massless, mass);
    EXPECT_EQ((m.eigenvalues.array() == 0).count(), n_rigid);
    EXPECT_LT(largest_error(m.eigenvalues.segment(n_rigid, n), wanted), 1e-8);
    ReductionOptions shapes = all;
    shapes.basis = Basis::characteristic;
    shapes.characteristic.modes = 20;
    const Superelement c = half_block(shapes, mass);
    EXPECT_EQ((c.eigenvalues.array() == 0).count(), n_rigid);
    EXPECT_LT(largest_error(c.eigenvalues.segment(n_rigid, 6), wanted.head(6)), 5e-3);
  }
}

// E^T E of all modes is the mass of the rigid motions: of those that are left, and with all modes
// of the others as far as fixed nodes carry none.
TEST(FixedDofs, KeepTheMomentumOfRigidMotions) {
  ReductionOptions options;
  options.fixed = plane;
  options.cutoff_hz = 1e6;
  for (const Basis basis : {Basis::craig_bampton, Basis::characteristic}) {
    options.basis = basis;
    Superelement s = half_block(options, MassKind::consistent);
    const ModalForm form =
        s.is_characteristic() ? free_characteristic_form(s, "s.h5") : free_modal_form(s, "s.h5");
    EXPECT_EQ(form.n_rigid, 3);
    const Matrix6 mass = form.E.transpose() * form.E;
    for (const Index axis : {0, 2}) EXPECT_NEAR(mass(axis, axis), 0.3, 1e-9);
    EXPECT_NEAR(mass(4, 4), s.rigid_body.inertia(1, 1), 1e-9);
  }
}

struct HalfRun {
  std::string part = "half", kind = "superelement";
  std::string basis = "basis: craig-bampton, cutoff_hz: 1.0e6, recovery: true";
  std::string interface = "[x_min, x_max]", fixed = "{nodes: y_min, fix: [y]}";
  std::string placed = "position: [0.001, 0, 0], velocity: [-0.5, 0, 0.2]";
  std::string more, time = "end: 0.3, step: 5.0e-4", output;
};

// Halves of a block, or a whole one, that move as the scene says.
class Halves {
 public:
  Halves() {
    folder_.add("half.exo", part_of_block(true));
    folder_.add("whole.exo", part_of_block(false));
  }
  test::Ran run(const HalfRun& of) {
    std::string fixed = of.fixed.empty() ? "" : ", fixed: [" + of.fixed + "]";
    return folder_.run(
        "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
        "components: {b: {mesh: " +
        of.part + ".exo, material: m, mass: lumped, reduction: {" + of.basis +
        ", interface: " + of.interface + fixed + ", superelement: s" + std::to_string(++count_) +
        ".h5}}}\ninstances: {a: {component: b, as: " + of.kind + ", " + of.placed + "}}\n" +
        of.more + "\ntime: {" + of.time + "}\noutput: {every: 0.02, history: [a.x_max]" +
        of.output + "}\n");
  }

 private:
  test::SceneFolder folder_;
  int count_ = 0;
};

const std::string fall_on_wall =
    "walls: {floor: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\n"
    "contact: [{between: [a.x_min, floor]}]\nloads: [{gravity: [-0.2, 0, 0.1]}]";

Vector values_of(const Series3& series) {
  return Eigen::Map<const Vector>(series.values.data(), static_cast<Index>(series.values.size()));
}

// The cut face strikes a wall, under gravity.
TEST(FixedDofs, HalfABlockMovesAsTheWhole) {
  Halves halves;
  const auto compare = [&](HalfRun half, double tolerance) {
    half.more = fall_on_wall;
    HalfRun whole = half;
    whole.part = "whole";
    whole.fixed = "";
    const test::Ran a = halves.run(half), b = halves.run(whole);
    const std::string what = half.kind + " " + half.basis + " " + half.time;
    const Vector x = values_of(a.result.bodies[0].center_of_mass),
                 of_whole = values_of(b.result.bodies[0].center_of_mass),
                 p = values_of(a.result.bodies[0].momentum),
                 of_two = values_of(b.result.bodies[0].momentum);
    EXPECT_GT(of_two(of_two.size() - 3), 0.01) << what << ": it has rebounded";
    for (const Index axis : {0, 2}) {
      const auto rows = Eigen::seq(axis, Eigen::last, 3);
      EXPECT_LT((x(rows) - of_whole(rows)).cwiseAbs().maxCoeff(), tolerance) << what;
      EXPECT_LT((2 * p(rows) - of_two(rows)).cwiseAbs().maxCoeff(), tolerance) << what;
    }
  };
  compare({}, 1e-9);
  compare({.time = "end: 0.3, step: 5.0e-4, integrator: newmark"}, 1e-9);
  compare({.time = "end: 0.3, step: 2.0e-4, integrator: central-difference"}, 1e-9);
  compare({.kind = "mesh", .time = "end: 0.3, step: 2.0e-4"}, 1e-9);
  compare({.kind = "mesh", .time = "end: 0.3, step: 5.0e-4, integrator: newmark"}, 1e-9);
  compare({.basis = "basis: characteristic, modes: 80"}, 0.02);  // of its shapes
}

// A cantilever of half a block under gravity, and a pressure at its end: of the clamp's nodes none
// is on the interface, and the edge of the end face is on the plane.
TEST(FixedDofs, HalfACantileverBendsAsItsMesh) {
  Halves halves;
  HalfRun of{.interface = "[x_max]",
             .fixed = "{nodes: y_min, fix: [y]}, {nodes: x_min, fix: [x, y, z]}",
             .placed = "position: [0, 0, 0]"};
  of.more = "loads: [{gravity: [0, 0, -0.5]}, {instance: a, surface: x_max, pressure: 0.2}]";
  of.time = "static: true, end: 1, step: 1";
  of.output = ", stress: [a.y_min]";
  HalfRun mesh = of;
  mesh.kind = "mesh";
  const test::Ran a = halves.run(of), b = halves.run(mesh);
  const Vector x = values_of(a.result.monitors[0].mean_position),
               wanted = values_of(b.result.monitors[0].mean_position);
  EXPECT_GT((wanted.tail(3) - wanted.head(3)).norm(), 1e-3) << "it bends";
  EXPECT_LT((x - wanted).cwiseAbs().maxCoeff(), 1e-9);
  const Vector3 reaction = values_of(a.result.bodies[0].reaction).tail(3);
  EXPECT_NEAR(reaction[2], 0.3 * 0.5, 1e-9);
  EXPECT_NEAR(reaction[0], 0.2 * 0.3, 1e-9);
  EXPECT_LT((values_of(b.result.bodies[0].reaction).tail(3) - reaction).norm(), 1e-9);
  // Loads of the interface alone: exact with few modes, in every basis
  HalfRun few = of, few_mesh = mesh;
  few.more = few_mesh.more = "loads: [{instance: a, surface: x_max, traction: [0.1, 0, 0.2]}]";
  few.output = few_mesh.output = "";
  const Vector exact = values_of(halves.run(few_mesh).result.monitors[0].mean_position);
  for (const char* basis :
       {"modes: 3", "basis: massless, modes: 5",
        "basis: massless, modes: 5, massless_modes: tapered", "basis: characteristic, modes: 10"}) {
    few.basis = basis;
    const Vector found = values_of(halves.run(few).result.monitors[0].mean_position);
    EXPECT_LT((found - exact).cwiseAbs().maxCoeff(), 1e-9) << basis;
  }
  // A turned instance bends in its own axes, at any angle
  HalfRun turned = of;
  turned.placed = "position: [0, 0, 0], rotation: [0, 30, 0]";
  const Eigen::AngleAxisd turn(std::numbers::pi / 6, Vector3::UnitY());
  const Vector3 g = turn * Vector3(0, 0, -0.5);
  turned.more =
      "loads: [{gravity: " + test::text(g) + "}, {instance: a, surface: x_max, pressure: 0.2}]";
  for (const char* kind : {"superelement", "mesh"}) {
    turned.kind = kind;
    const test::Ran c = halves.run(turned);
    const Vector3 end = values_of(c.result.monitors[0].mean_position).tail(3);
    EXPECT_LT((end - turn * Vector3(wanted.tail(3))).norm(), 1e-9) << kind;
  }
}

TEST(FixedDofs, BadInputIsRefusedWithItsLine) {
  Halves halves;
  const auto refusal = [&](const HalfRun& of) { return test::refusal_of([&] { halves.run(of); }); };
  const auto expect = [&](const HalfRun& of, const std::string& words) {
    EXPECT_SAYS(refusal(of), words, ".yaml:");
  };
  expect({.fixed = "{nodes: y_mim, fix: [y]}"}, "'y_mim', did you mean 'y_min'?");
  expect({.fixed = "{nodes: y_min, fix: [w]}"}, "unknown value 'w'");
  expect({.fixed = "{nodes: y_min, fix: []}"}, "is empty, expected some of x, y, z");
  expect({.fixed = "{nodes: y_min, fix: y}, {nodes: y_min, fix: z}"}, "is fixed on line 2 already");
  expect({.interface = "[y_min]", .fixed = "{nodes: y_min, fix: [x, y, z]}"},
         "leaves no dof of the interface (y_min)");
  expect({.basis = "modes: 3, domains: 2"}, "is not available with domains above 1");
  expect({.placed = "velocity: [0, 0.1, 0]"},
         "motion along a fixed direction (found velocity) does not go with reduction.fixed");
  expect({.placed = "rotation: [90, 0, 0], velocity: [0, 0, 1]"}, "(found velocity)");
  expect({.kind = "mesh", .placed = "velocity: [0, 0.1, 0]"}, "(found velocity)");
  expect({.more = "boundary: [{instance: a, nodes: x_max, fix: y, velocity: [0, 1, 0]}]"},
         "(found boundary of 'x_max')");
  expect({.placed = "angular_velocity: [0, 1, 0]"}, "angular_velocity does not go with");
}

// Nodes that the scene holds along the fixed axis, too.
TEST(FixedDofs, GoWithSupportsOnTheSameNodes) {
  Halves halves;
  HalfRun of;
  of.more =
      "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}]\nloads: [{gravity: [0, 0, -1]}]";
  of.placed = "position: [0, 0, 0]";
  HalfRun mesh = of, cut = of;
  mesh.kind = cut.kind = "mesh";
  cut.fixed = "";
  cut.more =
      "boundary: [{instance: a, nodes: x_min, fix: [x, y, z]}, {instance: a, nodes: y_min, "
      "fix: y}]\nloads: [{gravity: [0, 0, -1]}]";
  for (const char* time : {"static: true, end: 1, step: 1", "end: 0.2, step: 1.0e-4"}) {
    of.time = mesh.time = cut.time = time;
    const Vector wanted = values_of(halves.run(cut).result.monitors[0].mean_position),
                 x = values_of(halves.run(of).result.monitors[0].mean_position);
    EXPECT_LT((values_of(halves.run(mesh).result.monitors[0].mean_position) - wanted).norm(),
              1e-12);
    EXPECT_LT((x - wanted).norm(), of.time.starts_with("static") ? 1e-9 : 1e-4) << time;
  }
}

}  // namespace
}  // namespace cbr::held_inside_test

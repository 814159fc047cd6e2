// SPDX-License-Identifier: GPL-3.0-or-later
// Where the energy of an impact goes (docs/theory.md, (44)): a block meets a wall, as a full mesh
// and as superelements. What the mesh's motion carries just after the contact is split into what a
// basis holds and what it does not: [u_I; u_C] = T q + rest, T = [Phi, Psi; 0, I], with T^T K rest
// = 0 for strains and T^T M rest = 0 for velocities, so that the energies of both parts add up.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/linalg/dense.hpp"
#include "common/superelement/superelement.hpp"
#include "dynamics/output/summary/summary.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::basis_energy_test {
namespace {

using test::Ran;
using test::SceneFolder;

constexpr double length = 2, speed = 1, separated = 0.5;  // contact lasts 0.42

Mesh block() { return test::block_mesh({{16, 5, 4}, Vector3(length, 1, 0.75)}); }

std::string scene(const std::string& as, Index modes) {
  return "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
         "components: {c: {mesh: block.exo, material: m, reduction: {interface: [x_min], recovery: "
         "true, pick: participation, modes: " +
         std::to_string(modes) + ", superelement: k" + std::to_string(modes) +
         ".cbr.h5}}}\ninstances: {b: {component: c, as: " + as +
         ", position: [0.01, 0, 0], velocity: [-1, 0, 0]}}\nwalls: {w: {plane: {point: [0, 0, 0], "
         "normal: [1, 0, 0]}}}\n"
         "contact: [{between: [b.x_min, w]}]\ntime: {end: " +
         test::text(separated) + "}\noutput: {every: 0.05}\n";
}

struct Motion {
  Points u, v;  // in the order of the mesh's nodes
};

// Energies of the parts of a motion that a superelement holds.
struct Held {
  double strain = 0, kinetic = 0;
};

Held held(const Superelement& s, const Vector& mass, const Motion& motion) {
  const Superelement::Recovery& inner = s.recovery[0];
  const auto rows = [](const std::vector<Index>& ids, const Points& x) {
    Vector of(3 * static_cast<Index>(ids.size()));
    for (std::size_t i = 0; i < ids.size(); ++i)
      of.segment<3>(3 * static_cast<Index>(i)) = x.row(ids[i] - 1).transpose();
    return of;
  };
  Points m(mass.size(), 3);
  m.colwise() = mass;
  const Vector m_I = rows(inner.node_ids, m), m_C = rows(s.node_ids, m);
  const Vector u_I = rows(inner.node_ids, motion.u), u_C = rows(s.node_ids, motion.u),
               v_I = rows(inner.node_ids, motion.v), v_C = rows(s.node_ids, motion.v);
  // K: q_c = u_C, and Phi^T K_II (u_I - Psi u_C) = Lambda q_k, with K_II Phi = M_II Phi Lambda (k)
  const Vector q_k = inner.Phi.transpose() * m_I.cwiseProduct(u_I - inner.Psi * u_C);
  // M: M^ q' = T^T M v   (k + c)
  Vector p(s.n());
  p << inner.Phi.transpose() * m_I.cwiseProduct(v_I),
      m_C.cwiseProduct(v_C) + inner.Psi.transpose() * m_I.cwiseProduct(v_I);
  return {0.5 * (s.eigenvalues.dot(q_k.cwiseAbs2()) + u_C.dot(s.K_cc * u_C)),
          0.5 * p.dot(Cholesky(reduced_mass(s)).solve(p))};
}

TEST(BasisEnergy, WhatImpulsesLoseIsWhatTheBasisCannotHold) {
  SceneFolder folder;
  const Mesh mesh = block();
  folder.add("block.exo", mesh);
  const Ran full = folder.run(scene("mesh", 1));
  Motion motion;
  full.built.simulation.bodies[0]->displacements(motion.u, motion.v);
  ASSERT_EQ(motion.u.rows(), mesh.coordinates.rows());
  ASSERT_EQ(full.result.active.back(), 0);
  const FiniteElementModel model = assemble(mesh, {{{100, 0.3, 1}}}, MassKind::lumped);
  const Vector mass = Vector::NullaryExpr(mesh.coordinates.rows(),
                                          [&](Index i) { return model.M.coeff(3 * i, 3 * i); });
  const double start = 0.5 * 0.75 * length * speed * speed;
  double last = 1;
  for (const Index modes : {5, 20, 60}) {
    const Ran reduced = folder.run(scene("superelement", modes));
    ASSERT_EQ(reduced.result.active.back(), 0);
    const Superelement s =
        read_superelement(folder.folder() / ("k" + std::to_string(modes) + ".cbr.h5"));
    const Held in = held(s, mass, motion);
    const double lost = 1 - reduced.result.total.back() / start,
                 missing = 1 - (in.strain + in.kinetic) / start;
    std::printf(
        "%2ld modes: the run lost %.4f of its energy; of the mesh's motion %.4f is not in the "
        "basis; rho_res %.4f\n",
        long(modes), lost, missing, residual_mass_share(s)[0]);
    const auto outside = energy_outside_basis(reduced.built, reduced.result);
    ASSERT_TRUE(outside && outside->has_modes && !outside->has_others);
    EXPECT_NEAR(outside->energy / outside->scale, lost, 1e-12);
    EXPECT_EQ(outside->friction, 0);
    EXPECT_NEAR(lost, missing, 0.2 * missing);
    EXPECT_LT(missing, 0.9 * last);
    // the mesh cannot hold all either: the mass of its face stops
    EXPECT_GT(missing, 1 - full.result.total.back() / start);
    last = missing;
  }
}

// Blocks that meet off their common centre of mass's rest: the share is of what a contact can take,
// and friction's is apart.
TEST(BasisEnergy, IsToldApartFromFrictionAndCommonMotion) {
  const auto meet = [](const std::string& as, const std::string& reduction,
                       const std::string& contact) {
    SceneFolder folder;
    folder.add("block.exo", test::block_mesh({{6, 3, 3}, Vector3::Ones()}));
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
        "components: {c: {mesh: block.exo, material: m, reduction: {interface: [x_max], modes: 20" +
        reduction + "}}}\ninstances:\n  a: {component: c, as: " + as +
        ", velocity: [3, 0.2, 0]}\n  b: {component: c, as: " + as +
        ", mirror: x, position: [2.01, 0, 0], velocity: [1, 0, 0]}\ncontact: [{between: [a.x_max, "
        "b.x_max]" +
        contact + "}]\ntime: {end: 0.5}\noutput: {every: 0.0025}\n");
    return std::make_pair(energy_outside_basis(ran.built, ran.result), ran.result);
  };
  const auto [rubbed, run] = meet("superelement", "", ", friction: 0.1");
  ASSERT_TRUE(rubbed);
  // two blocks of mass 1 at 1 and 0.1 either way
  EXPECT_NEAR(rubbed->scale, 0.5 * (1 + 0.1 * 0.1) * 2, 1e-9);
  EXPECT_GT(rubbed->friction, 1e-3);
  EXPECT_NEAR(rubbed->energy + rubbed->friction, run.total.front() - run.total.back(), 1e-12);
  EXPECT_SAYS(text_of(*rubbed, true), "energy lost to truncated modes: ");
  const auto mesh = meet("mesh", "", "").first;
  ASSERT_TRUE(mesh);
  EXPECT_FALSE(mesh->has_modes);
  // the faces' own nodes: half a layer of elements of six
  EXPECT_NEAR(mesh->energy / mesh->scale, 1.0 / 12, 0.002);
  EXPECT_FALSE(meet("mesh", "", ", enforcement: penalty").first);
  EXPECT_FALSE(meet("superelement", ", basis: massless", "").first);
}

// Impacts that lose a twelfth each add up.
TEST(BasisEnergy, WarnsOfManyImpacts) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{6, 3, 3}, Vector3::Ones()}));
  const auto warning = [&](const char* as, double end) {
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
        "components: {c: {mesh: block.exo, material: m, reduction: {interface: [x_min, x_max], "
        "modes: 20}}}\ninstances: {a: {component: c, as: " +
        std::string(as) +
        ", velocity: [0.3, 0, 0]}}\n"
        "walls: {l: {plane: {point: [-0.01, 0, 0], normal: [1, 0, 0]}}, r: {plane: {point: [1.01, "
        "0, 0], normal: [-1, 0, 0]}}}\n"
        "contact:\n  - {between: [a.x_min, l]}\n  - {between: [a.x_max, r]}\ntime: {end: " +
        test::text(end) + "}\noutput: {every: 0.0025}\n");
    return warning_of(*energy_outside_basis(ran.built, ran.result)).value_or("");
  };
  EXPECT_EQ(warning("mesh", 0.22), "");
  EXPECT_SAYS(warning("superelement", 4),
              " impacts, to truncated modes of component 'c': basis: massless");
  EXPECT_SAYS(warning("mesh", 4),
              "to the mass of face nodes of component 'c': as: superelement with");
}

// Of two rigid blocks the second lands later, and stays: both losses count. At rest there is none.
TEST(BasisEnergy, OfRigidBlocksIsLostUpToTheEnd) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{1, 1, 1}, Vector3::Ones()}));
  const auto lost = [&](const char* start) {
    const Ran ran = folder.run(
        "materials: {m: {youngs_modulus: 100, poissons_ratio: 0.3, density: 1}}\n"
        "components: {c: {mesh: block.exo, material: m}}\ninstances:\n"
        "  a: {component: c, as: rigid, position: [0.1, 0, 0], velocity: [-1, 0, 0]}\n"
        "  b: {component: c, as: rigid, position: " +
        std::string(start) +
        "}\nwalls: {wall: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\n"
        "contact:\n  - {between: [a.x_min, wall]}\n  - {between: [b.x_min, wall]}\n"
        "loads: [{instance: b, surface: x_max, pressure: 1}]\n"
        "time: {end: 1, rotations: small}\noutput: {every: 0.05}\n");
    const double h = ran.built.simulation.plan.h;  // of b, mass 1, pressed by 1 at the end
    EXPECT_NEAR(energy_of_a_step(ran.built, ran.result), 0.5 * h * h, 1e-6 * h * h);
    return energy_outside_basis(ran.built, ran.result)->energy;
  };
  // 0.5 of the first, and 0.4 of the second, at sqrt(0.8)
  EXPECT_NEAR(lost("[0.4, 2, 0]"), 0.5 + 0.4, 1e-2);
  EXPECT_NEAR(lost("[0, 2, 0]"), 0.5, 1e-9);
}

// A node alone on its spring and dashpot, which do not pull: the mean over the instants at which it
// lands is that of the differential equation. The nodes of a block of dust hardly feel each other.
TEST(BasisEnergy, DampingOfPenaltySetsTheRebound) {
  SceneFolder folder;
  folder.add("block.exo", test::block_mesh({{1, 1, 1}, Vector3::Ones()}));
  for (const double zeta : {0.0, 0.1, 0.3, 0.5}) {
    constexpr int n = 20;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const Ran ran = folder.run(
          "materials: {dust: {youngs_modulus: 1.0e-6, poissons_ratio: 0, density: 1}}\n"
          "components: {c: {mesh: block.exo, material: dust, mass: lumped}}\ninstances:\n"
          "  b: {component: c, as: mesh, velocity: [-1, 0, 0], position: [" +
          test::text((10 + (i + 0.5) / n) * 1e-3) +
          ", 0, 0]}\nwalls: {w: {plane: {point: [0, 0, 0], normal: [1, 0, 0]}}}\n"
          "contact: [{between: [b.x_min, w], enforcement: penalty, damping: " +
          test::text(zeta) + "}]\ntime: {end: 0.03, step: 0.001}\n" +
          "output: {every: 0.01, history: [b.x_min]}\n");
      sum += test::at(ran.monitor("b.x_min").mean_velocity, ran.result.time.size() - 1)[0];
      EXPECT_LT(test::energy_residual(ran.result), 1e-10);
    }
    const double root = std::sqrt(1 - zeta * zeta),
                 closed = std::exp(
                     -zeta / root *
                     (std::numbers::pi - std::atan2(2 * zeta * root, 1 - 2 * zeta * zeta)));
    std::printf("zeta %.1f: rebound %.4f, closed form %.4f\n", zeta, sum / n, closed);
    EXPECT_NEAR(sum / n, closed, 0.05);
  }
}

}  // namespace
}  // namespace cbr::basis_energy_test

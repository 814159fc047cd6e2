// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement's rigid motions by its coordinates, and by its matrices and modes.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/base/error.hpp"
#include "common/scene/scene_words.hpp"
#include "common/superelement/superelement_check.hpp"
#include "reducer/bases/reduce.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene_run.hpp"

namespace cbr::rigid_check_test {
namespace {

Superelement reduced(Basis basis, MassKind mass = MassKind::lumped,
                     const std::vector<std::string>& loads = {}) {
  const Mesh mesh = test::block_mesh(
      {{4, 3, 2}, Vector3(1, 0.8, 0.7), [](const Vector3& x) -> Vector3 {
         return x + 0.05 * Vector3(std::sin(2 * x[1] + x[2]), std::sin(2 * x[0]), std::sin(x[1]));
       }});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 8;
  options.basis = basis;
  options.loads = loads;
  options.recovery = !loads.empty();
  if (basis == Basis::characteristic) {
    options.modes = 0;
    options.characteristic.modes = 6;
  }
  Report report("test", Verbosity::quiet);
  return reduce(mesh, {BlockProperties{{100, 0.3, 1}, HexFormulation::incompatible}}, mass, options,
                {}, report);
}

std::string refusal(Superelement s, const std::function<void(Superelement&)>& change = {}) {
  if (change) change(s);
  return test::refusal_of([&] {
    check(s, "s.h5");
    check_rigid_motions(s, "s.h5");
  });
}

// What each file of coordinates that are not its own is told by, whatever the basis.
void expect_coordinates_matter(const Superelement& s, const std::string& named) {
  const auto refused = [&](const std::string& what,
                           const std::function<void(Superelement&)>& change) {
    EXPECT_SAYS(refusal(s, change), "s.h5: " + named) << what;
  };
  refused("reversed",
          [](Superelement& t) { t.coordinates = t.coordinates.colwise().reverse().eval(); });
  refused("grown", [](Superelement& t) { t.coordinates *= 1.1; });
  refused("moved", [](Superelement& t) { t.coordinates.col(1).array() += 0.5; });
  refused("another inertia", [](Superelement& t) { t.rigid_body.inertia *= 1e200; });
  refused("another mass", [](Superelement& t) { t.rigid_body.mass *= 1.1; });
}

TEST(RigidCheck, OfMatrices) {
  for (const MassKind mass : {MassKind::lumped, MassKind::consistent}) {
    Superelement s = reduced(Basis::craig_bampton, mass);
    s.omega.resize(0);
    s.V.resize(0, 0);
    EXPECT_EQ(refusal(s), "no error");
    expect_coordinates_matter(s, "/matrices/M_cc");
    EXPECT_SAYS(refusal(s, [](Superelement& t) { t.M_cc *= 1.5; }), "/matrices/M_cc");
    EXPECT_SAYS(refusal(s, [](Superelement& t) { t.M_cc *= 1e200; }), "/matrices/M_cc");
    EXPECT_SAYS(refusal(s, [](Superelement& t) { t.M_cc(0, 0) = 1e300; }), "/matrices/M_cc");
  }
}

TEST(RigidCheck, OfTheDiagonalForm) {
  Superelement s = reduced(Basis::craig_bampton);
  ASSERT_TRUE(s.has_diagonal_form());
  EXPECT_EQ(refusal(s), "no error");
  // An entry that is beyond all others brings no round-off that excuses it
  EXPECT_SAYS(refusal(s, [](Superelement& t) { t.M_cc(0, 0) = 1e300; }), "/diagonal");
  EXPECT_SAYS(refusal(s, [](Superelement& t) { t.K_cc(0, 0) = 1e300; }), "/diagonal");
  // As a run without the matrices reads it
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
  const auto modes_alone = [&](const std::function<void(Superelement&)>& change) {
    Superelement t = s;
    change(t);
    return test::refusal_of([&] { check_rigid_motions(t, "s.h5"); });
  };
  EXPECT_EQ(modes_alone([](Superelement&) {}), "no error");
  EXPECT_SAYS(modes_alone([](Superelement& t) { t.coordinates *= 1.1; }), "/diagonal/V");
  EXPECT_SAYS(modes_alone([](Superelement& t) { t.V.setZero(); }), "/diagonal/V");
  EXPECT_SAYS(modes_alone([](Superelement& t) { t.rigid_body.inertia *= 2; }), "/diagonal/V");
}

TEST(RigidCheck, OfLoadsAndRecovery) {
  const Superelement s = reduced(Basis::craig_bampton, MassKind::lumped, {"y_min"});
  ASSERT_EQ(s.loads.count("y_min"), 1u);
  ASSERT_EQ(s.recovery.size(), 1u);
  EXPECT_EQ(refusal(s), "no error");
  const auto load = [&](const std::function<void(Superelement::InteriorLoad&)>& change) {
    return refusal(s, [&](Superelement& t) {
             change(t.loads.at("y_min"));
           }).find("s.h5: /loads/y_min/force") != std::string::npos;
  };
  EXPECT_TRUE(load([](auto& of) { of.force.setZero(); }));
  EXPECT_TRUE(load([](auto& of) { of.force *= 1.1; }));
  EXPECT_TRUE(load([](auto& of) { of.force = of.force.rowwise().reverse().eval(); }));
  EXPECT_TRUE(load([](auto& of) { of.weight *= 2; }));
  const auto inner = [&](const std::function<void(Points&)>& change) {
    return refusal(s, [&](Superelement& t) {
             change(t.recovery[0].coordinates);
           }).find("/recovery/Psi") != std::string::npos;
  };
  EXPECT_TRUE(inner([](Points& x) { x.setZero(); }));
  EXPECT_TRUE(inner([](Points& x) { x *= 1.1; }));
}

TEST(RigidCheck, OfModes) {
  for (const Basis basis : {Basis::massless, Basis::characteristic}) {
    const Superelement s = reduced(basis);
    const std::string word = word_of(basis_words, basis), field = "/" + word + "/V";
    EXPECT_EQ(refusal(s), "no error") << word;
    expect_coordinates_matter(s, field);
    const auto V = [&](Superelement& t) -> Matrix& {
      return basis == Basis::massless ? t.massless.V : t.characteristic.V;
    };
    EXPECT_SAYS(refusal(s, [&](Superelement& t) { V(t).setZero(); }), field) << word;
    EXPECT_SAYS(refusal(s,
                        [&](Superelement& t) {
                          V(t)
                          (0, 0) = 1e300;
                        }),
                field)
        << word;
  }
}

TEST(RigidCheck, OfFacesAndLengths) {
  const Superelement s = reduced(Basis::craig_bampton);
  const auto faces = [&](const std::function<void(Surface&)>& change) {
    return refusal(s, [&](Superelement& t) { change(t.surfaces[0]); });
  };
  EXPECT_SAYS(faces([](Surface& f) { f.faces.setZero(); }),
              "/interface/x_max/faces: face 0 repeats a node");
  EXPECT_SAYS(faces([](Surface& f) { f.faces(1, 1) = f.faces(1, 0); }), "face 1 repeats a node");
  EXPECT_EQ(faces([](Surface& f) { f.faces(1, 3) = f.faces(1, 2); }), "no error");  // a triangle
  const auto moved = [&](double x) {
    return refusal(s, [&](Superelement& t) { t.coordinates(0, 0) = x; });
  };
  EXPECT_SAYS(moved(1e300), "/nodes/coordinates: has an entry of 1e+300");
  EXPECT_SAYS(refusal(s, [](Superelement& t) { t.rigid_body.center[1] = -1e300; }),
              "/rigid_body/center");
  EXPECT_SAYS(
      refusal(s, [](Superelement& t) { t.coordinates.rowwise() = t.coordinates.row(0).eval(); }),
      "no area");
}

TEST(RigidCheck, FewNodesTellNothing) {
  Superelement s = reduced(Basis::craig_bampton);
  s.omega.resize(0);
  s.V.resize(0, 0);
  s.surfaces.clear();
  s.spin_moments.resize(0, 0);
  s.spin_couplings.resize(0, 0);
  // As of one whose interface is a single node, by another maker: its rotations are in the modes
  s.node_ids.resize(1);
  s.coordinates = s.coordinates.topRows(1).eval();
  s.dof_node = {0, 0, 0};
  s.dof_component = {0, 1, 2};
  s.K_cc = Matrix::Zero(3, 3);
  s.M_cc = s.M_cc.topLeftCorner(3, 3).eval();
  s.M_kc = s.M_kc.leftCols(3).eval();
  EXPECT_EQ(refusal(s), "no error");
}

}  // namespace
}  // namespace cbr::rigid_check_test

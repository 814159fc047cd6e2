// SPDX-License-Identifier: GPL-3.0-or-later
// A superelement's rigid motions by its coordinates, and by its matrices and modes.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/base/error.hpp"
#include "common/scene/scene_words.hpp"
#include "common/superelement/superelement_check.hpp"
#include "reducer/bases/reduce.hpp"
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
  try {
    check(s, "s.h5");
    check_rigid_motions(s, "s.h5");
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

// What each file of coordinates that are not its own is told by, whatever the basis.
void expect_coordinates_matter(const Superelement& s, const std::string& named) {
  const auto refused = [&](const std::string& what,
                           const std::function<void(Superelement&)>& change) {
    const std::string said = refusal(s, change);
    EXPECT_NE(said.find("s.h5: " + named), std::string::npos) << what << ": " << said;
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
    EXPECT_EQ(refusal(s), "");
    expect_coordinates_matter(s, "/matrices/M_cc");
    EXPECT_NE(refusal(s, [](Superelement& t) { t.M_cc *= 1.5; }).find("/matrices/M_cc"),
              std::string::npos);
    EXPECT_NE(refusal(s, [](Superelement& t) { t.M_cc *= 1e200; }).find("/matrices/M_cc"),
              std::string::npos);
    EXPECT_NE(refusal(s, [](Superelement& t) { t.M_cc(0, 0) = 1e300; }).find("/matrices/M_cc"),
              std::string::npos);
  }
}

TEST(RigidCheck, OfTheDiagonalForm) {
  Superelement s = reduced(Basis::craig_bampton);
  ASSERT_TRUE(s.has_diagonal_form());
  EXPECT_EQ(refusal(s), "");
  // An entry that is beyond all others brings no round-off that excuses it
  EXPECT_NE(refusal(s, [](Superelement& t) { t.M_cc(0, 0) = 1e300; }).find("/diagonal"),
            std::string::npos);
  EXPECT_NE(refusal(s, [](Superelement& t) { t.K_cc(0, 0) = 1e300; }).find("/diagonal"),
            std::string::npos);
  // As a run without the matrices reads it
  s.K_cc.resize(0, 0);
  s.M_cc.resize(0, 0);
  s.M_kc.resize(0, 0);
  const auto modes_alone = [&](const std::function<void(Superelement&)>& change) {
    Superelement t = s;
    change(t);
    try {
      check_rigid_motions(t, "s.h5");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(modes_alone([](Superelement&) {}), "");
  EXPECT_NE(modes_alone([](Superelement& t) { t.coordinates *= 1.1; }).find("/diagonal/V"),
            std::string::npos);
  EXPECT_NE(modes_alone([](Superelement& t) { t.V.setZero(); }).find("/diagonal/V"),
            std::string::npos);
  EXPECT_NE(modes_alone([](Superelement& t) { t.rigid_body.inertia *= 2; }).find("/diagonal/V"),
            std::string::npos);
}

TEST(RigidCheck, OfLoadsAndRecovery) {
  const Superelement s = reduced(Basis::craig_bampton, MassKind::lumped, {"y_min"});
  ASSERT_EQ(s.loads.count("y_min"), 1u);
  ASSERT_EQ(s.recovery.size(), 1u);
  EXPECT_EQ(refusal(s), "");
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
    EXPECT_EQ(refusal(s), "") << word;
    expect_coordinates_matter(s, field);
    const auto V = [&](Superelement& t) -> Matrix& {
      return basis == Basis::massless ? t.massless.V : t.characteristic.V;
    };
    EXPECT_NE(refusal(s, [&](Superelement& t) { V(t).setZero(); }).find(field), std::string::npos)
        << word;
    EXPECT_NE(refusal(s,
                      [&](Superelement& t) {
                        V(t)
                        (0, 0) = 1e300;
                      })
                  .find(field),
              std::string::npos)
        << word;
  }
}

TEST(RigidCheck, OfFacesAndLengths) {
  const Superelement s = reduced(Basis::craig_bampton);
  const auto faces = [&](const std::function<void(Surface&)>& change) {
    return refusal(s, [&](Superelement& t) { change(t.surfaces[0]); });
  };
  EXPECT_NE(faces([](Surface& f) {
              f.faces.setZero();
            }).find("/interface/x_max/faces: face 0 repeats a node"),
            std::string::npos);
  EXPECT_NE(faces([](Surface& f) { f.faces(1, 1) = f.faces(1, 0); }).find("face 1 repeats a node"),
            std::string::npos);
  EXPECT_EQ(faces([](Surface& f) { f.faces(1, 3) = f.faces(1, 2); }), "");  // a triangle
  const auto moved = [&](double x) {
    return refusal(s, [&](Superelement& t) { t.coordinates(0, 0) = x; });
  };
  EXPECT_NE(moved(1e300).find("/nodes/coordinates: has an entry of 1e+300"), std::string::npos);
  EXPECT_NE(refusal(s, [](Superelement& t) { t.rigid_body.center[1] = -1e300; })
                .find("/rigid_body/center"),
            std::string::npos);
  EXPECT_NE(
      refusal(s, [](Superelement& t) { t.coordinates.rowwise() = t.coordinates.row(0).eval(); })
          .find("no area"),
      std::string::npos);
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
  EXPECT_EQ(refusal(s), "");
}

}  // namespace
}  // namespace cbr::rigid_check_test

// SPDX-License-Identifier: GPL-3.0-or-later
// Eq 18 of the paper, put right: a component whose interface is accelerated responds through M_kc,
// as K_kc = 0. Bars of nu = 0 along x, held or driven at x = 0; m = rho A L, k = E A / L.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "dynamics/motion/modal/modal_body.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/partition/partition.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

namespace cbr::test::accelerated_interface_test {
namespace {

constexpr double L = 2, width = 0.3, E = 50, rho = 3, a = 0.7;  // a: acceleration of the interface
constexpr double m = rho * width * width * L, k = E * width * width / L;
const Material bar_material = {E, 0, rho};

struct Bar {
  Mesh mesh;
  std::shared_ptr<Superelement> superelement;
};

// One element along the bar is the paper's: two nodes, one of them the interface. All modes are
// kept.
Bar bar(Index elements, MassKind mass) {
  Bar b;
  b.mesh = box_mesh({{elements, 1, 1}, {L, width, width}});
  ReductionOptions options;
  options.interface_sets = {"x_min"};
  options.modes = 12 * elements;
  options.recovery = true;
  Report report("test", Verbosity::quiet);
  b.superelement = std::make_shared<Superelement>(
      reduce(b.mesh, properties(b.mesh, bar_material), mass, options, ReduceSettings{}, report));
  return b;
}

// Unit displacement of the interface along x (c).
Vector along_x(const Superelement& s) {
  Vector r = Vector::Zero(s.c());
  for (Index i = 0; i < s.c(); ++i) r(i) = s.dof_component[i] == 0 ? 1 : 0;
  return r;
}

// Mean x component of Phi q_k at the end of the bar: what it moves by against the interface.
double tip(const Superelement& s, const Vector& q_k) {
  const Superelement::Recovery& recovery = s.recovery.front();
  const Vector u = recovery.Phi * q_k;
  double sum = 0;
  for (Index i = 0; i < recovery.coordinates.rows(); ++i)
    sum += recovery.coordinates(i, 0) > L * (1 - 1e-9) ? u(3 * i) : 0;
  return sum / 4;
}

double tip(const Superelement& s, const Body& body) {
  Vector q, rates;
  body.coordinates(q, rates);
  return tip(s, q.head(s.k()));
}

class AcceleratedInterface : public testing::TestWithParam<MassKind> {};
INSTANTIATE_TEST_SUITE_P(Eq18, AcceleratedInterface,
                         testing::Values(MassKind::lumped, MassKind::consistent));

// E u'' = rho a, u(0) = 0, u'(L) = 0: the nodes of the bar, of whatever number of elements, lie on
// it.
TEST_P(AcceleratedInterface, SteadyStateIsThatOfTheBarUnderItsInertia) {
  for (const Index elements : {Index{1}, Index{2}, Index{7}}) {
    const Bar b = bar(elements, GetParam());
    const Superelement& s = *b.superelement;
    // K_kk u_k = -M_kc a_c
    const Vector u_k = -(s.M_kc * along_x(s) * a).cwiseQuotient(s.eigenvalues);
    EXPECT_NEAR(tip(s, u_k), -m * a / (2 * k), 2e-11 * m * a / k);
    const Superelement::Recovery& recovery = s.recovery.front();
    const Vector u_I = recovery.Phi * u_k;
    for (Index i = 0; i < recovery.coordinates.rows(); ++i) {
      const double x = recovery.coordinates(i, 0), u = -rho * a / E * (L * x - 0.5 * x * x);
      EXPECT_LT((u_I.segment<3>(3 * i) - Vector3(u, 0, 0)).norm(), 2e-11 * m * a / k)
          << elements << " elements, x = " << x;
    }
  }
}

// With K_kc in the place of M_kc nothing moves: that is what the paper concludes, and it is not the
// bar's answer.
TEST_P(AcceleratedInterface, AsPrintedThereWouldBeNoResponse) {
  const Bar b = bar(1, GetParam());
  const Superelement& s = *b.superelement;
  const FiniteElementModel model = assemble(b.mesh, properties(b.mesh, bar_material), GetParam());
  const Partition p = partition(model, interface_nodes(b.mesh, model, {"x_min"}));
  const Superelement::Recovery& recovery = s.recovery.front();
  // K_kc = Phi^T (K_IC + K_II Psi)   (k x c)
  const Matrix K_kc = recovery.Phi.transpose() * (p.K_IC + p.K_II * recovery.Psi);
  EXPECT_LT(std::abs(tip(s, (K_kc * along_x(s) * a).cwiseQuotient(s.eigenvalues))), 1e-12 * a);
  EXPECT_GT((s.M_kc * along_x(s)).norm(), 0.5 * std::sqrt(m));
}

// Interface at rest, the bar under gravity -a: the bar seen from an interface that is accelerated
// by a from t = 0 on. One element has one axial mode, of m / 2 (lumped) or m / 3 (consistent) on
// the spring k: u = -(m a / 2 k) (1 - cos omega t).
TEST_P(AcceleratedInterface, TransientSwingsAboutTheSteadyState) {
  const Bar b = bar(1, GetParam());
  const Superelement& s = *b.superelement;
  std::vector<HeldDirection> held;
  for (Index i = 0; i < 4; ++i)
    for (Index c = 0; c < 3; ++c) held.push_back({i, Vector3::Unit(c)});
  const auto form = std::make_shared<ModalForm>(held_modal_form(s, held, "test"));
  ModalBody body("bar", b.superelement, form, Placement{}, Scheme::exact);
  body.prepare({.loads = {gravity_load(Vector3(-a, 0, 0))}});
  const double omega = std::sqrt((GetParam() == MassKind::lumped ? 2 : 3) * k / m);
  const double h = 0.37 / omega;
  for (int step = 1; step <= 40; ++step) {
    body.predict((step - 1) * h, h);
    body.accept();
    const double u = -m * a / (2 * k) * (1 - std::cos(omega * step * h));
    EXPECT_NEAR(tip(s, body), u, 1e-12 * m * a / k) << "step " << step;
  }
}

// A force F on the interface of the free bar: its centre is accelerated by F / m, the ends swing
// against each other about -F / 2 k with omega^2 = 4 k / m (lumped) or 12 k / m (consistent). A
// component that did not respond would move as a whole.
TEST_P(AcceleratedInterface, FreeBarPushedAtItsInterface) {
  const Bar b = bar(1, GetParam());
  const auto superelement = std::make_shared<Superelement>(*b.superelement);
  const auto form = std::make_shared<ModalForm>(free_modal_form(*superelement, "test"));
  ModalBody body("bar", superelement, form, Placement{}, Scheme::exact);
  const double F = m * a;
  Points force = Points::Zero(4, 3);
  force.col(0).setConstant(F / 4);
  const Index face = body.track_mean({0, 1, 2, 3});
  body.prepare({.loads = {force_load(force)}});
  const double omega = std::sqrt((GetParam() == MassKind::lumped ? 4 : 12) * k / m),
               h = 0.37 / omega;
  for (int step = 1; step <= 40; ++step) {
    body.predict((step - 1) * h, h);
    body.accept();
    // tip less interface
    const double t = step * h, apart = -F / (2 * k) * (1 - std::cos(omega * t));
    Vector3 x, v;
    body.mean_motion(face, x, v);
    EXPECT_NEAR(x(0), 0.5 * a * t * t - 0.5 * apart, 1e-12 * (a * t * t + F / k))
        << "step " << step;
    EXPECT_NEAR(tip(*superelement, body), apart, 1e-11 * F / k) << "step " << step;
  }
}

}  // namespace
}  // namespace cbr::test::accelerated_interface_test

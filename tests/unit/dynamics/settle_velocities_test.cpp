// SPDX-License-Identifier: GPL-3.0-or-later
// The law of velocities under Newmark: of points with impulses, for bodies made of random masses;
// and what the bodies do with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/linalg/dense.hpp"
#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/motion/coupled/coupled_body.hpp"
#include "tests/unit/dynamics/bricks.hpp"
#include "tests/unit/dynamics/contact_problems.hpp"
#include "tests/unit/dynamics/coupled_parts.hpp"

namespace cbr::settle_velocities_test {
namespace {

using test::random_points;

constexpr Index nodes_of_body = 6;

Eigen::Map<const Vector> flat(const Points& p) { return {p.data(), p.size()}; }

// Slave nodes of body 0 against two nodes of body 1 each, or a wall, in random directions; impulses
// within the cones.
struct Problem {
  std::vector<Matrix> mass;
  std::vector<ContactBody> bodies;
  ContactList list;
  std::vector<PointLaw> laws;
  Points p, velocities;
  std::vector<Points> v;

  Problem(std::mt19937& random, const std::vector<PointLaw>& the_laws) : laws(the_laws) {
    for (int b = 0; b < 2; ++b) {
      const Matrix A = test::random_matrix(random, 3 * nodes_of_body, 3 * nodes_of_body);
      mass.push_back(A * A.transpose() +
                     2 * Matrix::Identity(3 * nodes_of_body, 3 * nodes_of_body));
      ContactBody body;
      body.impulses.setZero(nodes_of_body, 3);
      body.friction.setZero(nodes_of_body, 3);
      body.velocity_response.set_block(Lu(mass.back()).inverse());
      // must not be looked at
      body.response.set_block(17 * Matrix::Identity(3 * nodes_of_body, 3 * nodes_of_body));
      bodies.push_back(body);
      v.push_back(random_points(random, nodes_of_body, 1));
    }
    const Index n = laws.size();
    p.setZero(n, 3);
    velocities.resize(n, 3);
    std::uniform_real_distribution<double> share(0, 1);
    for (Index i = 0; i < n; ++i) add_point(i, random, share);
    measure();
  }

  void add_point(Index i, std::mt19937& random, std::uniform_real_distribution<double>& share) {
    ContactPoint point;
    point.frame = contact_frame(random_points(random, 1, 1).row(0).transpose().normalized());
    point.first_term = static_cast<Index>(list.terms.size());
    const double at = share(random);
    list.terms.push_back({0, i % nodes_of_body, 1});
    if (i % 4 != 3) {
      list.terms.push_back({1, (2 * i) % nodes_of_body, -at});
      list.terms.push_back({1, (2 * i + 1) % nodes_of_body, at - 1});
    }
    point.n_terms = static_cast<Index>(list.terms.size()) - point.first_term;
    list.points.push_back(point);
    if (i % 3 == 2) return;  // open
    p.row(i) = 3 * random_points(random, 1, 1);
    if (laws[i].law == ContactLaw::tied) return;
    p(i, 0) = std::abs(p(i, 0));
    p.row(i).tail<2>() *= laws[i].law == ContactLaw::coulomb
                              ? laws[i].friction * p(i, 0) / p.row(i).tail<2>().norm()
                              : 0.0;
  }

  void measure() {
    for (Index i = 0; i < p.rows(); ++i) {
      Vector3 sum = Vector3::Zero();
      for (Index t = 0; t < list.points[i].n_terms; ++t) {
        const ContactTerm& term = list.terms[list.points[i].first_term + t];
        sum += term.coefficient * v[term.body].row(term.node).transpose();
      }
      velocities.row(i) = (list.points[i].frame * sum).transpose();
    }
  }

  double energy() const {
    double sum = 0;
    for (int b = 0; b < 2; ++b) sum += 0.5 * flat(v[b]).dot(mass[b] * flat(v[b]));
    return sum;
  }

  // M^-1 times the impulses
  void push(const Points& impulses) {
    for (ContactBody& body : bodies) {
      body.impulses.setZero();
      body.friction.setZero();
    }
    spread_impulses(list, laws, impulses, bodies);
    for (int b = 0; b < 2; ++b) {
      const Points sum = bodies[b].impulses + bodies[b].friction;
      Eigen::Map<Vector>(v[b].data(), v[b].size()) += Cholesky(mass[b]).solve(flat(sum));
    }
    measure();
  }

  bool acts(Index i) const {
    return laws[i].law == ContactLaw::tied ? !p.row(i).isZero(0) : p(i, 0) > 0;
  }
};

std::vector<PointLaw> random_laws(std::mt19937& random, bool friction) {
  std::vector<PointLaw> laws;
  std::uniform_int_distribution<int> pick(0, 3);
  for (int i = 0; i < 9; ++i) {
    const int law = pick(random);
    if (law == 0 && i < 2) {
      laws.push_back({ContactLaw::tied, 0});
    } else if (friction && law > 1) {
      laws.push_back({ContactLaw::coulomb, 0.2 * law});
    } else {
      laws.push_back({ContactLaw::frictionless, 0});
    }
  }
  return laws;
}

TEST(SettleVelocities, LawsHoldForTheVelocitiesOfWhatIsClosed) {
  std::mt19937 random(11);
  Index still = 0, leaving = 0, sliding = 0, sticking = 0;
  for (int run = 0; run < 60; ++run) {
    Problem problem(random, random_laws(random, true));
    ImpulseMemory memory;
    const Points change = settle_velocities(problem.list, problem.laws, problem.p,
                                            problem.velocities, problem.bodies, memory);
    const Points P = problem.p + change;
    problem.push(change);
    for (Index i = 0; i < P.rows(); ++i) {
      if (!problem.acts(i)) {
        EXPECT_TRUE(change.row(i).isZero(0)) << "an open point is left alone";
        continue;
      }
      const Vector3 end = problem.velocities.row(i).transpose();
      if (problem.laws[i].law == ContactLaw::tied) {
        EXPECT_LT(end.norm(), 1e-10);
        continue;
      }
      EXPECT_GE(P(i, 0), -1e-12);
      EXPECT_GE(end[0], -1e-10) << "nothing moves into what it touches";
      EXPECT_LT(std::min(P(i, 0), end[0]), 1e-10) << "what leaves is not held";
      ++(P(i, 0) > 1e-8 ? still : leaving);
      const double pull = P.row(i).tail<2>().norm(), limit = problem.laws[i].friction * P(i, 0),
                   slip = end.tail<2>().norm();
      EXPECT_LE(pull, limit + 1e-10) << "the total impulse is within the cone";
      if (problem.laws[i].law != ContactLaw::coulomb || limit < 1e-8) continue;
      if (pull < limit - 1e-8) {
        EXPECT_LT(slip, 1e-9);
        ++sticking;
      } else {
        EXPECT_LT((P.row(i).tail<2>().transpose() * slip + limit * end.tail<2>()).norm(),
                  1e-8 * (1 + limit * slip));
        ++sliding;
      }
    }
  }
  for (const Index n : {still, leaving, sliding, sticking}) EXPECT_GT(n, 10);
}

// Of all admissible impulses of the closed points those that leave the least kinetic energy.
TEST(SettleVelocities, WithoutFrictionTheLeastEnergyIsLeft) {
  std::mt19937 random(12);
  for (int run = 0; run < 40; ++run) {
    const Problem before(random, random_laws(random, false));
    Problem settled = before;
    ImpulseMemory memory;
    const Points change = settle_velocities(before.list, before.laws, before.p, before.velocities,
                                            settled.bodies, memory);
    settled.push(change);
    EXPECT_LE(settled.energy(), before.energy() * (1 + 1e-12));
    for (int other = 0; other < 20; ++other) {
      Points P = before.p + change;
      for (Index i = 0; i < P.rows(); ++i) {
        if (!before.acts(i)) continue;
        const Points random_step = random_points(random, 1, other < 10 ? 0.1 : 2);
        if (before.laws[i].law == ContactLaw::tied)
          P.row(i) += random_step.row(0);
        else
          P(i, 0) = std::max(0.0, P(i, 0) + random_step(0, 0));
      }
      Problem moved = before;
      moved.push(P - before.p);
      EXPECT_GE(moved.energy(), settled.energy() * (1 - 1e-12));
    }
  }
}

// What the master gets is what the slave gives; walls take the rest.
TEST(SettleVelocities, MomentumIsKept) {
  std::mt19937 random(13);
  Problem problem(random, random_laws(random, true));
  ImpulseMemory memory;
  const Points change = settle_velocities(problem.list, problem.laws, problem.p, problem.velocities,
                                          problem.bodies, memory);
  EXPECT_GT(change.norm(), 0.1);
  Vector3 of_walls = Vector3::Zero();
  for (Index i = 3; i < change.rows(); i += 4)
    of_walls += problem.list.points[i].frame.transpose() * change.row(i).transpose();
  problem.push(change);
  Vector3 sum = Vector3::Zero();
  for (const ContactBody& body : problem.bodies)
    sum += (body.impulses + body.friction).colwise().sum().transpose();
  EXPECT_LT((sum - of_walls).norm(), 1e-12 * change.norm());
}

// W is kept while the same points are closed, and formed anew when others of the same list are.
TEST(SettleVelocities, KeepsWhatStandsAndNothingElse) {
  std::mt19937 random(14);
  Problem problem(random, std::vector<PointLaw>(9));
  // as faces of one plane have it
  for (ContactPoint& point : problem.list.points) point.frame = Matrix3::Identity();
  problem.measure();
  ImpulseMemory kept;
  for (const Index closed : {0, 1, 2, 4, 4}) {
    problem.p.setZero();
    problem.p(closed, 0) = problem.p(closed + 1, 0) = 1.5;
    ImpulseMemory fresh;
    const Points with = settle_velocities(problem.list, problem.laws, problem.p, problem.velocities,
                                          problem.bodies, kept);
    const Points without = settle_velocities(problem.list, problem.laws, problem.p,
                                             problem.velocities, problem.bodies, fresh);
    EXPECT_LT((with - without).norm(), 1e-12 * (1 + without.norm())) << closed;
  }
}

double energy(const Body& body) { return body.state().kinetic_energy + body.state().strain_energy; }
double booked(const Body& body) {
  const BodyWork work = body.work();
  return work.external + work.contact + work.numerical;
}

// Impulses at the end of some steps, after ones over the step, against a twin without them.
void expect_end_impulses(Body& body, Body& twin, bool is_free) {
  std::mt19937 random(15);
  const std::vector<Index> nodes{1, 4, 6};
  const Index set = body.track(nodes), same = twin.track(nodes);
  const Matrix S = body.velocity_response(set).dense();
  ASSERT_EQ(S.rows(), 9);
  EXPECT_LT((S - S.transpose()).norm(), 1e-13 * S.norm());
  const double h = 3 / body.largest_frequency(), start = energy(body);
  double t = 0;
  for (int step = 0; step < 6; ++step, t += h) {
    const Points p = random_points(random, 3, 0.3), q = random_points(random, 3, 0.2),
                 r = random_points(random, 3, 0.1);
    Points before, after, x, y;
    for (Body* b : {&body, &twin}) {
      b->predict(t, h);
      b->add_impulses(b == &body ? set : same, p);
    }
    body.end_velocities(set, before);
    body.add_end_impulses(set, q);
    body.add_end_impulses(set, r);
    body.end_velocities(set, after);
    const Points sum = q + r, moved = after - before;
    const Vector expected = S * flat(sum);
    EXPECT_LT((flat(moved) - expected).norm(), 1e-10 * expected.norm());
    const Vector3 momentum = body.state().momentum;
    body.accept();
    twin.accept();
    if (step > 0) continue;  // from here on the two are not in the same state
    body.positions(set, x);
    twin.positions(same, y);
    EXPECT_LT((x - y).norm(), 1e-13 * x.norm()) << "positions are left alone";
    const Vector3 gained = body.state().momentum - twin.state().momentum,
                  brought = sum.colwise().sum().transpose();
    if (is_free) {
      EXPECT_LT((gained - brought).norm(), 1e-10 * (brought.norm() + momentum.norm()));
    }
    EXPECT_NEAR(body.work().contact - twin.work().contact, energy(body) - energy(twin),
                1e-11 * energy(body));
  }
  EXPECT_NEAR(energy(body) - start, booked(body), 1e-10 * energy(body));
}

TEST(SettleVelocities, SuperelementsTakeImpulsesAtTheEnd) {
  const test::Lattice block = test::lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  const auto model = test::model(test::reduce(block, test::x_nodes(block, true, true), 6));
  for (const double alpha : {0.0, -0.1, -1.0 / 3}) {
    const auto make = [&] {
      return ModalBody("body", model.superelement, model.form, test::oblique(true), Scheme::newmark,
                       NewmarkOptions{alpha});
    };
    ModalBody body = make(), twin = make();
    expect_end_impulses(body, twin, true);
  }
}

TEST(SettleVelocities, CoupledBodiesTakeImpulsesAtTheEnd) {
  const test::Brick lumped = test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2});
  const test::Brick full =
      test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2}, MassKind::consistent);
  const CoupledModel models[] = {test::chain(2, 4).model(), test::chain_with_shells(3),
                                 coupled_model(lumped.fe, lumped.geometry.coordinates),
                                 coupled_model(full.fe, full.geometry.coordinates)};
  for (const CoupledModel& of : models) {
    const auto model = std::make_shared<const CoupledModel>(of);
    for (const std::vector<HeldDirection>& held :
         {std::vector<HeldDirection>{}, test::some_held()}) {
      for (const double alpha : {0.0, -0.1, -1.0 / 3}) {
        const auto make = [&] {
          return coupled_body("body", model, test::oblique(true), held, Scheme::newmark,
                              NewmarkOptions{alpha});
        };
        expect_end_impulses(*make(), *make(), held.empty());
      }
    }
  }
}

// A lumped mesh answers node by node, without a matrix of all its contact nodes.
TEST(SettleVelocities, LumpedMeshesAnswerNodeByNode) {
  const test::Brick brick = test::make_brick({3, 2, 2}, Vector3(1, 0.6, 0.5), {100, 0.3, 2});
  const auto model =
      std::make_shared<const CoupledModel>(coupled_model(brick.fe, brick.geometry.coordinates));
  const auto body = coupled_body("body", model, test::oblique(true), {}, Scheme::newmark, {});
  EXPECT_TRUE(body->velocity_response(body->track({0, 5, 7})).is_diagonal());
}

}  // namespace
}  // namespace cbr::settle_velocities_test

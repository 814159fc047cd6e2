// SPDX-License-Identifier: GPL-3.0-or-later
// A step of a superelement that stands takes no memory, and instances share what does not depend on
// where they are.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <atomic>
#include <cstdlib>
#include <new>
#include <random>

#include "dynamics/motion/modal/modal_body.hpp"
#include "tests/unit/dynamics/lattice.hpp"

namespace {

std::atomic<long> n_allocations{0};

}  // namespace

// Eigen takes memory by malloc(), the library's containers by operator new: the linker sends both
// here (--wrap=malloc).
extern "C" {
void* __real_malloc(std::size_t size);
void* __wrap_malloc(std::size_t size) {
  ++n_allocations;
  return __real_malloc(size);
}
}

// __real_malloc is malloc(), which GCC cannot know
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(std::size_t size) {
  ++n_allocations;
  if (void* memory = __real_malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#pragma GCC diagnostic pop

namespace cbr::allocation_test {
namespace {

const test::Model& block() {
  static const test::Lattice body = test::lattice({4, 3, 3}, 0.1, 2e3, 0.5);
  static const test::Model model =
      test::model(test::reduce(body, test::x_nodes(body, true, true), 12));
  return model;
}

Placement placed(double angle) {
  Placement placement;
  placement.T = Eigen::AngleAxisd(angle, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  placement.velocity = Vector3(2, -1, 0.5);
  return placement;
}

struct Steps {
  ModalBody body;
  Index whole, some;
  Points p, q, x, y;

  Steps(Scheme scheme, bool loaded)
      : body("body", block().superelement, block().form, placed(0.7), scheme) {
    std::vector<Index> nodes = first_numbers(body.n_nodes());
    whole = body.track(nodes);
    some = body.track({11, 0, 5, 3});  // in no order: a copy of their rows
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    p = Points::NullaryExpr(body.n_nodes(), 3, [&] { return normal(random); });
    p.middleRows(2, 3).setZero();
    q = Points::NullaryExpr(4, 3, [&] { return normal(random); });
    if (loaded) body.prepare({.loads = {gravity_load(Vector3(0, 0, -9.81))}});
  }

  void step(double t, double h) {
    body.predict(t, h);
    body.predicted_positions(whole, x);
    body.add_impulses(whole, p);
    body.add_impulses(some, q);
    body.predicted_positions(some, y);
    body.predicted_positions(whole, x);
    if (body.scheme() == Scheme::newmark) {
      body.end_velocities(whole, x);
      body.add_end_impulses(whole, p);
    }
    body.accept();
    body.positions(whole, x);
  }
};

TEST(Allocation, NoneInAStepThatStands) {
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference, Scheme::newmark}) {
    for (const bool loaded : {false, true}) {
      Steps steps(scheme, loaded);
      const double h = 1.5 / steps.body.largest_frequency();
      steps.step(0, h);
      steps.step(h, h);
      const long before = n_allocations;
      for (int i = 2; i < 12; ++i) steps.step(i * h, h);
      EXPECT_EQ(n_allocations - before, 0) << static_cast<int>(scheme) << loaded;
    }
  }
  // The count does count
  const long before = n_allocations;
  Steps steps(Scheme::exact, false);
  EXPECT_GT(n_allocations - before, 20);
}

TEST(SharedRows, InstancesOfAFormShareResponsesAndRows) {
  const test::Model& model = block();
  std::vector<Index> nodes = first_numbers(model.superelement->node_ids.size());
  for (const Scheme scheme : {Scheme::exact, Scheme::central_difference, Scheme::newmark}) {
    ModalBody a("a", model.superelement, model.form, placed(0.3), scheme);
    ModalBody b("b", model.superelement, model.form, placed(1.9), scheme);
    const Index of_a = a.track(nodes), of_b = b.track(nodes);
    const double h = 1.2 / a.largest_frequency();
    const NodeResponse S_a = a.response(of_a, h), S_b = b.response(of_b, h);
    EXPECT_EQ(S_a.block.get(), S_b.block.get());
    EXPECT_NE(a.response(of_a, h / 2).block.get(), S_a.block.get());
    EXPECT_GT((S_a.dense() - S_b.dense()).norm(), 1e-3 * S_a.dense().norm());
    if (scheme != Scheme::newmark) continue;
    EXPECT_EQ(a.velocity_response(of_a).block.get(), b.velocity_response(of_b).block.get());
    EXPECT_NE(a.velocity_response(of_a).block.get(), S_a.block.get());
  }
  // Schemes do not mix
  ModalBody exact("e", model.superelement, model.form, placed(0), Scheme::exact);
  ModalBody central("c", model.superelement, model.form, placed(0), Scheme::central_difference);
  const Index of_exact = exact.track(nodes), of_central = central.track(nodes);
  const double h = 1.2 / exact.largest_frequency();
  EXPECT_NE(exact.response(of_exact, h).block.get(), central.response(of_central, h).block.get());
}

TEST(SharedRows, ACopyOfAFormHasItsOwn) {
  ModalForm copy = *block().form;
  IndexTable row = displacement_rows(*block().superelement);
  const auto of_original = block().form->shared.rows(block().form->V, row, {0, 1});
  copy.V *= 2;
  const auto of_copy = copy.shared.rows(copy.V, row, {0, 1});
  EXPECT_NE(of_original.get(), of_copy.get());
  EXPECT_EQ(of_copy->Vt(), 2 * of_original->Vt());
}

// Rows that follow each other in V are used where they are; others are copied. Both are the same
// rows.
TEST(SharedRows, AreThoseOfV) {
  const RowMatrix& V = block().form->V;
  const IndexTable row = displacement_rows(*block().superelement);
  for (const std::vector<Index>& nodes : {std::vector<Index>{2, 3, 4}, std::vector<Index>{4, 1}}) {
    const NodeRows rows(V, row, nodes);
    const bool in_place = rows.Vt().data() == V.row(row(nodes[0], 0)).data();
    EXPECT_EQ(in_place, nodes.size() == 3);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int d = 0; d < 3; ++d)
        EXPECT_EQ(rows.Vt().col(3 * static_cast<Index>(i) + d),
                  V.row(row(nodes[i], d)).transpose());
  }
}

}  // namespace
}  // namespace cbr::allocation_test

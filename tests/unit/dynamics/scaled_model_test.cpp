// SPDX-License-Identifier: GPL-3.0-or-later
// The two ways to a scaled model: from all modes, and from the matrices alone.
#include "dynamics/motion/scaled/scaled_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/unit/dynamics/scaled_bodies.hpp"

namespace cbr::test::scaled_model_test {
namespace {

// From the matrices alone, without all modes; a block with some more coordinates.
void compare_ways(Shape shape, Index k, double share, bool mirrored) {
  const Lattice large = lattice({5, 6, 7}, 0.1, 2e3, 0.5);
  Model m = model(reduce(large, x_nodes(large, true, true), k));
  const auto held = held_directions(shape);
  if (shape != Shape::free)
    m.form = std::make_shared<DiagonalForm>(held_diagonal_form(*m.superelement, held, "test"));
  const auto from_matrices = scaled_model(m.superelement, held, "test");
  const double highest = m.form->omega.maxCoeff(), clip = share * highest;
  EXPECT_NEAR(from_matrices->largest_frequency(), highest, 2e-6 * highest);
  const auto modes = from_matrices->clipped(clip),
             all = scaled_model(m.superelement, m.form)->clipped(clip);
  EXPECT_EQ(modes->method, "block lanczos");
  ASSERT_EQ(modes->n_kept(), all->n_kept());
  EXPECT_EQ(modes->n_rigid, all->n_rigid);
  EXPECT_EQ(modes->n_scaled, all->n_scaled);
  EXPECT_NEAR(modes->lowest_scaled, all->lowest_scaled, 1e-10 * highest);
  EXPECT_LT((modes->omega - all->omega).norm(), 1e-10 * highest);
  std::vector<Index> nodes(m.superelement->node_ids.size());
  std::iota(nodes.rbegin(), nodes.rend(), Index{0});
  const Matrix &S = *modes->node_rows(nodes)->S, &S_all = *all->node_rows(nodes)->S;
  EXPECT_LT((S - S_all).norm(), 1e-11 * S_all.norm());
  EXPECT_EQ((S - S.transpose()).norm(), 0);
  const Matrix F = Matrix::NullaryExpr(
      m.superelement->n(), 3, [](Index i, Index j) { return std::cos(double(3 * i * i + 5 * j)); });
  EXPECT_LT((modes->part->times(F) - all->part->times(F)).norm(),
            1e-11 * all->part->times(F).norm());
  ScaledBody body("body", from_matrices, oblique(mirrored));
  SuperelementBody reference("body", m.superelement, slowed(*m.form, clip), oblique(mirrored),
                             Scheme::exact);
  expect_equal_motion(body, reference, 1.9 / clip, 100, 1e-9);
}

TEST(ScaledModel, OfTheMatricesIsThatOfAllModes) {
  compare_ways(Shape::free, 12, 0.35, false);
  compare_ways(Shape::free, 0, 0.3, true);
  compare_ways(Shape::held, 12, 0.3, true);
  compare_ways(Shape::held, 0, 0.3, false);
  compare_ways(Shape::hinged, 12, 0.3, false);
}

TEST(ScaledModel, OfTheMatricesWithAClipBelowAllElasticModes) {
  compare_ways(Shape::free, 12, 1e-3, true);
  compare_ways(Shape::held, 5, 1e-3, true);
}

TEST(ScaledModel, OfTheMatricesWithAHighClipTakesAllModes) {
  for (const Shape shape : {Shape::free, Shape::held}) {
    const Model m = model_of({shape});
    const double highest = m.form->omega.maxCoeff();
    const auto model = scaled_model(m.superelement, held_directions(shape), "test");
    for (const double share : {0.8, 1.1}) {
      const auto modes = model->clipped(share * highest);
      EXPECT_EQ(modes->method, "all modes");
      EXPECT_EQ(modes->part != nullptr, share < 1);
      EXPECT_LT((modes->omega - m.form->omega.head(modes->n_kept())).norm(), 1e-9 * highest);
    }
  }
}

}  // namespace
}  // namespace cbr::test::scaled_model_test

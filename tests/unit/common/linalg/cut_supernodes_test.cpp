// SPDX-License-Identifier: GPL-3.0-or-later

#include <gtest/gtest.h>

#include "common/linalg/sparse/symbolic_factor.hpp"

namespace cbr::test::cut_supernodes_test {
namespace {

using Indices = std::vector<Index>;

// Seven columns: supernode 0 of two columns above rows 4 and 5, supernode 1 of five columns above
// none.
struct Example {
  Indices super{0, 2, 7}, pi{0, 4, 9}, px{0, 8, 33}, rows{0, 1, 4, 5, 2, 3, 4, 5, 6};
  SupernodalFactor factor() const {
    SupernodalFactor f;
    f.n = 7;
    f.n_super = 2;
    f.super = super.data();
    f.pi = pi.data();
    f.px = px.data();
    f.rows = rows.data();
    return f;
  }
};

TEST(CutSupernodes, LeavesNarrowOnesAsTheyAre) {
  const Example example;
  const SupernodePattern made = cut_supernodes(example.factor(), 5);
  EXPECT_EQ(made.super, example.super);
  EXPECT_EQ(made.pi, example.pi);
  EXPECT_EQ(made.px, example.px);
  EXPECT_EQ(made.rows, example.rows);
}

TEST(CutSupernodes, PiecesBeginWithTheirOwnRowsOfTheSharedList) {
  const Example example;
  const SupernodePattern made = cut_supernodes(example.factor(), 2);
  EXPECT_EQ(made.super, (Indices{0, 2, 3, 5, 7}));
  EXPECT_EQ(made.pi, (Indices{0, 4, 9, 13, 15}));
  EXPECT_EQ(made.px, (Indices{0, 8, 13, 21, 25}));  // 25 entries instead of 33
  EXPECT_EQ(made.rows, (Indices{0, 1, 4, 5, 2, 3, 4, 5, 6, 3, 4, 5, 6, 5, 6}));
}

TEST(CutSupernodes, ASupernodeBeginsAtTheBoundary) {
  const Example example;
  const SupernodePattern made = cut_supernodes(example.factor(), 5, 3);
  EXPECT_EQ(made.super, (Indices{0, 2, 3, 7}));
  EXPECT_EQ(made.pi, (Indices{0, 4, 9, 13}));
  EXPECT_EQ(made.px, (Indices{0, 8, 13, 29}));
  EXPECT_EQ(made.rows, (Indices{0, 1, 4, 5, 2, 3, 4, 5, 6, 3, 4, 5, 6}));
  // What stands before it: the rows of columns 3 to 6 are left out, their values stay where they
  // are
  SupernodalFactor cut = example.factor();
  cut.n_super = 3;
  cut.super = made.super.data();
  cut.pi = made.pi.data();
  cut.px = made.px.data();
  cut.rows = made.rows.data();
  const SupernodePattern leading = leading_pattern(cut, 3);
  EXPECT_EQ(leading.super, (Indices{0, 2, 3}));
  EXPECT_EQ(leading.pi, (Indices{0, 2, 3}));
  EXPECT_EQ(leading.rows, (Indices{0, 1, 2}));
  cut.n = 3;
  cut.n_super = 2;
  cut.super = leading.super.data();
  cut.pi = leading.pi.data();
  cut.rows = leading.rows.data();
  EXPECT_EQ(cut.height(0), 2);
  EXPECT_EQ(cut.stride(0), 4);
  EXPECT_EQ(cut.stride(1), 5);
}

}  // namespace
}  // namespace cbr::test::cut_supernodes_test

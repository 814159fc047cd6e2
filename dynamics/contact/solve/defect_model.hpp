// SPDX-License-Identifier: GPL-3.0-or-later
// What a W that has changed does to impulses, from what it did to the last ones.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

class StateArchive;

// Pairs (p, (W - W_0) p) of some products tell of W - W_0 over their span; of the rest it is taken
// for 0. The newest pairs count, and what they span already tells nothing new.
class DefectModel {
 public:
  void add(const Vector& p, const Vector& defect);
  void predict(const Vector& p, Vector& defect);  // (W - W_0) p
  void keep_state(StateArchive& archive);
  void clear() { n_ = 0; }
  bool empty() const { return n_ == 0; }
  // Row i was row from[i] before, or is new: -1.
  void renumber(const std::vector<Index>& from);

 private:
  Index n_ = 0, newest_ = -1;  // pairs; column of the last
  Matrix p_, defect_;          // a ring of columns
  // columns of p made orthonormal, newest first, and the defects of these
  Matrix Q_, E_;
  Index rank_ = 0;
  void orthonormalise();
  Vector rest_;
};

}  // namespace cbr

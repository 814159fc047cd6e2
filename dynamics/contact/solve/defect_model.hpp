// SPDX-License-Identifier: GPL-3.0-or-later
// Model of the change of W, from its effect on the last impulses.
#pragma once

#include <vector>

#include "common/base/types.hpp"

namespace cbr {

class StateArchive;

// Pairs (p, (W - W_0) p) of recent products determine W - W_0 on their span; it is assumed 0
// outside. Newer pairs take precedence, and pairs within their span are ignored.
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
  Index n_ = 0, newest_ = -1;  // number of pairs; column of the last
  Matrix p_, defect_;          // a ring buffer of columns
  // orthonormalised columns of p, newest first, and their defects
  Matrix Q_, E_;
  Index rank_ = 0;
  void orthonormalise();
  Vector rest_;
};

}  // namespace cbr

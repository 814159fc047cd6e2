// SPDX-License-Identifier: GPL-3.0-or-later
// A component's modes below a clip frequency, and all modes above it as one (docs/theory.md, "Modal
// mass scaling").
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/motion/scaled/scaled_motion.hpp"

namespace cbr {

// What the modes above the clip do together, S = clip^2 sum of V_j V_j^T / omega_j^2 over them (n x
// n, component axes).
class ScaledPart {
 public:
  virtual ~ScaledPart() = default;
  virtual Matrix times(const Matrix& F) const = 0;  // S F, n x q
  // rows and columns of S; those of -1 are 0
  virtual Matrix block(const std::vector<Index>& coordinates) const = 0;
};

// The rows of a node set, shared by the instances of a component: dof 3 i + c, component axes.
class ScaledRows {
 public:
  // n_kept x 3 m, column 3 i + c is the modal row of the dof, contiguous
  Matrix Vt;
  std::shared_ptr<const Matrix> S;  // 3 m x 3 m, null when nothing is scaled
  Vector omega;                     // n_kept
  double clip = 0;

  // Vt^T diag(sin(omega h)/omega) Vt + sin(clip h)/clip S, with the gains of `contact_step`: how a
  // step of h answers impulses. Kept for the last two of them.
  std::shared_ptr<const Matrix> response(double h, double contact_step,
                                         const ScaledGain& gain) const;

 private:
  struct Response {
    double h = 0, contact_step = 0;
    std::shared_ptr<const Matrix> block;
  };
  mutable Response last_, other_;
};

// Coordinates: kept modes eta (omega, V), and r with r'' + clip^2 r = f, displacement V eta + S r.
// Not for several threads at once.
class ScaledModes {
 public:
  double clip = 0;           // rad/s
  Vector omega;              // n_kept, ascending; the first n_rigid are 0
  Matrix V;                  // n x n_kept
  Index n_rigid = 0;         // of the kept ones
  Matrix E;                  // n_kept x 6, V^T M^ R: rigid motions about the centre of mass
  Index n_scaled = 0;        // modes above the clip
  double lowest_scaled = 0;  // frequency of the first of them, rad/s; 0: none
  // S M^ R (n x 6) and (M^ R)^T S M^ R (6 x 6): what is left of rigid motions above the clip. Empty
  // for a free body, where it is 0.
  Matrix rigid_response, rigid_gram;
  // how the kept ones were found: "all modes", "block lanczos"
  std::string method;
  std::shared_ptr<const ScaledPart> part;  // null when nothing is scaled
  IndexTable rows;                         // of V, n_nodes x 3, -1 for none

  Index n_kept() const { return omega.size(); }
  double largest_frequency() const;  // of the scaled body
  std::shared_ptr<const ScaledRows> node_rows(const std::vector<Index>& nodes) const;

 private:
  mutable std::map<std::vector<Index>, std::shared_ptr<const ScaledRows>> node_rows_;
};

}  // namespace cbr

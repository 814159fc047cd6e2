// SPDX-License-Identifier: GPL-3.0-or-later
// Loads on a body: forces on its nodes and modes, which stay or turn with it, and gravity.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/motion/load_history.hpp"

namespace cbr {

// Forces on the nodes of a body, in the axes of their owner. Many loads may act on few nodes of
// many: rows of zeros are not kept.
class NodalForces {
 public:
  NodalForces() = default;  // none
  // NOLINTNEXTLINE(google-explicit-constructor): n_nodes x 3, they are what they are
  NodalForces(const Points& forces);
  explicit operator bool() const { return n_ > 0; }
  Points on_nodes() const;  // n_nodes x 3
  NodalForces& operator+=(const NodalForces& more) {
    return *this = Points(on_nodes() + more.on_nodes());
  }
  // f += factor times these
  void add_to(Eigen::Matrix<double, Eigen::Dynamic, 3>& f, double factor) const;

 private:
  Index n_ = 0;
  std::vector<Index> nodes_;
  Points forces_;
};

// These, and forces on the first of the modal coordinates of Body::coordinates() (empty:
// none), which a load inside a superelement has.
struct ForcePattern {
  NodalForces forces = {};
  Vector modal = {};
};

// sum_a b_a P_a. b is a vector in axes that turn with a body that turns: it is `value` where it
// follows the body, else what makes `value` in the scene's axes.
struct VectorForce {
  std::array<ForcePattern, 3> patterns;  // P_a
  Vector3 value = Vector3::Zero();
  bool follows = false;
};

// A load on a body: what is there of the three, times the history.
struct BodyLoad {
  ForcePattern fixed = {};  // of forces that stay in the scene's axes
  std::optional<VectorForce> vector = {};
  std::optional<Vector3> acceleration = {};  // of the whole body
  LoadHistory history = {};
};

BodyLoad force_load(const Points& forces, LoadHistory history = {});
BodyLoad gravity_load(const Vector3& acceleration, LoadHistory history = {});
// All its forces on a body that does not turn, of which b is `value`.
ForcePattern forces_of(const BodyLoad& load);
// InputError: forces on modal coordinates of a body that has none of its own.
void require_no_modal_forces(const BodyLoad& load, const std::string& name);

}  // namespace cbr

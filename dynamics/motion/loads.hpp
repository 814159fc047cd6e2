// SPDX-License-Identifier: GPL-3.0-or-later
// The history of a load, and the loads of a body. Copies share its points: a table of a million
// times may act on a thousand bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/base/types.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

// Value of a history at time t: linear between its points, constant outside, 1 when it has none.
double history_value(const History& history, double t);

class LoadHistory {
 public:
  LoadHistory() = default;       // 1 at all times, as one without points
  LoadHistory(History history);  // NOLINT(google-explicit-constructor): a history is one that
                                 // nobody shares yet
  LoadHistory(std::vector<double> time, std::vector<double> value)
      : LoadHistory(History{std::move(time), std::move(value)}) {}

  // Linear between its points, constant outside.
  double value(double t) const;
  double integral(double from, double to) const;  // of value(), from <= to
  // of value() times (t - from) / (to - from)
  double rising_integral(double from, double to) const;
  double largest() const { return of_ ? of_->largest : 1; }  // magnitude at any time
  // the first of its times above t; HUGE_VAL: none
  double next_bend(double t) const;
  bool has_points() const { return of_ != nullptr; }

  // The same points, wherever they stand.
  bool operator==(const LoadHistory& other) const;
  struct Hash {
    std::size_t operator()(const LoadHistory& history) const {
      return history.of_ ? history.of_->hash : 0;
    }
  };

 private:
  struct Shared {
    History points;
    double largest = 0;
    std::size_t hash = 0;
  };
  std::shared_ptr<const Shared> of_;
};

// Loads on a body, forces times histories: loads of one history are one load.
template <class Force>
class Loads {
 public:
  struct Load {
    Force force;
    LoadHistory history;
  };

  // Returns whether the history is new.
  bool add(const Force& force, const LoadHistory& history) {
    const auto [number, is_new] = numbers_.try_emplace(history, loads_.size());
    if (is_new) {
      loads_.push_back({force, history});
    } else {
      loads_[number->second].force += force;
    }
    return is_new;
  }

  bool empty() const { return loads_.empty(); }
  auto begin() const { return loads_.begin(); }
  auto end() const { return loads_.end(); }
  // f := their sum at t.
  void sum(double t, Force& f) const {
    f.setZero();
    for (const Load& load : loads_) f += load.history.value(t) * load.force;
  }

 private:
  std::vector<Load> loads_;
  std::unordered_map<LoadHistory, std::size_t, LoadHistory::Hash> numbers_;
};

// Times at which load histories bend.
class Breakpoints {
 public:
  // Each history once: every cut goes through all of them.
  void add(const LoadHistory& history) {
    if (history.has_points()) histories_.push_back(history);
  }

  // piece(from, to, whole) for the parts of [t, t + h] in which all histories are linear, in order;
  // `whole`: there is only one. Breakpoints that differ by round-off are one: no part is shorter
  // than 1e-9 h.
  template <class Piece>
  void cut(double t, double h, const Piece& piece) const {
    const double end = t + h, tolerance = 1e-9 * h;
    for (double from = t;;) {
      const double next = next_bend(from + tolerance);
      if (!(next < end - tolerance)) return piece(from, end, from == t);
      piece(from, next, false);
      from = next;
    }
  }

 private:
  double next_bend(double t) const {
    double next = HUGE_VAL;
    for (const LoadHistory& history : histories_) next = std::min(next, history.next_bend(t));
    return next;
  }

  std::vector<LoadHistory> histories_;
};

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

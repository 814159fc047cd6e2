// SPDX-License-Identifier: GPL-3.0-or-later
// The history of a load. Copies share its points: a table of a million times may act on a thousand
// bodies.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

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

// Which of a body's loads has a history: loads of one history are one load.
class LoadNumbers {
 public:
  // Number of the load with this history; `next`, which it then has from now on, when there is
  // none.
  std::size_t find_or_add(const LoadHistory& history, std::size_t next) {
    return numbers_.try_emplace(history, next).first->second;
  }

 private:
  std::unordered_map<LoadHistory, std::size_t, LoadHistory::Hash> numbers_;
};

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/loads.hpp"

#include <functional>
#include <string_view>
#include <utility>

#include "common/base/error.hpp"

namespace cbr {

double history_value(const History& history, double t) {
  if (history.time.empty()) return 1;
  if (t <= history.time.front()) return history.value.front();
  if (t >= history.time.back()) return history.value.back();
  const auto after =
      std::upper_bound(history.time.begin(), history.time.end(), t) - history.time.begin();
  const double t0 = history.time[after - 1], t1 = history.time[after];
  return history.value[after - 1] +
         (history.value[after] - history.value[after - 1]) * (t - t0) / (t1 - t0);
}

namespace {

std::size_t hash_of(const std::vector<double>& values) {
  return std::hash<std::string_view>()(
      {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)});
}

}  // namespace

LoadHistory::LoadHistory(History history) {
  if (history.time.empty()) return;
  auto shared = std::make_shared<Shared>();
  for (const double value : history.value)
    shared->largest = std::max(shared->largest, std::abs(value));
  shared->hash = 31 * hash_of(history.time) + hash_of(history.value);
  shared->points = std::move(history);
  of_ = std::move(shared);
}

double LoadHistory::value(double t) const { return of_ ? history_value(of_->points, t) : 1; }

double LoadHistory::integral(double from, double to) const {
  double sum = 0;
  for (double t = from; t < to;) {
    const double end = std::min(to, next_bend(t));
    sum += (end - t) * value(0.5 * (t + end));
    t = end;
  }
  return sum;
}

double LoadHistory::rising_integral(double from, double to) const {
  double sum = 0;
  for (double t = from; t < to;) {
    const double end = std::min(to, next_bend(t));
    const double rise = (t - from) / (to - from), end_rise = (end - from) / (to - from);
    // Simpson's rule: exact for what is linear times what is linear
    sum +=
        (end - t) / 6 *
        (value(t) * rise + 2 * value(0.5 * (t + end)) * (rise + end_rise) + value(end) * end_rise);
    t = end;
  }
  return sum;
}

double LoadHistory::next_bend(double t) const {
  if (!of_) return HUGE_VAL;
  const std::vector<double>& time = of_->points.time;
  const auto next = std::upper_bound(time.begin(), time.end(), t);
  return next == time.end() ? HUGE_VAL : *next;
}

bool LoadHistory::operator==(const LoadHistory& other) const {
  if (of_ == other.of_) return true;
  if (!of_ || !other.of_ || of_->hash != other.of_->hash) return false;
  return of_->points.time == other.of_->points.time && of_->points.value == other.of_->points.value;
}

NodalForces::NodalForces(const Points& forces) : n_(forces.rows()) {
  for (Index i = 0; i < n_; ++i)
    if (!forces.row(i).isZero(0)) nodes_.push_back(i);
  forces_ = forces(nodes_, Eigen::all);
}

Points NodalForces::on_nodes() const {
  Points all = Points::Zero(n_, 3);
  all(nodes_, Eigen::all) = forces_;
  return all;
}

void NodalForces::add_to(Eigen::Matrix<double, Eigen::Dynamic, 3>& f, double factor) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    f.row(nodes_[i]) += factor * forces_.row(static_cast<Index>(i));
}

BodyLoad force_load(const Points& forces, LoadHistory history) {
  return {.fixed = {forces}, .history = std::move(history)};
}

BodyLoad gravity_load(const Vector3& acceleration, LoadHistory history) {
  return {.acceleration = acceleration, .history = std::move(history)};
}

ForcePattern forces_of(const BodyLoad& load) {
  if (!load.vector) return load.fixed;
  Points forces = load.fixed.forces.on_nodes();
  Vector modal = load.fixed.modal;
  for (Index a = 0; a < 3; ++a) {
    const ForcePattern& pattern = load.vector->patterns[a];
    const double b = load.vector->value[a];
    const Points of_pattern = pattern.forces.on_nodes();
    if (forces.rows() == 0) forces.setZero(of_pattern.rows(), 3);
    if (b == 0) continue;
    if (of_pattern.rows() > 0) forces += b * of_pattern;
    if (pattern.modal.size() == 0) continue;
    if (modal.size() == 0) modal.setZero(pattern.modal.size());
    modal += b * pattern.modal;
  }
  return {forces, modal};
}

void require_no_modal_forces(const BodyLoad& load, const std::string& name) {
  bool any = load.fixed.modal.size() > 0;
  if (load.vector)
    for (const ForcePattern& pattern : load.vector->patterns) any |= pattern.modal.size() > 0;
  if (!any) return;
  throw InputError("instance '" + name +
                   "': a load on faces inside the part acts on superelements of basis "
                   "craig-bampton only: take the faces into the interface");
}

}  // namespace cbr

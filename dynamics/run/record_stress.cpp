// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>

#include <algorithm>
#include <optional>
#include <utility>

#include "common/fem/stress_values.hpp"
#include "dynamics/run/recorder.hpp"

namespace cbr {
namespace {

// The `n` elements with the largest von Mises stress; of equal ones the first.
void add_worst(const Matrix& elements, Index n, RunResult::OfScan& of) {
  std::vector<Index> order = first_numbers(elements.rows());
  const auto is_worse = [&](Index a, Index b) {
    const double s = elements(a, von_mises_column), t = elements(b, von_mises_column);
    return s != t ? s > t : a < b;
  };
  std::partial_sort(order.begin(), order.begin() + n, order.end(), is_worse);
  for (const Index e : std::vector<Index>(order.begin(), order.begin() + n)) {
    of.worst.push_back(e);
    of.worst_stress.push_back(elements(e, von_mises_column));
  }
}

// m x 4: von Mises, its time, largest and smallest principal stress
void add_extremes(const Matrix& values, double t, Matrix& extremes) {
  const Index first = von_mises_column + 1, last = n_stress_values - 1;
  if (extremes.size() == 0) {
    extremes.resize(values.rows(), 4);
    extremes << values.col(von_mises_column), Vector::Constant(values.rows(), t), values.col(first),
        values.col(last);
    return;
  }
  for (Index i = 0; i < values.rows(); ++i) {
    auto of = extremes.row(i);
    if (values(i, von_mises_column) > of[0]) {
      of[0] = values(i, von_mises_column);
      of[1] = t;
    }
    of[2] = std::max(of[2], values(i, first));
    of[3] = std::min(of[3], values(i, last));
  }
}

// For a body with large rotation, whose stress is in rotating axes   (6 m, xx yy zz xy yz xz of
// each)
Vector in_scene(Vector stress, const std::optional<Eigen::Vector4d>& orientation) {
  if (!orientation) return stress;
  const Eigen::Vector4d& q = *orientation;
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>> rows(stress.data(),
                                                                             stress.size() / 6, 6);
  rows = turned_stress(rows, Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix());
  return stress;
}

}  // namespace

const std::pair<Vector, Vector>& Recorder::coordinates(Index body) {
  const auto [found, is_new] = coordinates_.try_emplace(body);
  if (is_new) sim_.bodies[body]->coordinates(found->second.first, found->second.second);
  return found->second;
}

void Recorder::record_stress(double t) {
  for (std::size_t w = 0; w < sim_.watches.size(); ++w) {
    const Index body = sim_.watches[w].body;
    const Vector stress =
        in_scene(sim_.watches[w].stress(coordinates(body).first), last_[body].orientation);
    result_.watches[w].insert(result_.watches[w].end(), stress.begin(), stress.end());
  }
  Matrix elements, nodes;
  for (std::size_t i = 0; i < sim_.scans.size(); ++i) {
    const StressScan& scan = sim_.scans[i];
    scan.stresses(coordinates(scan.body).first, elements, nodes);
    if (!elements.allFinite() || !nodes.allFinite()) {
      not_finite_ = "stress of " + scan.name;
      return;
    }
    if (scan.n_worst > 0) add_worst(elements, scan.n_worst, result_.scans[i]);
    if (!scan.envelope) continue;
    add_extremes(elements, t, result_.scans[i].of_elements);
    add_extremes(nodes, t, result_.scans[i].of_nodes);
  }
}

}  // namespace cbr

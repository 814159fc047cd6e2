// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/broad_phase.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cbr {
namespace {

Box union_of(const std::vector<Box>& boxes) {
  Box all{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
  for (const Box& box : boxes) {
    all.lower = all.lower.cwiseMin(box.lower);
    all.upper = all.upper.cwiseMax(box.upper);
  }
  return all;
}

struct Grid {
  Box region;
  Vector3 inverse_cell = Vector3::Zero();
  std::array<Index, 3> n{1, 1, 1};

  std::array<Index, 6> range(const Box& box) const {
    std::array<Index, 6> r{};
    for (int c = 0; c < 3; ++c) {
      const auto cell = [&](double x) {
        const double position = (x - region.lower[c]) * inverse_cell[c];
        // NaN where divergent motion has made boxes infinite: any cell is valid
        return position > 0 ? static_cast<Index>(std::min(position, static_cast<double>(n[c] - 1)))
                            : Index{0};
      };
      r[c] = cell(box.lower[c]);
      r[c + 3] = cell(box.upper[c]);
    }
    return r;
  }
  Index size() const { return n[0] * n[1] * n[2]; }
};

template <typename Visit>
void for_cells(const Grid& grid, const Box& box, const Visit& visit) {
  const auto r = grid.range(box);
  for (Index z = r[2]; z <= r[5]; ++z)
    for (Index y = r[1]; y <= r[4]; ++y)
      for (Index x = r[0]; x <= r[3]; ++x) visit((z * grid.n[1] + y) * grid.n[0] + x);
}

// Cell size: about the mean size of the near targets. Number of cells: at most about four per
// target.
Grid make_grid(const Box& region, const std::vector<Box>& targets, const std::vector<Index>& near) {
  Grid grid;
  grid.region = region;
  Vector3 mean = Vector3::Zero();
  for (const Index t : near) mean += targets[t].upper - targets[t].lower;
  const double n_targets = static_cast<double>(near.size());
  mean /= n_targets;
  const Vector3 extent = region.upper - region.lower;
  const double limit = std::max(1.0, std::ceil(2 * std::sqrt(n_targets)));
  for (int c = 0; c < 3; ++c) {
    const double wanted = mean[c] > 0 ? std::floor(extent[c] / mean[c]) : 1.0;
    const double cells = wanted > 1 ? std::min(wanted, limit) : 1.0;
    grid.n[c] = static_cast<Index>(cells);
    grid.inverse_cell[c] = extent[c] > 0 ? cells / extent[c] : 0.0;
  }
  while (static_cast<double>(grid.size()) > 4 * n_targets + 64) {
    const auto widest = std::max_element(grid.n.begin(), grid.n.end()) - grid.n.begin();
    grid.n[widest] /= 2;
    grid.inverse_cell[widest] =
        extent[widest] > 0 ? static_cast<double>(grid.n[widest]) / extent[widest] : 0.0;
  }
  return grid;
}

void fill_cells(const Grid& grid, const std::vector<Box>& targets, BroadPhase& work) {
  work.cell_first.assign(grid.size() + 1, 0);
  for (const Index t : work.near_targets)
    for_cells(grid, targets[t], [&](Index cell) { ++work.cell_first[cell + 1]; });
  for (Index cell = 0; cell < grid.size(); ++cell)
    work.cell_first[cell + 1] += work.cell_first[cell];
  work.cell_target.resize(work.cell_first.back());
  std::vector<Index>& next = work.stamp;
  next.assign(work.cell_first.begin(), work.cell_first.end() - 1);
  for (const Index t : work.near_targets)
    for_cells(grid, targets[t], [&](Index cell) { work.cell_target[next[cell]++] = t; });
}

// Fills `near` with the boxes that meet the region; returns their bounding box.
Box select(const std::vector<Box>& boxes, const Box& region, std::vector<Index>& near) {
  Box span{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
  near.clear();
  for (Index i = 0; i < static_cast<Index>(boxes.size()); ++i) {
    if (!boxes[i].meets(region)) continue;
    near.push_back(i);
    span.lower = span.lower.cwiseMin(boxes[i].lower);
    span.upper = span.upper.cwiseMax(boxes[i].upper);
  }
  return span;
}

Box intersection(const Box& a, const Box& b) {
  return {a.lower.cwiseMax(b.lower), a.upper.cwiseMin(b.upper)};
}

}  // namespace

void find_candidates(const std::vector<Box>& queries, const std::vector<Box>& targets,
                     BroadPhase& work) {
  auto &first = work.candidates.first, &target = work.candidates.target;
  first.assign(queries.size() + 1, 0);
  target.clear();
  const Box q = union_of(queries), t = union_of(targets);
  if (queries.empty() || targets.empty() || !q.meets(t)) return;
  // Clips the region to the other side's boxes that reach into it
  Box region = intersection(q, t);
  const Box near_q = select(queries, region, work.near_queries);
  if (work.near_queries.empty()) return;
  region = intersection(region, near_q);
  const Box near_t = select(targets, region, work.near_targets);
  if (work.near_targets.empty()) return;
  region = intersection(region, near_t);
  const Grid grid = make_grid(region, targets, work.near_targets);
  fill_cells(grid, targets, work);
  work.stamp.assign(targets.size(), -1);
  Index filled = 0;  // the queries before this one have `first` set
  for (const Index i : work.near_queries) {
    for (; filled < i; ++filled) first[filled + 1] = static_cast<Index>(target.size());
    for_cells(grid, queries[i], [&](Index cell) {
      for (Index k = work.cell_first[cell]; k < work.cell_first[cell + 1]; ++k) {
        const Index candidate = work.cell_target[k];
        if (work.stamp[candidate] == i || !queries[i].meets(targets[candidate])) continue;
        work.stamp[candidate] = i;
        target.push_back(candidate);
      }
    });
    std::sort(target.begin() + first[i], target.end());
  }
  for (; filled < static_cast<Index>(queries.size()); ++filled)
    first[filled + 1] = static_cast<Index>(target.size());
}

}  // namespace cbr

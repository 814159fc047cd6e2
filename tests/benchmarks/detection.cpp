// SPDX-License-Identifier: GPL-3.0-or-later
// Microseconds a node of one search (detect() and remember()) over the number of contact nodes, all
// in contact:
//   still    a curved sheet on a curved sheet of other faces, the same step again and again
//   slide    the same, by 3 % of a face in each step
//   impact   flat sheets of the same faces, node on node; the prediction goes through by 1.2 faces,
//   again and again
// Seconds of one search of the curved sheets out of reach; and far away, with the sweep of both
// bodies (once for all their pairs) beside. Arguments: largest number of nodes (default 10000). CSV
// to stdout.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <vector>

#include "dynamics/contact/search/detection.hpp"
#include "tests/benchmarks/seconds.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace {

using cbr::Index;
using cbr::Vector3;

// Bent, so that faces are not flat: z += 0.05 x^2 + 0.03 x y
void bend(cbr::Points& points, double lift) {
  for (Index i = 0; i < points.rows(); ++i) {
    const double x = points(i, 0), y = points(i, 1);
    points(i, 2) = 0.05 * x * x + 0.03 * x * y + lift;
  }
}

// Two sheets that touch in all of the slave's nodes, and what their pair remembers.
struct Sheets {
  cbr::test::Patch slave, master;
  cbr::PairMemory memory;
  cbr::ContactList list;

  Sheets(int n_slave, int n_master, double master_size)
      : slave(cbr::test::patch(n_slave, 0, false)),
        master(cbr::test::patch(n_master, 0, true, master_size)) {
    slave.surface.body = 0;
    master.surface.body = 1;
  }
  void search(bool initial = false) {
    list.points.clear();
    list.terms.clear();
    cbr::detect(slave.surface, slave.body, master.surface, master.body, initial, {}, memory, list);
    const Index m = static_cast<Index>(list.points.size());
    cbr::remember(list, 0, list.points.size(), cbr::Points::Zero(m, 3), cbr::Points::Ones(m, 3),
                  1e-6 * master.surface.size, memory);
  }
  Index n_nodes() const { return slave.body.start.rows(); }
};

Sheets curved(int n) {
  Sheets s(n - 1, std::max(1, (4 * n) / 5), 1.1);
  s.slave.body.start.leftCols(2).array() += 0.037;
  bend(s.slave.body.start, 0);
  bend(s.master.body.start, 0);
  s.slave.body.end = s.slave.body.start;
  s.master.body.end = s.master.body.start;
  s.search(true);
  return s;
}

double still(Sheets& s, int repeats) {
  cbr::test::move(s.slave, Vector3(0, 0, -0.001 * s.slave.surface.size));
  s.search();
  return seconds(repeats, [&] { s.search(); });
}

// Mean of the steps until the slave is off the master, each the best of its repeats.
double slide(const Sheets& start, int repeats) {
  const Vector3 way = start.slave.surface.size * Vector3(0.03, 0.01, -0.001);
  std::vector<double> best(static_cast<std::size_t>(std::min(50.0, 0.06 / way[0])), HUGE_VAL);
  for (int i = 0; i < repeats; ++i) {
    Sheets s = start;
    for (double& t : best) {
      cbr::test::move(s.slave, way);
      t = std::min(t, seconds(1, [&] { s.search(); }));
      s.slave.body.start = s.slave.body.end;
      bend(s.slave.body.start, 0);
    }
  }
  return std::accumulate(best.begin(), best.end(), 0.0) / static_cast<double>(best.size());
}

double impact(int n, int repeats) {
  Sheets s(n - 1, n - 1, 1);
  s.search(true);
  cbr::test::move(s.slave, Vector3(0, 0, -0.7 * s.slave.surface.size));
  cbr::test::move(s.master, Vector3(0, 0, 0.5 * s.slave.surface.size));
  s.search();
  return seconds(repeats, [&] { s.search(); });
}

void row(int n) {
  const int repeats = std::clamp(200000 / (n * n), 3, 100);
  Sheets s = curved(n);
  const double per_node = 1e6 / static_cast<double>(s.n_nodes());
  const double t_slide = slide(s, 10), t_still = still(s, repeats), t_impact = impact(n, repeats);
  const std::size_t points = s.list.points.size();
  bend(s.slave.body.start, 10 * s.slave.surface.size);
  s.slave.body.end = s.slave.body.start;
  const double t_near = seconds(repeats, [&] { s.search(); });
  s.slave.body.start.col(2).array() += 3;
  s.slave.body.end.col(2).array() += 3;
  const double t_sweep = seconds(repeats, [&] {
    cbr::sweep(s.slave.body);
    cbr::sweep(s.master.body);
  });
  const double t_far = seconds(repeats, [&] { s.search(); });
  std::printf("%lld,%lld,%zu,%.3g,%.3g,%.3g,%.3g,%.3g,%.3g\n", static_cast<long long>(s.n_nodes()),
              static_cast<long long>(s.master.surface.faces.rows()), points, t_still * per_node,
              t_slide * per_node, t_impact * per_node, t_near, t_sweep, t_far);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double largest = argc > 1 ? std::atof(argv[1]) : 10000;
  std::printf("nodes,faces,points,still_us,slide_us,impact_us,near,sweep,far\n");
  for (double nodes = 100; nodes <= largest * 1.001; nodes *= std::sqrt(10.0))
    row(static_cast<int>(std::lround(std::sqrt(nodes))));
  return 0;
}

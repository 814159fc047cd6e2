// SPDX-License-Identifier: GPL-3.0-or-later
// Seconds of one search (detect() and remember()) over the number of contact nodes: a curved sheet that slides on a curved sheet,
// all nodes in contact; the same out of reach; and far away, with the sweep of both bodies (once for all their pairs) beside.
// Arguments: largest number of nodes (default 10000). CSV to stdout.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "dynamics/contact/detection.hpp"
#include "tests/unit/dynamics/patch.hpp"

namespace {

using cbr::Index;
using cbr::Vector3;

double seconds(int repeats, const auto& work) {
  double best = HUGE_VAL;
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

// Bent, so that faces are not flat: z += 0.05 x^2 + 0.03 x y
void bend(cbr::test::Patch& p, double lift) {
  for (Index i = 0; i < p.body.start.rows(); ++i) {
    const double x = p.body.start(i, 0), y = p.body.start(i, 1);
    p.body.start(i, 2) = 0.05 * x * x + 0.03 * x * y + lift;
  }
  p.body.end = p.body.start;
}

void row(int n) {
  cbr::test::Patch slave = cbr::test::patch(n - 1, 0, false), master = cbr::test::patch(std::max(1, (4 * n) / 5), 0, true, 1.1);
  slave.body.start.leftCols(2).array() += 0.037;
  bend(slave, 0), bend(master, 0);
  slave.surface.body = 0, master.surface.body = 1;
  const double size = 1.0 / n;
  cbr::PairMemory memory, fresh;
  cbr::ContactList list;
  const auto search = [&](bool initial, cbr::PairMemory& of) {
    list.points.clear(), list.terms.clear();
    cbr::detect(slave.surface, slave.body, master.surface, master.body, initial, {}, of, list);
    const Index m = static_cast<Index>(list.points.size());
    cbr::remember(list, 0, list.points.size(), cbr::Points::Zero(m, 3), cbr::Points::Ones(m, 3), 1e-6 * size, of);
  };
  search(true, memory);
  cbr::test::move(slave, Vector3(0.03 * size, 0.01 * size, -0.001 * size));
  const int repeats = std::clamp(200000 / (n * n), 3, 100);
  const double t_contact = seconds(repeats, [&] { search(false, memory); });
  const std::size_t points = list.points.size();
  bend(slave, 10 * size);
  const double t_near = seconds(repeats, [&] { search(false, fresh); });
  slave.body.start.col(2).array() += 3, slave.body.end.col(2).array() += 3;
  const double t_sweep = seconds(repeats, [&] { cbr::sweep(slave.body), cbr::sweep(master.body); });
  const double t_far = seconds(repeats, [&] { search(false, fresh); });
  std::printf("%d,%lld,%zu,%.3g,%.3g,%.3g,%.3g,%.3g\n", n * n, static_cast<long long>(master.surface.faces.rows()), points,
              t_contact, 1e6 * t_contact / (n * n), t_near, t_sweep, t_far);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double largest = argc > 1 ? std::atof(argv[1]) : 10000;
  std::printf("nodes,faces,points,contact,contact_us_per_node,near,sweep,far\n");
  for (double nodes = 100; nodes <= largest * 1.001; nodes *= std::sqrt(10.0)) row(static_cast<int>(std::lround(std::sqrt(nodes))));
  return 0;
}

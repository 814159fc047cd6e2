// SPDX-License-Identifier: GPL-3.0-or-later
// One mortar search of two sheets of n x n faces that do not match, against the node-face search of
// the same. Argument: largest n (default 90). CSV to stdout: faces of a side, distortion, seconds a
// search (best of some), points, terms.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "../unit/dynamics/face_grid.hpp"
#include "dynamics/contact/search/mortar.hpp"

namespace {

template <typename Search>
double seconds(const Search& search) {
  double best = HUGE_VAL;
  for (int i = 0; i < 7; ++i) {
    const auto start = std::chrono::steady_clock::now();
    search();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  using cbr::test::GridFaces;
  const int largest = argc > 1 ? std::atoi(argv[1]) : 90;
  std::printf("faces,distortion,gap,search,seconds,points,terms\n");
  for (const int n : {10, 45, 90}) {
    if (n > largest) break;
    for (const double distortion : {0.0, 0.02, 0.15}) {
      for (const double gap : {0.0, 0.1}) {
        auto slave = cbr::test::face_grid(n, n, false, GridFaces::quads, distortion, 1);
        auto master = cbr::test::face_grid(n, n, true, GridFaces::quads, distortion, 2);
        cbr::test::transform(slave, cbr::test::turn(0.3), cbr::Vector3(0.1, 0.05, gap / n));
        slave.surface.body = 0;
        master.surface.body = 1;
        cbr::PairMemory memory, other;
        cbr::ContactList list;
        const double mortar = seconds([&] {
          list = {};
          cbr::detect_mortar(slave.surface, slave.body, master.surface, master.body, false, {},
                             memory, list);
        });
        std::printf("%d,%g,%g,mortar,%.6f,%zu,%zu\n", n * n, distortion, gap, mortar,
                    list.points.size(), list.terms.size());
        const double node_face = seconds([&] {
          list = {};
          cbr::detect(slave.surface, slave.body, master.surface, master.body, false, {}, other,
                      list);
        });
        std::printf("%d,%g,%g,node-face,%.6f,%zu,%zu\n", n * n, distortion, gap, node_face,
                    list.points.size(), list.terms.size());
      }
    }
  }
}

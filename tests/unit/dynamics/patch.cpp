// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/patch.hpp"

namespace cbr::test {

Patch patch(int n, double z, bool up, double size) {
  Patch p;
  Points x((n + 1) * (n + 1), 3);
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i)
      x.row(j * (n + 1) + i) << size * double(i) / n, size * double(j) / n, z;
  p.surface.faces.resize(n * n, 4);
  for (Index j = 0, f = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i, ++f) {
      const Index a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if (up) {
        p.surface.faces.row(f) << a, b, c, d;
      } else {
        p.surface.faces.row(f) << a, d, c, b;
      }
    }
  }
  for (Index i = 0; i < x.rows(); ++i) p.surface.nodes.push_back(i);
  p.body.start = p.body.end = x;
  fill_sizes(p.surface, x);
  return p;
}

Patch box(int n, double size, double height) {
  Patch p;
  const Index m = n + 1;
  Points x(2 * m * m, 3);
  for (Index k = 0; k < 2; ++k)
    for (Index j = 0; j < m; ++j)
      for (Index i = 0; i < m; ++i)
        x.row((k * m + j) * m + i) << size * double(i) / n, size * double(j) / n,
            k == 0 ? -height : 0.0;
  const auto node = [&](Index i, Index j, Index k) { return (k * m + j) * m + i; };
  std::vector<std::array<Index, 4>> faces;
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      faces.push_back({node(i, j, 1), node(i + 1, j, 1), node(i + 1, j + 1, 1), node(i, j + 1, 1)});
      faces.push_back({node(i, j, 0), node(i, j + 1, 0), node(i + 1, j + 1, 0), node(i + 1, j, 0)});
    }
    faces.push_back({node(0, j, 0), node(0, j, 1), node(0, j + 1, 1), node(0, j + 1, 0)});
    faces.push_back({node(n, j, 0), node(n, j + 1, 0), node(n, j + 1, 1), node(n, j, 1)});
    faces.push_back({node(j, 0, 0), node(j + 1, 0, 0), node(j + 1, 0, 1), node(j, 0, 1)});
    faces.push_back({node(j, n, 0), node(j, n, 1), node(j + 1, n, 1), node(j + 1, n, 0)});
  }
  p.surface.faces.resize(static_cast<Index>(faces.size()), 4);
  for (Index f = 0; f < p.surface.faces.rows(); ++f)
    for (int a = 0; a < 4; ++a) p.surface.faces(f, a) = faces[f][a];
  for (Index i = 0; i < x.rows(); ++i) p.surface.nodes.push_back(i);
  p.body.start = p.body.end = x;
  fill_sizes(p.surface, x);
  return p;
}

ContactList run(const Patch& slave, const Patch& master, PairMemory& memory, bool initial) {
  ContactList list;
  detect(slave.surface, slave.body, master.surface, master.body, initial, {}, memory, list);
  return list;
}

}  // namespace cbr::test

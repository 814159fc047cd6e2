// SPDX-License-Identifier: GPL-3.0-or-later
// Flat patches of quads that move as told: contact surfaces without bodies.
#pragma once

#include "dynamics/contact/contact_surface.hpp"

namespace cbr::test {

struct Patch {
  ContactSurface surface;
  ContactBody body;
};

// n x n quads on the square from the origin in the plane z, normal up or down.
inline Patch patch(int n, double z, bool up, double size = 1) {
  Patch p;
  Points x((n + 1) * (n + 1), 3);
  for (Index j = 0; j <= n; ++j)
    for (Index i = 0; i <= n; ++i) x.row(j * (n + 1) + i) << size * double(i) / n, size * double(j) / n, z;
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

inline void move(Patch& p, const Vector3& d) { p.body.end = p.body.start.rowwise() + d.transpose(); }

}  // namespace cbr::test

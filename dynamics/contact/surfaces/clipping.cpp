// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/clipping.hpp"

#include <cassert>

namespace cbr {
namespace {

// Clips to the half-plane on the left of the line from `from` to `to`.
void keep_left(const Vector2& from, const Vector2& to, Polygon& polygon) {
  const Vector2 along = to - from;
  std::array<double, 12> side;
  bool all = true;
  for (int i = 0; i < polygon.n; ++i) {
    side[i] = cross(along, polygon.x[i] - from);
    all = all && side[i] >= 0;
  }
  if (all) return;
  Polygon result;
  for (int i = 0; i < polygon.n; ++i) {
    const int next = i + 1 < polygon.n ? i + 1 : 0;
    const bool in = side[i] >= 0, next_in = side[next] >= 0;
    // Round-off may make a polygon without area concave, with a growing number of corners: it is
    // empty
    if (result.n + 2 > static_cast<int>(result.x.size()) && next > 0 && in != next_in)
      return void(polygon.n = 0);
    if (in) result.x[result.n++] = polygon.x[i];
    if (in != next_in) {
      const double t = side[i] / (side[i] - side[next]);
      result.x[result.n++] = polygon.x[i] + t * (polygon.x[next] - polygon.x[i]);
    }
  }
  polygon = result;
}

}  // namespace

double area(const Polygon& polygon) {
  double twice = 0;
  for (int i = 2; i < polygon.n; ++i)
    twice += cross(polygon.x[i - 1] - polygon.x[0], polygon.x[i] - polygon.x[0]);
  return 0.5 * twice;
}

Polygon clip(const Polygon& a, const Polygon& b) {
  assert(a.n + b.n <= 12);
  Polygon result = a;
  for (int i = 0; i < b.n && result.n >= 3; ++i)
    keep_left(b.x[i], b.x[i + 1 < b.n ? i + 1 : 0], result);
  return result;
}

}  // namespace cbr

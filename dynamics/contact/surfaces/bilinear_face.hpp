// SPDX-License-Identifier: GPL-3.0-or-later
// Bilinear map of a quad face, by its two sides and its twist.
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

// p(xi, eta) = c + xi a + eta b + xi eta w, |xi|, |eta| <= 1
struct BilinearFace {
  Vector3 c, a, b, w;
  explicit BilinearFace(const FaceCorners& x)
      : c((x[0] + x[1] + x[2] + x[3]) / 4),
        a((-x[0] + x[1] + x[2] - x[3]) / 4),
        b((-x[0] - x[1] + x[2] + x[3]) / 4),
        w((x[0] - x[1] + x[2] - x[3]) / 4) {}
  Vector3 at(double xi, double eta) const { return c + xi * a + eta * b + xi * eta * w; }
  Vector3 d_xi(double eta) const { return a + eta * w; }
  Vector3 d_eta(double xi) const { return b + xi * w; }
};

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Flat patches of quads with prescribed motion: contact surfaces without bodies.
#pragma once

#include "dynamics/contact/search/detection.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr::test {

struct Patch {
  ContactSurface surface;
  ContactBody body;
};

// n x n quads on the square from the origin in the plane z, normal up or down.
Patch patch(int n, double z, bool up, double size = 1);

inline void move(Patch& p, const Vector3& d) {
  p.body.end = p.body.start.rowwise() + d.transpose();
}

// A box with its top in the plane z = 0, all six faces outward, n x n quads each: one surface.
Patch box(int n, double size, double height);

ContactList run(const Patch& slave, const Patch& master, PairMemory& memory, bool initial = false);

}  // namespace cbr::test

// SPDX-License-Identifier: GPL-3.0-or-later
// Flat surfaces of quads and triangles, for contact tests.
#pragma once

#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr::test {

struct FaceGrid {
  ContactSurface surface;
  ContactBody body;  // start = end
};

enum class GridFaces { quads, triangles, mixed };

// nx x ny faces over [0, 1]^2 in the plane z = 0, normal up or down. `distortion`: random
// displacement of nodes in the plane, relative to a face; rim nodes stay on the rim.
FaceGrid face_grid(int nx, int ny, bool up, GridFaces kind = GridFaces::quads,
                   double distortion = 0, unsigned seed = 1);

// Maps all of it by x -> R x + d.
void transform(FaceGrid& grid, const Matrix3& R, const Vector3& d);

inline void shift(FaceGrid& grid, const Vector3& d) { transform(grid, Matrix3::Identity(), d); }

Matrix3 turn(double angle, const Vector3& axis = Vector3::UnitZ());

// Sets the predicted motion of the step.
inline void move(FaceGrid& grid, const Vector3& d) {
  grid.body.end = grid.body.start.rowwise() + d.transpose();
}

}  // namespace cbr::test

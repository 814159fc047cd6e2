// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/face_grid.hpp"

#include <Eigen/Geometry>

#include <random>

namespace cbr::test {

FaceGrid face_grid(int nx, int ny, bool up, GridFaces kind, double distortion, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  FaceGrid grid;
  Points x((nx + 1) * (ny + 1), 3);
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const double dx = distortion * unit(random) / nx, dy = distortion * unit(random) / ny;
      x.row(j * (nx + 1) + i) << double(i) / nx + (i > 0 && i < nx ? dx : 0),
          double(j) / ny + (j > 0 && j < ny ? dy : 0), 0;
    }
  }
  std::vector<std::array<Index, 4>> faces;
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const Index a = j * (nx + 1) + i, b = a + 1, c = b + nx + 1, d = a + nx + 1;
      if (kind == GridFaces::quads || (kind == GridFaces::mixed && (i + j) % 2)) {
        faces.push_back({a, b, c, d});
      } else if (i % 2) {
        faces.push_back({a, b, c, c});
        faces.push_back({a, c, d, d});
      } else {
        faces.push_back({a, b, d, d});
        faces.push_back({b, c, d, d});
      }
    }
  }
  grid.surface.faces.resize(static_cast<Index>(faces.size()), 4);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    auto [a, b, c, d] = faces[f];
    const bool triangle = c == d;
    if (!up) std::swap(b, triangle ? c : d);
    grid.surface.faces.row(static_cast<Index>(f)) << a, b, c, triangle ? c : d;
  }
  for (Index i = 0; i < x.rows(); ++i) grid.surface.nodes.push_back(i);
  grid.body.start = grid.body.end = x;
  fill_sizes(grid.surface, x);
  return grid;
}

void transform(FaceGrid& grid, const Matrix3& R, const Vector3& d) {
  grid.body.start = (grid.body.start * R.transpose()).rowwise() + d.transpose();
  grid.body.end = (grid.body.end * R.transpose()).rowwise() + d.transpose();
  fill_sizes(grid.surface, grid.body.end);
}

Matrix3 turn(double angle, const Vector3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

}  // namespace cbr::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/face_weights.hpp"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <vector>

namespace cbr {
namespace {

// Shape functions of a face at a point and their two derivatives; n entries each.
struct Shape {
  std::array<double, 9> N{}, d1{}, d2{};
};

Shape triangle_shape(int n, double r, double s) {
  Shape f;
  const std::array<double, 3> L{1 - r - s, r, s}, a{-1, 1, 0}, b{-1, 0, 1};
  for (int i = 0; i < 3; ++i) {
    f.N[i] = n == 3 ? L[i] : L[i] * (2 * L[i] - 1);
    const double slope = n == 3 ? 1 : 4 * L[i] - 1;
    f.d1[i] = slope * a[i];
    f.d2[i] = slope * b[i];
  }
  for (int i = 0; n == 6 && i < 3; ++i) {
    const int j = (i + 1) % 3;
    f.N[3 + i] = 4 * L[i] * L[j];
    f.d1[3 + i] = 4 * (a[i] * L[j] + L[i] * a[j]);
    f.d2[3 + i] = 4 * (b[i] * L[j] + L[i] * b[j]);
  }
  return f;
}

// Four nodes bilinear, eight serendipity (corners, then mid-sides).
Shape quad_shape(int n, double r, double s) {
  Shape f;
  constexpr std::array<double, 4> x{-1, 1, 1, -1}, y{-1, -1, 1, 1};
  for (int i = 0; i < 4; ++i) {
    const double u = 1 + x[i] * r, v = 1 + y[i] * s;
    if (n == 4) {
      f.N[i] = 0.25 * u * v;
      f.d1[i] = 0.25 * x[i] * v;
      f.d2[i] = 0.25 * u * y[i];
    } else {
      const double w = x[i] * r + y[i] * s - 1;
      f.N[i] = 0.25 * u * v * w;
      f.d1[i] = 0.25 * x[i] * v * (w + u);
      f.d2[i] = 0.25 * y[i] * u * (w + v);
    }
  }
  for (int i = 0; n == 8 && i < 4; ++i) {
    // the coordinate that is constant on the side: s on 0 and 2, r on 1 and 3
    const double side = i == 0 || i == 3 ? -1 : 1;
    if (i % 2 == 0) {
      f.N[4 + i] = 0.5 * (1 - r * r) * (1 + side * s);
      f.d1[4 + i] = -r * (1 + side * s);
      f.d2[4 + i] = 0.5 * (1 - r * r) * side;
    } else {
      f.N[4 + i] = 0.5 * (1 + side * r) * (1 - s * s);
      f.d1[4 + i] = 0.5 * side * (1 - s * s);
      f.d2[4 + i] = -s * (1 + side * r);
    }
  }
  return f;
}

// Nine nodes, biquadratic: corners, mid-sides, centre.
Shape biquadratic_shape(double r, double s) {
  constexpr std::array<int, 9> column{0, 2, 2, 0, 1, 2, 1, 0, 1}, row{0, 0, 2, 2, 0, 1, 2, 1, 1};
  const auto along = [](double t) {
    return std::array<double, 3>{0.5 * t * (t - 1), 1 - t * t, 0.5 * t * (t + 1)};
  };
  const auto slope = [](double t) { return std::array<double, 3>{t - 0.5, -2 * t, t + 0.5}; };
  const auto a = along(r), b = along(s), da = slope(r), db = slope(s);
  Shape f;
  for (int i = 0; i < 9; ++i) {
    f.N[i] = a[column[i]] * b[row[i]];
    f.d1[i] = da[column[i]] * b[row[i]];
    f.d2[i] = a[column[i]] * db[row[i]];
  }
  return f;
}

// visit(shape, nodes of the face, n dA): quadrature points, the area vector of each outward.
template <typename Visit>
void for_each_point(const Surface& surface, const Points& x, const Visit& visit) {
  // Six points, degree 4 (Dunavant 1985), for a triangle; three by three for a quad.
  constexpr double a = 0.445948490915965, b = 0.091576213509771, wa = 0.223381589678011 / 2,
                   wb = 0.109951743655322 / 2;
  const std::array<std::array<double, 3>, 6> in_triangle{{{a, a, wa},
                                                          {1 - 2 * a, a, wa},
                                                          {a, 1 - 2 * a, wa},
                                                          {b, b, wb},
                                                          {1 - 2 * b, b, wb},
                                                          {b, 1 - 2 * b, wb}}};
  const double g = std::sqrt(0.6);
  const std::array<double, 3> at{-g, 0, g}, weight{5.0 / 9, 8.0 / 9, 5.0 / 9};
  for (Index f = 0; f < surface.n_faces(); ++f) {
    const std::vector<Index> nodes = nodes_of_face(surface, f);
    const auto n = static_cast<int>(nodes.size());
    const auto point = [&](const Shape& shape, double factor) {
      Vector3 t1 = Vector3::Zero(), t2 = Vector3::Zero();
      for (int i = 0; i < n; ++i) {
        t1 += shape.d1[i] * x.row(nodes[i]).transpose();
        t2 += shape.d2[i] * x.row(nodes[i]).transpose();
      }
      visit(shape, nodes, Vector3(factor * t1.cross(t2)));
    };
    if (n == 3 || n == 6) {
      for (const auto& p : in_triangle) point(triangle_shape(n, p[0], p[1]), p[2]);
      continue;
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        point(n == 9 ? biquadratic_shape(at[i], at[j]) : quad_shape(n, at[i], at[j]),
              weight[i] * weight[j]);
  }
}

}  // namespace

Vector face_weights(const Surface& surface, const Points& coordinates) {
  Vector sum = Vector::Zero(coordinates.rows());
  for_each_point(surface, coordinates,
                 [&](const Shape& shape, const auto& nodes, const Vector3& area) {
                   for (std::size_t i = 0; i < nodes.size(); ++i)
                     sum[nodes[i]] += shape.N[i] * area.norm();
                 });
  return sum;
}

Points face_normals(const Surface& surface, const Points& coordinates) {
  Points sum = Points::Zero(coordinates.rows(), 3);
  for_each_point(surface, coordinates,
                 [&](const Shape& shape, const auto& nodes, const Vector3& area) {
                   for (std::size_t i = 0; i < nodes.size(); ++i)
                     sum.row(nodes[i]) += shape.N[i] * area.transpose();
                 });
  return sum;
}

SparseMatrix face_mass(const Surface& surface, const Points& coordinates) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for_each_point(
      surface, coordinates, [&](const Shape& shape, const auto& nodes, const Vector3& area) {
        for (std::size_t i = 0; i < nodes.size(); ++i)
          for (std::size_t j = 0; j < nodes.size(); ++j)
            entries.emplace_back(nodes[i], nodes[j], shape.N[i] * shape.N[j] * area.norm());
      });
  SparseMatrix M(coordinates.rows(), coordinates.rows());
  M.setFromTriplets(entries.begin(), entries.end());
  return M;
}

}  // namespace cbr

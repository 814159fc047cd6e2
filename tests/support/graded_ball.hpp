// SPDX-License-Identifier: GPL-3.0-or-later
// A ball of hexes, graded towards one point of its surface, for Hertz contact.
#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/fem/elements/element.hpp"
#include "common/mesh/mesh.hpp"

namespace cbr::test {

struct BallOptions {
  double radius = 10;
  // half width of the uniform patch at the contact point, with elements of width 2 core / m
  double core = 0.5;
  // elements across the patch (even); a quarter of the azimuth has m elements everywhere
  Index m = 8;
  Index shells = 14;     // between the patch and the far side
  Index cap_shells = 2;  // number of rings around the patch in sideset `contact`
  bool quarter = false;  // x >= 0 and y >= 0 only, with nodesets `x_plane` and `y_plane`
};

namespace ball_detail {

constexpr double bulge = 0.35;  // 0: the core is a half cube, 1: a half ball with bad corners

// Outward scaling factor of a point on the half cube's surface.
inline double outward(const Vector3& p) { return (1 - bulge) * 0.85 + bulge / p.norm(); }

// Maps the half space Z > 0 to the ball of radius R with its lowest point at the origin. As an
// inversion it preserves angles, and lengths near the origin. Infinity becomes the far pole.
inline Vector3 half_space_to_ball(const Vector3& x, double R) {
  const Vector3 centre(0, 0, -2 * R), d = x - centre;
  Vector3 y = centre + 4 * R * R * d / d.squaredNorm();
  y.z() = -y.z();
  return y;
}

// One lattice point of the half cube [-1, 1]^2 x [0, 1], at equal angles, and its layer. -1: inside
// or on the near core; s: its copy on shell s; L + 1: in the far core.
struct Lattice {
  BallOptions o;
  double rho0, rho1;
  explicit Lattice(const BallOptions& options)
      : o(options), rho0(options.core), rho1(5 * options.radius) {}

  Vector3 point(Index i, Index j, Index k) const {
    const auto at = [&](Index a) {
      return std::tan(std::numbers::pi / 4 * (2 * double(a) / double(o.m) - 1));
    };
    return {at(i), at(j), std::tan(std::numbers::pi / 4 * 2 * double(k) / double(o.m))};
  }
  Vector3 in_core(const Vector3& p, double rho) const {
    const double q = p.lpNorm<Eigen::Infinity>();
    if (q == 0) return p;
    return rho * p * ((1 - q * q) * (0.85 * (1 - bulge) + bulge) + q * q * outward(p / q));
  }
  // Shells change from box to ball and back to a box, which is the far core under the inversion.
  Vector3 on_shell(const Vector3& p, Index s) const {
    const double t = double(s) / double(o.shells);
    const auto fade = [](double a) { return a > 0.5 ? 0.0 : (1 - 2 * a) * (1 - 2 * a); };
    const double box = std::log(outward(p) * p.norm());
    return p.normalized() *
           std::exp(std::log(rho0) + t * std::log(rho1 / rho0) + (fade(t) - fade(1 - t)) * box);
  }
  Vector3 near_core_node(const Vector3& p) const {
    return half_space_to_ball(in_core(p, rho0), o.radius);
  }
  Vector3 far_core_node(const Vector3& p) const {
    Vector3 y = half_space_to_ball(in_core(p, 4 * o.radius * o.radius / rho1), o.radius);
    y.z() = 2 * o.radius - y.z();
    return y;
  }
};

struct Builder {
  Lattice lattice;
  std::vector<Vector3> x;
  std::vector<char> outer, x_plane, y_plane;
  std::vector<std::array<Index, 8>> hexes;
  // of each hex: 0 the near core, s the shell below s, shells + 1 the far core
  std::vector<Index> layer;
  Index lo, m, n_k;  // lattice points lo .. m, lo .. m, 0 .. n_k
  explicit Builder(const BallOptions& o)
      : lattice(o), lo(o.quarter ? o.m / 2 : 0), m(o.m), n_k(o.m / 2) {}

  Index add(const Vector3& place, Index i, Index j, Index k) {
    x.push_back(place);
    outer.push_back(k == 0);
    x_plane.push_back(2 * i == m);
    y_plane.push_back(2 * j == m);
    return static_cast<Index>(x.size()) - 1;
  }
  bool on_box(Index i, Index j, Index k) const {
    return (lo == 0 && (i == 0 || j == 0)) || i == m || j == m || k == n_k;
  }
  std::size_t key(Index i, Index j, Index k) const {
    return static_cast<std::size_t>((i * (m + 1) + j) * (n_k + 1) + k);
  }
  template <class F>
  void each_point(F f) const {
    for (Index i = lo; i <= m; ++i)
      for (Index j = lo; j <= m; ++j)
        for (Index k = 0; k <= n_k; ++k) f(i, j, k);
  }
  void add_cells(const std::vector<Index>& node, Index of_layer) {
    for (Index i = lo; i < m; ++i)
      for (Index j = lo; j < m; ++j)
        for (Index k = 0; k < n_k; ++k) {
          const auto n = [&](Index a, Index b, Index c) { return node[key(i + a, j + b, k + c)]; };
          hexes.push_back({n(0, 0, 0), n(1, 0, 0), n(1, 1, 0), n(0, 1, 0), n(0, 0, 1), n(1, 0, 1),
                           n(1, 1, 1), n(0, 1, 1)});
          layer.push_back(of_layer);
        }
  }
  void add_shell(const std::vector<Index>& a, const std::vector<Index>& b, Index s) {
    const auto quad = [&](std::array<std::size_t, 4> k) {
      hexes.push_back({a[k[0]], a[k[1]], a[k[2]], a[k[3]], b[k[0]], b[k[1]], b[k[2]], b[k[3]]});
      layer.push_back(s);
    };
    for (Index i = lo; i < m; ++i) {
      for (Index j = lo; j < m; ++j)
        quad({key(i, j, n_k), key(i + 1, j, n_k), key(i + 1, j + 1, n_k), key(i, j + 1, n_k)});
      for (Index k = 0; k < n_k; ++k) {
        for (const Index end : lo == 0 ? std::vector<Index>{0, m} : std::vector<Index>{m}) {
          quad({key(end, i, k), key(end, i + 1, k), key(end, i + 1, k + 1), key(end, i, k + 1)});
          quad({key(i, end, k), key(i + 1, end, k), key(i + 1, end, k + 1), key(i, end, k + 1)});
        }
      }
    }
  }
  void build() {
    std::vector<Index> below((m + 1) * (m + 1) * (n_k + 1), -1), above = below;
    each_point([&](Index i, Index j, Index k) {
      below[key(i, j, k)] = add(lattice.near_core_node(lattice.point(i, j, k)), i, j, k);
    });
    add_cells(below, 0);
    for (Index s = 1; s <= lattice.o.shells; ++s) {
      each_point([&](Index i, Index j, Index k) {
        if (!on_box(i, j, k)) return;
        const Vector3 place =
            half_space_to_ball(lattice.on_shell(lattice.point(i, j, k), s), lattice.o.radius);
        above[key(i, j, k)] = add(place, i, j, k);
      });
      add_shell(below, above, s);
      below = above;
    }
    each_point([&](Index i, Index j, Index k) {
      if (!on_box(i, j, k))
        below[key(i, j, k)] = add(lattice.far_core_node(lattice.point(i, j, k)), i, j, k);
    });
    add_cells(below, lattice.o.shells + 1);
  }
};

}  // namespace ball_detail

// The ball z >= 0 that touches the plane z = 0 at the origin. Sidesets `contact` (the patch around
// the origin) and `surface` (all).
inline Mesh graded_ball(const BallOptions& options) {
  ball_detail::Builder ball(options);
  ball.build();
  Mesh mesh;
  mesh.coordinates.resize(static_cast<Index>(ball.x.size()), 3);
  Nodeset planes[] = {{"x_plane", 1, {}}, {"y_plane", 2, {}}};
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    mesh.coordinates.row(i) = ball.x[at].transpose();
    mesh.node_ids.push_back(i + 1);
    if (ball.x_plane[at]) {
      planes[0].nodes.push_back(i);
      mesh.coordinates(i, 0) = 0;
    }
    if (ball.y_plane[at]) {
      planes[1].nodes.push_back(i);
      mesh.coordinates(i, 1) = 0;
    }
  }
  Block block;
  block.name = "ball";
  block.id = 1;
  block.type = ElementType::hex8;
  block.connectivity.resize(static_cast<Index>(ball.hexes.size()), 8);
  Sideset contact{"contact", 1, {}}, surface{"surface", 2, {}};
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    auto hex = ball.hexes[e];
    Points X(8, 3);
    for (int a = 0; a < 8; ++a) X.row(a) = mesh.coordinates.row(hex[a]);
    const Vector3 u = (X.row(1) - X.row(0)).transpose(), v = (X.row(3) - X.row(0)).transpose(),
                  w = (X.row(4) - X.row(0)).transpose();
    if (u.cross(v).dot(w) < 0) std::swap_ranges(hex.begin(), hex.begin() + 4, hex.begin() + 4);
    for (int a = 0; a < 8; ++a) block.connectivity(e, a) = hex[a];
    block.element_ids.push_back(e + 1);
    for (int side = 1; side <= 6; ++side) {
      const auto& nodes = side_nodes(ElementType::hex8, side);
      if (!std::all_of(nodes.begin(), nodes.end(),
                       [&](int a) { return ball.outer[hex[std::size_t(a)]]; }))
        continue;
      surface.sides.push_back({0, e, side});
      if (ball.layer[e] <= options.cap_shells) contact.sides.push_back({0, e, side});
    }
  }
  mesh.blocks.push_back(std::move(block));
  mesh.sidesets = {contact, surface};
  if (options.quarter) mesh.nodesets = {planes[0], planes[1]};
  return mesh;
}

}  // namespace cbr::test

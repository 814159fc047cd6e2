// SPDX-License-Identifier: GPL-3.0-or-later
// Small hex meshes, their superelements, and simulations of two bodies in face-to-face contact.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"
#include "dynamics/motion/modal/modal_body.hpp"
#include "dynamics/motion/nodal/mesh_body.hpp"
#include "dynamics/run/run.hpp"
#include "dynamics/setup/components/geometry.hpp"
#include "tests/unit/dynamics/lattice.hpp"

namespace cbr::test {

// A block from the origin, with sidesets x_min and x_max, and surface: all six faces.
Mesh brick(std::array<Index, 3> n, const Vector3& size);

struct Brick {
  Mesh mesh;
  FiniteElementModel fe;
  Geometry geometry;
};

Brick make_brick(std::array<Index, 3> n, const Vector3& size, const Material& material,
                 MassKind mass = MassKind::lumped);

Lattice as_lattice(const Brick& b, std::array<Index, 3> n);

// Options of a body in a two-body simulation.
struct Part {
  std::array<Index, 3> n{4, 2, 2};
  Vector3 size{1, 0.5, 0.5};
  Material material{100, 0.25, 1};
  bool mesh = false;
  MassKind mass = MassKind::lumped;
  Index modes = 8;
  bool both_faces = false;  // the superelement's interface includes x_min
  Scheme scheme = Scheme::exact;
  Placement placement;
  std::string face = "x_max";
};

std::unique_ptr<Body> make_body(const std::string& name, const Part& part, Geometry& geometry);

// Bodies a and b with opposite faces; the first is the slave. `h` of 0: the smaller critical step
// times `share`.
Simulation two_bodies(const Part& a, const Part& b, Enforcement enforcement, double end,
                      double every, double share = 0.9);

inline Vector3 row(const Series3& series, std::size_t i) {
  return Eigen::Map<const Vector3>(series.values.data() + 3 * i);
}

}  // namespace cbr::test

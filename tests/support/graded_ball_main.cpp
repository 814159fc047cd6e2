// SPDX-License-Identifier: GPL-3.0-or-later
// graded-ball FILE [RADIUS CORE M SHELLS CAP_SHELLS QUARTER]: writes the mesh of graded_ball.hpp,
// and its volume to stdout.
#include <cstdlib>
#include <iostream>
#include <string>

#include "common/fem/elements/element.hpp"
#include "tests/support/graded_ball.hpp"

int main(int argc, char** argv) {
  cbr::test::BallOptions o;
  if (argc < 2 || argv[1][0] == '-') {
    const bool asked = argc > 1 && std::string(argv[1]) == "--help";
    (asked ? std::cout : std::cerr)
        << "graded-ball FILE [RADIUS CORE M SHELLS CAP_SHELLS QUARTER]\n";
    return asked ? 0 : 2;
  }
  if (argc > 2) o.radius = std::atof(argv[2]);
  if (argc > 3) o.core = std::atof(argv[3]);
  if (argc > 4) o.m = std::atol(argv[4]);
  if (argc > 5) o.shells = std::atol(argv[5]);
  if (argc > 6) o.cap_shells = std::atol(argv[6]);
  if (argc > 7) o.quarter = std::atol(argv[7]) != 0;
  const cbr::Mesh mesh = cbr::test::graded_ball(o);
  double quality = 1, volume = 0;
  for (const auto row : mesh.blocks[0].connectivity.rowwise()) {
    cbr::Points X(8, 3);
    for (int a = 0; a < 8; ++a) X.row(a) = mesh.coordinates.row(row(a));
    quality = std::min(quality, cbr::element_quality(cbr::ElementType::hex8, X));
    volume += cbr::element_lumped_mass(cbr::ElementType::hex8, X, 1).sum();
  }
  cbr::write_mesh(mesh, argv[1]);
  std::cout.precision(17);
  std::cout << volume << "\n";
  std::cerr << mesh.coordinates.rows() << " nodes, " << mesh.blocks[0].connectivity.rows()
            << " hexes, " << mesh.sidesets[0].sides.size() << " faces in contact, smallest quality "
            << quality << "\n";
}

// SPDX-License-Identifier: GPL-3.0-or-later
// Made the files of tests/formats/data, each once, by the program of its day: they are never made
// anew, they stand for all files that users have. A later format version gets a file of its own
// beside it. usage: make_reference FILE
#include "reducer/bases/reduce.hpp"
#include "tests/unit/reducer/box_mesh.hpp"

int main(int argc, char** argv) {
  using namespace cbr;
  if (argc != 2) return 2;
  const Mesh mesh = test::box_mesh({.n = {3, 1, 2}, .size = {3, 1, 2}});
  ReductionOptions options;
  options.interface_sets = {"x_max"};
  options.modes = 6;
  options.recovery = true;
  const BlockProperties steel{{.youngs_modulus = 2e11, .poissons_ratio = 0.3, .density = 7800},
                              HexFormulation::incompatible};
  Report report("make_reference", Verbosity::normal);
  Superelement superelement = reduce(mesh, {steel}, MassKind::lumped, options, {}, report);
  superelement.content_hash = "00000000000000000000000000000001";
  superelement.provenance = {{"mesh", "box 3 x 1 x 2"},
                             {"material", "E = 2e11, nu = 0.3, rho = 7800"}};
  write_superelement(superelement, argv[1]);
  return 0;
}

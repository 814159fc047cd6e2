// Ten lines against the installed package: reads a superelement and prints what it is.
#include <cstdio>

#include "common/superelement.hpp"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const cbr::Superelement block = cbr::read_superelement(argv[1]);
  std::printf("%ld modes, %ld interface dofs, mass %g\n", long{block.k()}, long{block.c()}, block.rigid_body.mass);
}

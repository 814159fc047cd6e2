// Against the installed package: reads a superelement, and writes one of its own and reads it back.
// usage: consumer BLOCK.cbr.h5 ROD.cbr.h5
#include <cstdio>

#include "common/superelement/superelement.hpp"

void print(const cbr::Superelement& s) {
  std::printf("%ld modes, %ld interface dofs, mass %g\n", long{s.k()}, long{s.c()},
              s.rigid_body.mass);
}

// A rod of 1 m that moves along x: a mass at each end (kg) and a spring between them (N/m).
cbr::Superelement rod(double end_mass, double stiffness) {
  cbr::Superelement s;
  s.node_ids = {1, 2};
  s.coordinates = cbr::Points::Zero(2, 3);
  s.coordinates(1, 0) = 1;
  s.dof_node = {0, 1};
  s.dof_component = {0, 0};  // x
  s.K_cc = stiffness * (cbr::Matrix(2, 2) << 1, -1, -1, 1).finished();
  s.M_cc = end_mass * cbr::Matrix::Identity(2, 2);
  s.M_kc.resize(0, 2);  // no modes
  const double inertia = end_mass / 2;
  s.rigid_body = {2 * end_mass, cbr::Vector3(0.5, 0, 0),
                  cbr::Vector3(0, inertia, inertia).asDiagonal()};
  return s;
}

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  print(cbr::read_superelement(argv[1]));
  cbr::write_superelement(rod(2.0, 1e6), argv[2]);
  print(cbr::read_superelement(argv[2]));
}

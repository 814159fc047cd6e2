// SPDX-License-Identifier: GPL-3.0-or-later
// reducer/distributed of a build without MPI: one process, and a clear word to those who start
// several.
#include <cstdlib>

#include "common/base/error.hpp"
#include "reducer/distributed/processes.hpp"

namespace cbr {
namespace {

constexpr const char* cure =
    ": take mpi/cbr-reduce of a build with cmake --preset mpi (docs/distributed.md)";

}  // namespace

Processes::Processes() = default;
Processes::~Processes() = default;

void Processes::start(bool asked) {
  if (asked)
    throw InputError(std::string("--engine petsc: this cbr-reduce was built without MPI") + cure);
  const char* size = std::getenv("OMPI_COMM_WORLD_SIZE");
  if (size != nullptr && std::atoi(size) > 1)
    throw InputError("mpirun started " + std::string(size) +
                     " processes, but this cbr-reduce was built without MPI" + cure +
                     ", or start one");
}

int Processes::threads() const { return 0; }

int Processes::end(int code) { return code; }

DomainShare share_of_domains() { return {}; }

Superelement reduce_in_processes(const Mesh&, const std::vector<BlockProperties>&, MassKind,
                                 const ReductionOptions&, const ReduceSettings&, Report&,
                                 ReductionFigures*) {
  throw RunError("this cbr-reduce was built without MPI");
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/condensation/panel_memory.hpp"

#include <algorithm>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/machine_memory.hpp"

namespace cbr {

double half_of_memory() { return 0.5 * machine_memory_bytes(); }

void require_memory_for_interface(Index c, double memory) {
  const double bytes = 16.0 * static_cast<double>(c) * static_cast<double>(c);
  if (bytes <= memory) return;
  throw InputError("the interface has " + std::to_string(c) +
                   " dofs, whose dense mass and stiffness take " + human_bytes(bytes) +
                   ", the machine has " + human_bytes(memory) +
                   ": keep fewer faces, or use instances as: mesh");
}

double panel_memory(double given, const Partition& p, const SparseCholesky& factor,
                    const Matrix& Phi) {
  if (given > 0) return given;
  const auto c = static_cast<double>(p.n_interface());
  const double held = factor.bytes() + 32 * static_cast<double>(p.M_II.nonZeros()) +
                      8 * static_cast<double>(Phi.size()) + 32 * c * c;
  // Some is given in any case: without panels nothing goes
  const double all = machine_memory_bytes();
  return std::min(0.5 * all, std::max(0.05 * all, 0.85 * all - held));
}

}  // namespace cbr

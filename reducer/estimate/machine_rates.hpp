// SPDX-License-Identifier: GPL-3.0-or-later
// How fast this machine is, measured in a fraction of a second: what the predicted times of an
// estimate rest on.
#pragma once

namespace cbr {

struct MachineRates {
  double flops = 0;      // per second, of a product of large matrices (dgemm)
  double bandwidth = 0;  // bytes read per second, of a matrix of 134 MB times a vector (dgemv)
  int threads = 1;
};

// The best of a few runs, with the threads that set_threads() allows.
MachineRates machine_rates();

}  // namespace cbr

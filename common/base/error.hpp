// SPDX-License-Identifier: GPL-3.0-or-later
// The two ways a program can fail. Bugs are asserts; results that did not converge are values.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace cbr {

// The user's input or command line is wrong: one line with the place (file, line, key, id),
// found and allowed values, and the cure. main() prints it after "PROGRAM: error: " and exits 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The input was fine and the run failed (disk full, not converged, not positive definite). main()
// exits 1.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string join(const std::vector<std::string>& words, const std::string& separator = ", ");
// ", did you mean 'x'?" with the candidate nearest to `found` by edit distance, or "" when none is
// near.
std::string nearest_name(const std::string& found, const std::vector<std::string>& allowed);

}  // namespace cbr

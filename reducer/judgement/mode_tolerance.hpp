// SPDX-License-Identifier: GPL-3.0-or-later
// reduction: {tolerance: ...}: as few modes as keep the errors below it (docs/theory.md, "What a
// tolerance bounds").
#pragma once

#include <vector>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// How many of the free component's lowest elastic modes a tolerance is asked of.
constexpr Index n_free_modes_of_tolerance = 10;

struct ModesOfTolerance {
  FixedInterfaceModes modes;  // picked, ascending
  Index n_candidates = 0;     // computed for that
  ModesNotKept not_kept;
};

// Mass lost to round-off in an ill-conditioned interior; the caller adds the place in the mesh.
class LostMass : public InputError {
 public:
  using InputError::InputError;
};

// Modes for a tolerance of two errors. One is the relative strain energy outside the modes under
// any rigid acceleration of the interface. The other is the relative errors of the free component's
// ten lowest elastic eigenvalues, by full_eigenvalues() of the reduced component with the picked
// modes. Computes candidates, lowest first and each once, until all together suffice. Then picks
// those with the largest part in the largest error, again and again. Modes of one frequency are
// picked together, as their shapes are arbitrary, and so are all within sqrt(2) of the free modes'
// frequencies. s: K_cc, M_cc; part: per node of s. Above 6000 interface dofs rigid motions alone
// count. InputError: more than 5000 would be needed and the interior has more. LostMass: no mass is
// left beside the modes.
ModesOfTolerance modes_of_tolerance(const Partition& p, const SparseCholesky& factor,
                                    const InterfaceMotions& motions, const Superelement& s,
                                    const std::vector<Index>& part, double tolerance,
                                    Report& report);

// A warning where the figures of the reduction as it is in the end are above the tolerance.
// condition: of K_II, scaled.
void judge_tolerance(double tolerance, double left_out, double mode_error, double condition,
                     Report& report);

// Of a component of several parts: of each by itself, its own rigid accelerations and its own ten
// modes.
ModesOfTolerance modes_of_tolerance(const Partition& p, const std::vector<ComponentPart>& parts,
                                    const Superelement& s, double tolerance, Report& report);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Basis massless: modes that carry all inertia, and an interface without any that answers forces by
// its compliance at once (Monjaraz Tec, Gross, Krack 2022, doi 10.1016/j.compstruc.2021.106698).
// docs/theory.md, "An interface without mass".
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/linalg/sparse/sparse_cholesky.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/judgement/condition_numbers.hpp"
#include "reducer/modes/fixed_interface_modes.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {

// For the summary.
struct MasslessFigures {
  Index n_rigid = 0;
  FixedInterfaceModes free;  // Phi: N x k and those ahead, rigid motions first
  ModeCheck modes;           // of the free modes
  // Residual compliance F relative to the elastic compliance: least pivot of its Cholesky factor,
  // and under a uniform load along x, y, z
  double smallest_pivot = 1;
  Vector3 left = Vector3::Zero();
  // tapered modes: fraction of each elastic mode's compliance at the interface that moves with it
  Vector share;
};

// The full model, as far as free modes need it.
struct FreeModel {
  const SparseMatrix& K;            // N x N
  const SparseMatrix& M;            // N x N
  const Points& x;                  // of its nodes
  const std::vector<Index>& part;   // per node: the connected part that it belongs to
  Index n_rotations = 0;            // of these the last, which are rotations of shells
  std::optional<Matrix> left = {};  // with fixed dofs: the rigid motions that they leave   (N x r)
};

// How many modes: elastic ones, the lowest `modes` or all below cutoff_hz; rigid motions come on
// top.
struct FreeModesWanted {
  Index modes = 0;
  double cutoff_hz = 0;  // 0: `modes` counts
  // Tapers interface rows towards the last mode, V_j <- V_j sqrt(1 - (omega_j / omega)^3) with
  // omega of end_of_fall(). F receives the compliance that the taper removes. docs/theory.md, "An
  // interface without mass"; figures in docs/decisions/energy.md.
  bool tapered = false;
};

// MacNeal 1971 (doi 10.1016/0045-7949(71)90031-9): lowest elastic modes of the free body, its rigid
// motions, and the compliance of the interface that they leave. s: of a reduction without modes;
// its K_cc and M_cc are used up. InputError: a mechanism; more modes than leave the interface
// compliance of its own. RunError: of the eigensolver.
MasslessFigures make_massless(const FreeModel& model, const Partition& p,
                              const SparseCholesky& factor_of_K_II, const FreeModesWanted& wanted,
                              Superelement& s, Report& report);

// InputError naming the node of a mechanism of the massless interface, other than a rigid motion,
// or of a stiffness lost to round-off.
void refuse_mechanism(const SoftestMotion& softest, const std::string& node);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// The steps of a reduction that one process and several take in ways of their own. reduce.cpp has
// their order, and all others.
#pragma once

#include "reducer/bases/reduction_steps.hpp"

namespace cbr {

class Engine {
 public:
  virtual ~Engine() = default;

  // From the mesh: r.model, r.x, r.part, r.p, and the rigid body of s.
  virtual void assemble(Reduction& r, Superelement& s) = 0;
  // K_II, and its condition. InputError: it is singular.
  virtual void factorise(Reduction& r) = 0;
  // Number of fixed-interface modes below a frequency (Hz).
  virtual Index count_below(Reduction& r, double hz) = 0;
  // As fixed_interface_modes().
  virtual FixedInterfaceModes lowest_modes(Reduction& r, Index k) = 0;
  // r.p.rigid but for G, and the matrices of the interface, which the first process gets. Phi:
  // fixed-interface modes   (n_rows x k)
  virtual Condensation condense(Reduction& r, const Matrix& Phi) = 0;
};

// The order of the steps. InputError, RunError: those of reduce().
Superelement reduce_by(Engine& engine, Reduction& r);

// One process: the whole model, by SparseCholesky. `interface`: mesh nodes, or null: those of the
// options' sets.
class LocalEngine final : public Engine {
 public:
  explicit LocalEngine(const std::vector<Index>* interface) : interface_(interface) {}

  void assemble(Reduction& r, Superelement& s) override;
  void factorise(Reduction& r) override;
  Index count_below(Reduction& r, double hz) override;
  FixedInterfaceModes lowest_modes(Reduction& r, Index k) override;
  Condensation condense(Reduction& r, const Matrix& Phi) override;

 private:
  const std::vector<Index>* interface_;
  std::optional<Condensed> by_fronts_;  // with the factorisation
};

}  // namespace cbr

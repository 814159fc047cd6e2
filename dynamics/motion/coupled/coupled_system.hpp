// SPDX-License-Identifier: GPL-3.0-or-later
// A coupled model with held directions, ready to move: its products and factors, shared by the
// instances that are held alike.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/motion/coupled/coupled_factor.hpp"
#include "dynamics/motion/coupled/coupled_model.hpp"
#include "dynamics/motion/nodal/block_matrix.hpp"

namespace cbr {

class CoupledStatics;

// For one thread at a time; products and solves allocate nothing.
class CoupledSystem {
 public:
  // `held`: ascending by node, component axes. Factors the mass: RunError when it is not positive
  // definite, named by `where`.
  CoupledSystem(std::shared_ptr<const CoupledModel> model, std::vector<HeldDirection> held,
                std::string where);

  const CoupledModel& model() const { return *model_; }
  Index n() const { return n_; }
  Index n_modal() const { return n_modal_; }
  Index n_free() const { return n_modal_ + free_.Z.cols(); }
  const Matrix& rigid_momentum() const { return MR_; }  // M R, n x 6

  // y = K x, n. The mean translation of x, which has no stiffness, is taken out first: a body that
  // flies far keeps its digits.
  void multiply_stiffness(const Vector& x, Vector& y);
  void multiply_mass(const Vector& x, Vector& y);
  // the part of nodal forces or displacements along held directions := 0
  void drop_held(Vector& f) const;
  bool is_held(Index node) const;
  // A = M + theta K on the free directions; the mass and the last two others are kept.
  const CoupledFactor& factor(double theta);
  // rad/s, of the model as it is held; computed when first asked for.
  double largest_frequency();

  // Found when first asked for.
  CoupledStatics& statics();
  ~CoupledSystem();

 private:
  void multiply_nodal(const BlockMatrix& A, const Vector& x, Vector& y);
  void multiply_stiffness_as_is(const Vector& x, Vector& y);
  bool translations_are_free();

  std::shared_ptr<const CoupledModel> model_;
  std::vector<HeldDirection> held_;
  std::string where_;
  FreeDofs free_;
  Index n_ = 0, n_modal_ = 0;
  BlockMatrix K_, M_;
  RowThreads threads_;
  Matrix MR_;
  bool takes_translation_out_ = false;
  Vector deformation_;
  std::vector<Vector> part_in_, part_out_;
  std::unique_ptr<CoupledFactor> mass_, recent_, before_;
  double largest_frequency_ = -1;
  std::unique_ptr<CoupledStatics> statics_;
};

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Data shared by the bodies of one ModalForm: rows of node sets, responses, propagators.
// In component axes, which the bodies rotate 3-vectors into and out of.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/types.hpp"
#include "common/superelement/superelement.hpp"
#include "dynamics/contact/nodes/thin_response.hpp"
#include "dynamics/motion/modal/forms/modal_propagator.hpp"
#include "dynamics/motion/modal/forms/spin_coupling.hpp"

namespace cbr {

// The operator of a response: weights sin(omega h)/omega (exact), h (central differences) or h/2 /
// (1 + theta omega^2) (Newmark; twice that for impulses at the start) of the modes, 1 for
// velocities, or 1 / omega^2 (0 for floating motions) for statics.
struct ResponseOf {
  enum class Weight : char {
    exact,
    central,
    newmark,
    newmark_at_start,
    velocity,
    statics
  } weight = Weight::exact;
  double h = 0, theta = 0;
  double contact_step = 0;  // with the contact_gain() of this step; 0: without
  std::size_t damping = 0;  // Damping's hash of the rates; 0: without
  bool operator==(const ResponseOf&) const = default;
};

// Modal rows of a list of nodes, component axes.
class NodeRows {
 public:
  // row: of V for each node of the body and component, -1 for none. V must outlive this: its own
  // rows serve where the nodes' are consecutive, else a copy is kept.
  NodeRows(const RowMatrix& V, const IndexTable& row, std::vector<Index> nodes);

  const std::vector<Index>& nodes() const { return nodes_; }
  Index n_dofs() const { return 3 * static_cast<Index>(nodes_.size()); }
  // V_c^T (n x 3 m): column 3 i + c is the modal row of dof (i, c), contiguous.
  Eigen::Map<const Matrix> Vt() const { return {data_, n_, n_dofs()}; }

  // V_c^T = Q A: the nodes move in r shapes, the rows of A.
  struct Shapes {
    Matrix Q;                         // n x r
    std::shared_ptr<const Matrix> A;  // r x 3 m
  };
  // Of r <= n / 2 shapes, to round-off, or nothing: then there are more. Once it has been asked
  // for, products use it.
  const Shapes* shapes() const;

  // u = T V_c eta   (m x 3)
  void displacements(const Vector& eta, const Matrix3& T, Points& u) const;
  // kick = V_c^T T^T p   (n), read where p is not 0 only. local: workspace, made larger when too
  // small.
  void kick(const Points& p, const Matrix3& T, Points& local, Vector& kick) const;
  // S = V_c^T diag(weight) V_c   (3 m x 3 m), kept for those that ask for the same again: the last
  // few.
  std::shared_ptr<const Matrix> response(const ResponseOf& of, const Vector& weight) const;
  // Whether the nodes' dofs are four times as many as the modes, so that the same is better not
  // formed; and the same, as its factors.
  bool has_few_modes() const { return 4 * n_ <= n_dofs(); }
  std::shared_ptr<const ThinResponse> thin_response(const ResponseOf& of,
                                                    const Vector& weight) const;
  // Largest magnitude over the nodes of each mode's displacement   (n x 3)
  const Matrix& envelope() const;

  // ModalBody's: V^T M^ of unit velocities of the dofs, n x 3 m; filled when first needed
  mutable Matrix velocity_map;

 private:
  std::vector<Index> nodes_;
  Index n_ = 0;
  Matrix copy_;
  const double* data_ = nullptr;
  mutable std::optional<Shapes> shapes_;
  mutable bool shapes_known_ = false;
  mutable std::vector<std::pair<ResponseOf, std::shared_ptr<const Matrix>>> responses_;
  mutable std::vector<std::pair<ResponseOf, std::shared_ptr<const ThinResponse>>> thin_;
  mutable Matrix envelope_;
};

// Lives in a ModalForm and goes with its matrices: a copy of the form starts with an empty one.
// Several threads may call propagator(), one alone the others.
class FormCache {
 public:
  FormCache() = default;
  FormCache(const FormCache&) {}
  FormCache(FormCache&&) = default;
  FormCache& operator=(const FormCache&) {
    *this = FormCache();
    return *this;
  }
  FormCache& operator=(FormCache&&) = default;

  std::shared_ptr<const NodeRows> rows(const RowMatrix& V, const IndexTable& row,
                                       const std::vector<Index>& nodes);
  // Mean over the nodes of V_c^T   (n x 3)
  std::shared_ptr<const Matrix> mean_rows(const RowMatrix& V, const IndexTable& row,
                                          const std::vector<Index>& nodes);
  // `damping` has the rates and their hash, which identifies them.
  std::shared_ptr<const ModalPropagator> propagator(const Vector& omega, const ModalRates& damping,
                                                    double h, bool with_loads);
  // displacement_rows() of the superelement that the form belongs to.
  std::shared_ptr<const IndexTable> row_table(const Superelement& superelement);
  // Of the form's modes, n with the rigid ones; null where the superelement does not know it.
  std::shared_ptr<const SpinCoupling> spin_coupling(const Superelement& superelement, Index n_rigid,
                                                    Index n);

 private:
  std::vector<std::shared_ptr<const NodeRows>> rows_;
  std::vector<std::pair<std::vector<Index>, std::shared_ptr<const Matrix>>> means_;
  std::vector<std::shared_ptr<const ModalPropagator>> propagators_;
  std::shared_ptr<const IndexTable> row_table_;
  std::shared_ptr<const SpinCoupling> spin_coupling_;
};

}  // namespace cbr

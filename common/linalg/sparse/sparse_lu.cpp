// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/linalg/sparse/sparse_lu.hpp"

#include <Eigen/SparseLU>

namespace cbr {

struct SparseLu::Impl {
  Eigen::SparseLU<SparseMatrix> factor;
};

SparseLu::SparseLu(const SparseMatrix& A) : impl_(std::make_unique<Impl>()) {
  impl_->factor.compute(A);
}
SparseLu::~SparseLu() = default;
SparseLu::SparseLu(SparseLu&&) noexcept = default;
SparseLu& SparseLu::operator=(SparseLu&&) noexcept = default;

bool SparseLu::ok() const { return impl_->factor.info() == Eigen::Success; }
Vector SparseLu::solve(const Vector& b) const { return impl_->factor.solve(b); }

}  // namespace cbr

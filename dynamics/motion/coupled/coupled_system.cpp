// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/coupled/coupled_system.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// Fewer block rows than this are done before a thread is awake.
constexpr Index least_rows = 2000;
void gather(const Vector& x, Index n_modal, const CoupledPart& part, Vector& x_c) {
  for (Index i = 0; i < x_c.size(); ++i) x_c[i] = x[n_modal + part.dof[i]];
}

void scatter_add(const Vector& y_c, Index n_modal, const CoupledPart& part, Vector& y) {
  for (Index i = 0; i < y_c.size(); ++i) y[n_modal + part.dof[i]] += y_c[i];
}

}  // namespace

CoupledSystem::CoupledSystem(std::shared_ptr<const CoupledModel> model,
                             std::vector<HeldDirection> held, std::string where)
    : model_(std::move(model)),
      held_(std::move(held)),
      where_(std::move(where)),
      free_(free_dofs(*model_, held_)),
      n_(model_->n()),
      n_modal_(model_->n_modal()),
      threads_(model_->K.rows() > 3 * least_rows ? n_threads() : 1) {
  if (model_->K.size() > 0) K_ = block_matrix(model_->K);
  if (model_->M.size() > 0) M_ = block_matrix(model_->M);
  for (const CoupledPart& part : model_->parts) {
    part_in_.push_back(Vector::Zero(part.superelement->c()));
    part_out_.push_back(part_in_.back());
  }
  mass_ = std::make_unique<CoupledFactor>(*model_, free_, 0, where_);
  const Matrix R = rigid_motions(*model_);
  MR_.resize(n_, 6);
  Vector column(n_), product(n_);
  for (Index j = 0; j < 6; ++j) {
    column = R.col(j);
    multiply_mass(column, product);
    MR_.col(j) = product;
  }
  // of fixed dofs the coordinates make no rigid motion
  if (model_->parts.size() == 1 && model_->parts.front().superelement->fixed.any()) {
    const CoupledPart& part = model_->parts.front();
    const Matrix& momentum = part.superelement->fixed.momentum;
    MR_.setZero();
    MR_.topRows(n_modal_) = momentum.topRows(n_modal_);
    for (std::size_t i = 0; i < part.dof.size(); ++i)
      MR_.row(n_modal_ + part.dof[i]) = momentum.row(n_modal_ + static_cast<Index>(i));
  }
  deformation_.setZero(n_);
  takes_translation_out_ = translations_are_free();
}

// A superelement whose interface lacks some dofs may answer to a translation of the others.
bool CoupledSystem::translations_are_free() {
  const Matrix R = rigid_motions(*model_);
  Vector y(n_);
  // Any displacement of the size of a unit translation
  const Vector x = Vector::NullaryExpr(n_, [](Index i) { return i % 2 == 0 ? 1.0 : -1.0; });
  multiply_stiffness_as_is(x, y);
  const double scale = y.norm();
  for (int c = 0; c < 3; ++c) {
    multiply_stiffness_as_is(R.col(c), y);
    if (!(y.norm() <= 1e-10 * scale)) return false;
  }
  return true;
}

void CoupledSystem::multiply_stiffness(const Vector& x, Vector& y) {
  if (!takes_translation_out_) return multiply_stiffness_as_is(x, y);
  deformation_ = x;
  Eigen::Map<Points> u(deformation_.data() + n_modal_, model_->coordinates.rows(), 3);
  const std::vector<Index>& turning = model_->turning;
  Eigen::RowVector3d mean = u.colwise().sum();
  for (const Index node : turning) mean -= u.row(node);
  mean /= static_cast<double>(u.rows()) - static_cast<double>(turning.size());
  u.rowwise() -= mean;
  for (const Index node : turning) u.row(node) += mean;
  multiply_stiffness_as_is(deformation_, y);
}

void CoupledSystem::multiply_nodal(const BlockMatrix& A, const Vector& x, Vector& y) {
  if (A.rows() > 0) return multiply(A, x.data() + n_modal_, y.data() + n_modal_, threads_);
  y.tail(n_ - n_modal_).setZero();
}

void CoupledSystem::multiply_stiffness_as_is(const Vector& x, Vector& y) {
  multiply_nodal(K_, x, y);
  Index first = 0;
  for (std::size_t p = 0; p < model_->parts.size(); ++p) {
    const CoupledPart& part = model_->parts[p];
    const Superelement& s = *part.superelement;
    y.segment(first, s.k()) = s.eigenvalues.cwiseProduct(x.segment(first, s.k()));
    first += s.k();
    if (s.c() == 0) continue;
    gather(x, n_modal_, part, part_in_[p]);
    part_out_[p].noalias() = s.K_cc.selfadjointView<Eigen::Lower>() * part_in_[p];
    scatter_add(part_out_[p], n_modal_, part, y);
  }
}

void CoupledSystem::multiply_mass(const Vector& x, Vector& y) {
  multiply_nodal(M_, x, y);
  Index first = 0;
  for (std::size_t p = 0; p < model_->parts.size(); ++p) {
    const CoupledPart& part = model_->parts[p];
    const Superelement& s = *part.superelement;
    gather(x, n_modal_, part, part_in_[p]);
    auto y_k = y.segment(first, s.k());
    y_k = x.segment(first, s.k());
    part_out_[p].setZero();
    if (s.c() > 0) part_out_[p].noalias() += s.M_cc.selfadjointView<Eigen::Lower>() * part_in_[p];
    if (s.k() > 0 && s.c() > 0) {
      y_k.noalias() += s.M_kc * part_in_[p];
      part_out_[p].noalias() += s.M_kc.transpose() * x.segment(first, s.k());
    }
    scatter_add(part_out_[p], n_modal_, part, y);
    first += s.k();
  }
}

void CoupledSystem::drop_held(Vector& f) const {
  for (const HeldDirection& h : held_) {
    auto of_node = f.segment<3>(n_modal_ + 3 * h.node);
    of_node -= of_node.dot(h.direction) * h.direction;
  }
}

bool CoupledSystem::is_held(Index node) const {
  const auto at = std::lower_bound(held_.begin(), held_.end(), node,
                                   [](const HeldDirection& h, Index i) { return h.node < i; });
  return at != held_.end() && at->node == node;
}

const CoupledFactor& CoupledSystem::factor(double theta) {
  if (theta == 0) return *mass_;
  if (recent_ && recent_->theta() == theta) return *recent_;
  std::swap(recent_, before_);
  if (!recent_ || recent_->theta() != theta) {
    recent_.reset();  // its memory first
    recent_ = std::make_unique<CoupledFactor>(*model_, free_, theta, where_);
  }
  return *recent_;
}

double CoupledSystem::largest_frequency() {
  if (largest_frequency_ >= 0) return largest_frequency_;
  const double lambda = largest_eigenvalue(
      n_,
      [&](const Vector& x, Vector& y) {
        multiply_stiffness(x, y);
        drop_held(y);
      },
      [&](const Vector& x, Vector& y) {
        y = x;
        mass_->solve(y);
      });
  if (!(lambda >= 0) || !std::isfinite(lambda))
    throw RunError(where_ +
                   ": the highest frequency cannot be computed: its stiffness is too large, or its "
                   "mass too small, for a double: "
                   "look at the units of youngs_modulus and density, and of a skin's thickness");
  largest_frequency_ = std::sqrt(lambda);
  return largest_frequency_;
}

}  // namespace cbr

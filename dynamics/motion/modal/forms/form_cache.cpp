// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/modal/forms/form_cache.hpp"

#include <algorithm>
#include <mutex>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/huge_pages.hpp"
#include "dynamics/motion/modal/forms/modal_form.hpp"

namespace cbr {
namespace {

constexpr std::size_t most_responses = 3;     // step, last step, and one that an output cuts
constexpr std::size_t most_propagators = 12;  // a jump's length is one of a few
// Shapes are looked for among so many dofs at first, and no more than so many. What they leave of
// any dof is round-off.
constexpr Index first_sample = 32, most_sampled = 256;
constexpr double shape_round_off = 1e-13;

Eigen::Map<Vector> flat(Points& p) { return {p.data(), p.size()}; }

// Of the propagators of all forms, which bodies ask for when a step's length is another.
std::mutex propagators_in_use;

// The first of the rows when those of all nodes follow each other, else -1.
Index first_of_consecutive(const IndexTable& row, const std::vector<Index>& nodes) {
  if (nodes.empty()) return -1;
  const Index first = row(nodes.front(), 0);
  Index next = first;
  for (const Index node : nodes)
    for (int d = 0; d < 3; ++d)
      if (row(node, d) < 0 || row(node, d) != next++) return -1;
  return first;
}

}  // namespace

NodeRows::NodeRows(const RowMatrix& V, const IndexTable& row, std::vector<Index> nodes)
    : nodes_(std::move(nodes)), n_(V.cols()) {
  const Index first = first_of_consecutive(row, nodes_);
  if (first >= 0) {
    data_ = V.data() + first * n_;
    return;
  }
  copy_.setZero(n_, n_dofs());
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    for (int d = 0; d < 3; ++d)
      if (const Index r = row(nodes_[i], d); r >= 0)
        copy_.col(3 * static_cast<Index>(i) + d) = V.row(r).transpose();
  data_ = copy_.data();
}

const NodeRows::Shapes* NodeRows::shapes() const {
  if (shapes_known_) return shapes_ ? &*shapes_ : nullptr;
  shapes_known_ = true;
  const Index most = std::min({n_dofs(), n_, most_sampled});
  for (Index n = std::min(first_sample, most); n > 0; n = std::min(2 * n, most)) {
    const Index stride = n_dofs() / n;
    Matrix sample(n_, n);
    for (Index j = 0; j < n; ++j) sample.col(j) = Vt().col(stride * j);
    const PivotedQr qr(sample, shape_round_off);
    // As many as were asked: there may be more
    if (qr.rank() == n && n < most) continue;
    if (2 * qr.rank() > n_) return nullptr;
    const Matrix Q = qr.Q().leftCols(qr.rank());
    auto A = std::make_shared<const Matrix>(Q.transpose() * Vt());
    const double left = (Vt() - Q * *A).cwiseAbs().maxCoeff();
    if (left <= shape_round_off * Vt().cwiseAbs().maxCoeff()) {
      shapes_ = Shapes{Q, std::move(A)};
      return &*shapes_;
    }
    if (n == most) break;
  }
  return nullptr;
}

void NodeRows::displacements(const Vector& eta, const Matrix3& T, Points& u) const {
  u.resize(static_cast<Index>(nodes_.size()), 3);
  if (n_ == 0 || nodes_.empty()) {  // BLAS minds a product over nothing: every dof held
    u.setZero();
    return;
  }
  {
    const LargeBlasWork blas = LargeBlasWork::reading(n_ * n_dofs());
    if (shapes_) {
      flat(u).noalias() = shapes_->A->transpose() * Vector(shapes_->Q.transpose() * eta);
    } else {
      flat(u).noalias() = Vt().transpose() * eta;
    }
  }
  for (Index i = 0; i < u.rows(); ++i) u.row(i) = (T * Vector3(u.row(i).transpose())).transpose();
}

void NodeRows::kick(const Points& p, const Matrix3& T, Points& local, Vector& kick) const {
  kick.setZero(n_);
  if (n_ == 0) return;
  if (local.rows() < p.rows()) local.resize(p.rows(), 3);
  const LargeBlasWork blas = LargeBlasWork::reading(n_ * n_dofs());
  Vector of_shapes = Vector::Zero(shapes_ ? shapes_->A->rows() : 0);
  // One product for each run of nodes that are pushed
  for (Index i = 0; i < p.rows(); ++i) {
    const Index first = i;
    for (; i < p.rows() && !p.row(i).isZero(0); ++i)
      local.row(i) = (T.transpose() * Vector3(p.row(i).transpose())).transpose();
    if (i == first) continue;
    const auto pushed = flat(local).segment(3 * first, 3 * (i - first));
    if (shapes_) {
      of_shapes.noalias() += shapes_->A->middleCols(3 * first, 3 * (i - first)) * pushed;
    } else {
      kick.noalias() += Vt().middleCols(3 * first, 3 * (i - first)) * pushed;
    }
  }
  if (shapes_) kick.noalias() = shapes_->Q * of_shapes;
}

std::shared_ptr<const Matrix> NodeRows::response(const ResponseOf& of, const Vector& weight) const {
  for (const auto& [known, block] : responses_)
    if (known == of) return block;
  Matrix S = zeros_on_huge_pages(n_dofs(), n_dofs());
  if (n_ == 0) {  // every dof is held
  } else if (weight.minCoeff() >= 0) {
    // Positive weights (exact: below omega h = pi) are half the work
    const Matrix scaled = weight.cwiseSqrt().asDiagonal() * Vt();
    S.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  } else {
    S.noalias() = Vt().transpose() * (weight.asDiagonal() * Vt());
  }
  mirror_lower(S);
  if (responses_.size() == most_responses) responses_.erase(responses_.begin());
  responses_.emplace_back(of, std::make_shared<const Matrix>(std::move(S)));
  return responses_.back().second;
}

std::shared_ptr<const ThinResponse> NodeRows::thin_response(const ResponseOf& of,
                                                            const Vector& weight) const {
  for (const auto& [known, response] : thin_)
    if (known == of) return response;
  const bool is_first = thin_.empty();
  auto A = is_first ? std::make_shared<const Matrix>(Vt()) : thin_.front().second->A;
  auto rows = is_first ? no_static_rows(nodes_.size()) : thin_.front().second->rows;
  if (thin_.size() == most_responses) thin_.erase(thin_.begin());
  thin_.emplace_back(of, std::make_shared<const ThinResponse>(ThinResponse{
                             std::move(A), weight.asDiagonal(), std::move(rows), 1, true}));
  return thin_.back().second;
}

const Matrix& NodeRows::envelope() const {
  if (envelope_.rows() == n_ && envelope_.cols() == 3) return envelope_;
  envelope_.setZero(n_, 3);
  for (Index j = 0; j < n_dofs(); ++j)
    envelope_.col(j % 3) = envelope_.col(j % 3).cwiseMax(Vt().col(j).cwiseAbs());
  return envelope_;
}

std::shared_ptr<const NodeRows> FormCache::rows(const RowMatrix& V, const IndexTable& row,
                                                const std::vector<Index>& nodes) {
  for (const auto& known : rows_)
    if (known->nodes() == nodes) return known;
  rows_.push_back(std::make_shared<const NodeRows>(V, row, nodes));
  return rows_.back();
}

std::shared_ptr<const Matrix> FormCache::mean_rows(const RowMatrix& V, const IndexTable& row,
                                                   const std::vector<Index>& nodes) {
  for (const auto& [known, mean] : means_)
    if (known == nodes) return mean;
  Matrix mean = Matrix::Zero(V.cols(), 3);
  for (const Index node : nodes)
    for (int d = 0; d < 3; ++d)
      if (row(node, d) >= 0) mean.col(d) += V.row(row(node, d)).transpose();
  mean /= static_cast<double>(nodes.size());
  means_.emplace_back(nodes, std::make_shared<const Matrix>(std::move(mean)));
  return means_.back().second;
}

std::shared_ptr<const IndexTable> FormCache::row_table(const Superelement& superelement) {
  if (!row_table_) row_table_ = std::make_shared<const IndexTable>(displacement_rows(superelement));
  return row_table_;
}

std::shared_ptr<const SpinCoupling> FormCache::spin_coupling(const Superelement& superelement,
                                                             Index n_rigid, Index n) {
  const Matrix& P = superelement.spin_couplings;
  if (P.size() == 0 || n <= n_rigid) return nullptr;
  if (!spin_coupling_) spin_coupling_ = std::make_shared<const SpinCoupling>(P, n_rigid, n);
  return spin_coupling_;
}

std::shared_ptr<const ModalPropagator> FormCache::propagator(const Vector& omega,
                                                             const ModalRates& damping, double h,
                                                             bool with_loads) {
  const std::scoped_lock lock(propagators_in_use);
  for (const auto& known : propagators_)
    if (known->h == h && known->damping == damping.hash &&
        (!with_loads || known->a0.size() == omega.size()))
      return known;
  if (propagators_.size() == most_propagators) propagators_.erase(propagators_.begin());
  propagators_.push_back(
      std::make_shared<const ModalPropagator>(modal_propagator(omega, damping, h, with_loads)));
  return propagators_.back();
}

}  // namespace cbr

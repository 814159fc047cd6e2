// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/scaled/scaled_model.hpp"

#include <algorithm>
#include <utility>

#include "common/linalg/dense_factor.hpp"
#include "common/linalg/huge_pages.hpp"

namespace cbr {
namespace {

// The modes of a diagonal form from number `first` on.
class HighModes final : public ScaledPart {
 public:
  HighModes(std::shared_ptr<const DiagonalForm> form, Index first, double clip)
      : form_(std::move(form)) {
    scale_ = clip * form_->omega.tail(form_->omega.size() - first).cwiseInverse();
  }

  Matrix times(const Matrix& F) const override {
    const auto V = form_->V.rightCols(scale_.size());
    // S F = V diag(clip / omega)^2 V^T F   (n x q)
    Matrix amplitude = V.transpose() * F;
    amplitude.array().colwise() *= scale_.array().square();
    return V * amplitude;
  }

  Matrix block(const std::vector<Index>& coordinates) const override {
    const Index n = static_cast<Index>(coordinates.size());
    // G = diag(clip / omega) V^T, S = G^T G on the coordinates' columns   (n_scaled x n, n x n)
    Matrix G = zeros_on_huge_pages(scale_.size(), n), S = zeros_on_huge_pages(n, n);
    for (Index i = 0; i < n; ++i)
      if (coordinates[i] >= 0)
        G.col(i) =
            form_->V.row(coordinates[i]).tail(scale_.size()).transpose().cwiseProduct(scale_);
    S.selfadjointView<Eigen::Lower>().rankUpdate(G.transpose());
    mirror_lower(S);
    return S;
  }

  const Vector& scale() const { return scale_; }

 private:
  std::shared_ptr<const DiagonalForm> form_;
  Vector scale_;  // clip / omega
};

class ModelOfForm final : public ScaledModel {
 public:
  ModelOfForm(std::shared_ptr<const Superelement> superelement,
              std::shared_ptr<const DiagonalForm> form)
      : ScaledModel(std::move(superelement)), form_(std::move(form)) {}

  Index n_modes() const override { return form_->omega.size(); }
  double largest_frequency() override {
    return form_->omega.size() > 0 ? form_->omega.maxCoeff() : 0;
  }

 private:
  std::shared_ptr<ScaledModes> make(double clip) override {
    const Vector& omega = form_->omega;
    const Index kept = std::upper_bound(omega.begin(), omega.end(), clip) - omega.begin(),
                high = omega.size() - kept;
    auto modes = std::make_shared<ScaledModes>();
    modes->omega = omega.head(kept);
    modes->V = form_->V.leftCols(kept);
    modes->E = form_->E.topRows(kept);
    modes->n_rigid = std::min(form_->n_rigid, kept);
    modes->n_scaled = high;
    modes->method = "all modes";
    if (high == 0) return modes;
    modes->lowest_scaled = omega[kept];
    auto part = std::make_shared<HighModes>(form_, kept, clip);
    const auto E = form_->E.bottomRows(high);
    if (!E.isZero(0)) {
      // S M^ R = V diag(clip / omega)^2 E, and its product with M^ R
      const Matrix scaled = part->scale().asDiagonal() * E;
      modes->rigid_response = form_->V.rightCols(high) * (part->scale().asDiagonal() * scaled);
      modes->rigid_gram = scaled.transpose() * scaled;
    }
    modes->part = std::move(part);
    return modes;
  }

  std::shared_ptr<const DiagonalForm> form_;
};

}  // namespace

std::shared_ptr<const ScaledModes> ScaledModel::clipped(double clip) {
  if (last_ && last_clip_ == clip) return last_;
  std::shared_ptr<ScaledModes> modes = make(clip);
  modes->clip = modes->part ? clip : modes->largest_frequency();
  if (modes->rows.size() == 0) modes->rows = displacement_rows(*superelement_);
  last_ = std::move(modes);
  last_clip_ = clip;
  return last_;
}

std::shared_ptr<ScaledModel> scaled_model(std::shared_ptr<const Superelement> superelement,
                                          std::shared_ptr<const DiagonalForm> form) {
  return std::make_shared<ModelOfForm>(std::move(superelement), std::move(form));
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Modal mass scaling where all modes would cost too much: those below the clip, and the flexibility
// of the rest.

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/linalg/dense_factor.hpp"
#include "common/linalg/eigen/lanczos_below.hpp"
#include "dynamics/motion/scaled/scaled_model.hpp"
#include "dynamics/motion/scaled/scaled_system.hpp"

namespace cbr {
namespace {

// Up to here all modes are a matter of seconds.
constexpr Index small_enough_for_all_modes = 2000;

// S = clip^2 (F - Phi diag(1/omega^2) Phi^T), Phi the kept elastic modes in free coordinates.
class FlexibilityPart final : public ScaledPart {
 public:
  FlexibilityPart(std::shared_ptr<const ScaledSystem> system,
                  std::shared_ptr<const ElasticFlexibility> flexibility, Matrix Phi,
                  const Vector& omega, double clip)
      : system_(std::move(system)),
        flexibility_(std::move(flexibility)),
        clip2_(clip * clip),
        B_(std::move(Phi)) {
    B_.array().rowwise() /= omega.array().transpose();
  }

  Matrix times(const Matrix& F) const override {
    const Matrix load = system_->gather(F);
    Matrix X = load;
    flexibility_->solve(X);
    if (B_.cols() > 0) X.noalias() -= B_ * Matrix(B_.transpose() * load);
    return system_->spread(clip2_ * X);
  }

  Matrix block(const std::vector<Index>& coordinates) const override {
    Matrix S = flexibility_->interface_block(coordinates);
    const Index m = S.rows();
    if (B_.cols() > 0 && m > 0) {
      const Matrix B_all = system_->spread(B_);
      Matrix B = Matrix::Zero(m, B_.cols());
      for (Index i = 0; i < m; ++i)
        if (coordinates[i] >= 0) B.row(i) = B_all.row(coordinates[i]);
      S.selfadjointView<Eigen::Lower>().rankUpdate(B, -1);
    }
    S *= clip2_;
    mirror_lower(S);
    return S;
  }

 private:
  std::shared_ptr<const ScaledSystem> system_;
  std::shared_ptr<const ElasticFlexibility> flexibility_;
  double clip2_ = 0;
  Matrix B_;  // Phi diag(1/omega), n x kept elastic
};

// Whether K^ - shift M^ is positive definite once `X` (M-orthonormal eigenvectors, n x p, of
// eigenvalues >= 0) is lifted above it: then X has all eigenvectors below the shift.
bool has_all_below(const ScaledSystem& s, const Matrix& X, double shift) {
  const Index k = s.k();
  // D = K^ - shift M^ + 2 shift (M^ X) (M^ X)^T, its modal coordinates eliminated first
  const Matrix B = std::sqrt(2 * shift) * s.times_mass(X);
  const auto B_k = B.topRows(k), B_f = B.bottomRows(s.f());
  Matrix D = s.K();
  D.triangularView<Eigen::Lower>() -= shift * s.M();
  if (B.cols() > 0) D.selfadjointView<Eigen::Lower>().rankUpdate(B_f);
  if (k > 0) {
    Matrix D_kk = B_k * B_k.transpose(), D_kf = -shift * s.A();
    D_kk.diagonal().array() += s.lambda().array() - shift;
    D_kf.noalias() += B_k * B_f.transpose();
    if (!dense_cholesky(D_kk)) return false;
    D_kk.triangularView<Eigen::Lower>().solveInPlace(D_kf);
    D.selfadjointView<Eigen::Lower>().rankUpdate(D_kf.transpose(), -1);
  }
  return dense_cholesky(D);
}

class ModelOfMatrices final : public ScaledModel {
 public:
  ModelOfMatrices(std::shared_ptr<const Superelement> superelement, std::vector<HeldDirection> held,
                  std::string where)
      : ScaledModel(superelement),
        shared_(superelement),
        held_(std::move(held)),
        where_(std::move(where)) {
    system_ = std::make_shared<ScaledSystem>(std::move(superelement), held_, where_);
  }

  Index n_modes() const override { return system_->n(); }

  double largest_frequency() override {
    if (largest_ < 0) largest_ = all_ ? all_->largest_frequency() : system_->largest_frequency();
    return largest_;
  }

 private:
  std::shared_ptr<ScaledModes> make(double clip) override {
    if (all_ || !(clip < largest_frequency()))
      return of_all_modes(clip, "the clip frequency is above all modes");
    if (!flexibility_) flexibility_ = std::make_shared<ElasticFlexibility>(system_);
    const Eigenpairs pairs = modes_up_to(clip);
    if (!pairs.converged)
      return of_all_modes(clip, "a large part of all modes is below the clip frequency");
    return make_from(pairs, clip);
  }

  // Elastic modes, all up to the clip and at least one above it; not converged where that takes too
  // many.
  Eigenpairs modes_up_to(double clip) const {
    const ScaledSystem& s = *system_;
    const auto times_mass = [&](const Eigen::Ref<const Matrix>& X) { return s.times_mass(X); };
    const auto solve = [&](Eigen::Ref<Matrix> B) { flexibility_->solve(B); };
    const double shift = clip * clip;
    LanczosBelowOptions options;
    // A block finds as many copies of a multiple eigenvalue as it has columns
    for (const Index block : {Index{0}, Index{32}}) {
      options.block = block;
      Eigenpairs pairs = lanczos_below(s.n(), s.n_rigid(), times_mass, solve, shift, options);
      if (!pairs.converged) continue;
      Matrix X(s.n(), s.n_rigid() + pairs.lambda.size());
      X << Matrix::Zero(s.k(), s.n_rigid()), pairs.Phi.topRows(s.k()), s.rigid_modes(),
          pairs.Phi.bottomRows(s.f());
      if (has_all_below(s, X, shift)) return pairs;
    }
    return {};
  }

  std::shared_ptr<ScaledModes> make_from(const Eigenpairs& pairs, double clip) const {
    const ScaledSystem& s = *system_;
    const Index r = s.n_rigid(), e = (pairs.lambda.array() <= clip * clip).count();
    auto modes = std::make_shared<ScaledModes>();
    modes->method = pairs.method;
    modes->n_rigid = r;
    modes->n_scaled = s.n() - r - e;
    modes->omega = Vector::Zero(r + e);
    modes->omega.tail(e) = pairs.lambda.head(e).cwiseSqrt();
    modes->lowest_scaled = std::sqrt(pairs.lambda(e));
    Matrix Phi = pairs.Phi.leftCols(e), N = Matrix::Zero(s.n(), r);
    N.bottomRows(s.f()) = s.rigid_modes();
    modes->V.resize(shared_->n(), r + e);
    modes->V << s.spread(N), s.spread(Phi);
    modes->E = modes->V.transpose() * s.momentum();
    const bool free = !s.is_held() && r == 6;
    if (free) use_exact_rigid_modes(*modes);
    modes->part = std::make_shared<FlexibilityPart>(system_, flexibility_, std::move(Phi),
                                                    modes->omega.tail(e), clip);
    if (!free) {
      modes->rigid_response = modes->part->times(s.momentum());
      modes->rigid_gram = s.momentum().transpose() * modes->rigid_response;
    }
    return modes;
  }

  // V_r = R L^-T, L L^T = R^T M^ R of the full component when the matrices agree with it, and E =
  // L^T for the rigid modes, 0 for all others: impulses then change the momentum by exactly their
  // sum.
  void use_exact_rigid_modes(ScaledModes& modes) const {
    const RigidBody& body = shared_->rigid_body;
    const Matrix R = reduced_rigid_modes(*shared_, body.center);
    const Matrix own = R.transpose() * system_->momentum();
    Matrix mass = Matrix::Zero(6, 6);
    mass.diagonal().head(3).setConstant(body.mass);
    mass.bottomRightCorner(3, 3) = body.inertia;
    const Cholesky whole(mass);
    const auto differ = [&](auto block) {
      return (block(mass) - block(own)).norm() > 1e-6 * block(own).norm();
    };
    if (!whole.ok() || differ([](const Matrix& A) { return Matrix(A.topLeftCorner(3, 3)); }) ||
        differ([](const Matrix& A) { return Matrix(A.bottomRightCorner(3, 3)); }))
      refuse_rigid_modes(where_);
    modes.V.leftCols(6) = R;
    whole.divide_by_upper(modes.V.leftCols(6));
    modes.E.setZero();
    modes.E.topRows(6) = whole.upper();
  }

  std::shared_ptr<ScaledModes> of_all_modes(double clip, const std::string& reason) {
    if (system_->n() > small_enough_for_all_modes)
      throw RunError(where_ + ": time.mass_scaling: " + reason + ", and all " +
                     std::to_string(system_->n()) +
                     " of them would have to be computed: leave out time.mass_scaling, take a "
                     "larger step, or run cbr-reduce " +
                     "--diagonal-limit " + std::to_string(shared_->n()));
    if (!all_) {
      auto form = std::make_shared<DiagonalForm>();
      if (held_.empty()) {
        Superelement copy = *shared_;
        *form = free_diagonal_form(copy, where_);
      } else {
        *form = held_diagonal_form(*shared_, held_, where_);
      }
      all_ = scaled_model(shared_, std::shared_ptr<const DiagonalForm>(std::move(form)));
      flexibility_.reset();
    }
    return std::make_shared<ScaledModes>(*all_->clipped(clip));
  }

  std::shared_ptr<const Superelement> shared_;
  std::vector<HeldDirection> held_;
  std::string where_;
  std::shared_ptr<const ScaledSystem> system_;
  std::shared_ptr<const ElasticFlexibility> flexibility_;
  std::shared_ptr<ScaledModel> all_;
  double largest_ = -1;
};

}  // namespace

std::shared_ptr<ScaledModel> scaled_model(std::shared_ptr<const Superelement> superelement,
                                          std::vector<HeldDirection> held, std::string where) {
  return std::make_shared<ModelOfMatrices>(std::move(superelement), std::move(held),
                                           std::move(where));
}

}  // namespace cbr

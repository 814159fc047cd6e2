// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/solve/defect_model.hpp"

#include "common/files/state_archive.hpp"

namespace cbr {
namespace {

constexpr Index most_pairs = 8;
// Relative to a pair's p: remainder after projection onto newer ones. Smaller remainders are
// round-off of the defects.
constexpr double least_share = 1e-6;

}  // namespace

void DefectModel::add(const Vector& p, const Vector& defect) {
  if (p_.rows() != p.size()) {
    p_.resize(p.size(), most_pairs);
    defect_.resize(p.size(), most_pairs);
    n_ = 0;
  }
  newest_ = n_ == 0 ? 0 : (newest_ + 1) % most_pairs;
  n_ = std::min(n_ + 1, most_pairs);
  p_.col(newest_) = p;
  defect_.col(newest_) = defect;
  orthonormalise();
}

void DefectModel::orthonormalise() {
  if (Q_.rows() != p_.rows()) {
    Q_.resize(p_.rows(), most_pairs);
    E_.resize(p_.rows(), most_pairs);
  }
  rank_ = 0;
  for (Index age = 0; age < n_; ++age) {
    const Index column = (newest_ - age + most_pairs) % most_pairs;
    auto q = Q_.col(rank_), e = E_.col(rank_);
    q = p_.col(column);
    e = defect_.col(column);
    const double length = q.norm();
    for (int pass = 0; pass < 2; ++pass)
      for (Index k = 0; k < rank_; ++k) {
        const double share = Q_.col(k).dot(q);
        q -= share * Q_.col(k);
        e -= share * E_.col(k);
      }
    const double rest = q.norm();
    if (!(rest > least_share * length)) continue;
    q /= rest;
    e /= rest;
    ++rank_;
  }
}

void DefectModel::predict(const Vector& p, Vector& defect) {
  defect.setZero(p.size());
  if (n_ == 0 || p_.rows() != p.size()) return;
  rest_ = p;
  for (Index k = 0; k < rank_; ++k) {
    const double share = Q_.col(k).dot(rest_);
    rest_ -= share * Q_.col(k);
    defect += share * E_.col(k);
  }
}

void DefectModel::renumber(const std::vector<Index>& from) {
  if (n_ == 0) return;
  for (Matrix* of : {&p_, &defect_}) {
    const Matrix old = *of;
    of->setZero(static_cast<Index>(from.size()), most_pairs);
    for (std::size_t i = 0; i < from.size(); ++i)
      if (from[i] >= 0) of->row(static_cast<Index>(i)) = old.row(from[i]);
  }
  orthonormalise();
}

void DefectModel::keep_state(StateArchive& archive) {
  archive(n_, newest_, rank_);
  archive.first_columns(p_, n_);
  archive.first_columns(defect_, n_);
  archive.first_columns(Q_, rank_);
  archive.first_columns(E_, rank_);
}

}  // namespace cbr

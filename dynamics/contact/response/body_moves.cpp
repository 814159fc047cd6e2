// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/response/body_moves.hpp"

#include <array>

#include "common/linalg/blas_threads.hpp"
#include "common/linalg/kernels/symmetric_product.hpp"
#include "dynamics/contact/nodes/dense_panels.hpp"

namespace cbr {
// Terms of one body follow each other, so that most are found at a glance.
void BodyMoves::find_bodies(const ContactList& list, const std::vector<ContactBody>& bodies) {
  n_parts_ = 0;
  place_of_body_.clear();
  place_of_term_.clear();
  place_of_term_.reserve(list.terms.size());
  for (const ContactTerm& term : list.terms) {
    if (!place_of_term_.empty() && parts_[place_of_term_.back()].body == term.body) {
      place_of_term_.push_back(place_of_term_.back());
      continue;
    }
    const auto [at, is_new] = place_of_body_.try_emplace(term.body, n_parts_);
    place_of_term_.push_back(at->second);
    if (!is_new) continue;
    if (n_parts_ == parts_.size()) parts_.emplace_back();
    OfBody& part = parts_[n_parts_++];
    part.body = term.body;
    part.force.setZero(bodies[term.body].response.n_dofs() / 3, 3);
    part.is_known = false;
    part.answered = false;
  }
}

void BodyMoves::push(const ContactList& list, const std::vector<PointLaw>& laws, const Vector& p,
                     const std::vector<ContactBody>& bodies, const StaticAnswers* known) {
  find_bodies(list, bodies);
  add_forces(list, laws, p);
  for (std::size_t i = 0; known != nullptr && i < known->body.size(); ++i) {
    OfBody& part = parts_[place_of_body_.at(known->body[i])];
    part.still = known->still[i];
    part.is_known = true;
  }
  respond(bodies);
}

void BodyMoves::add_forces(const ContactList& list, const std::vector<PointLaw>& laws,
                           const Vector& p) {
  Index row = 0;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    const Index n = n_rows(laws[i].law);
    Vector3 impulse = p[row] * point.frame.row(0).transpose();
    for (Index d = 1; d < n; ++d) impulse += p[row + d] * point.frame.row(d).transpose();
    row += n;
    if (impulse.isZero(0)) continue;
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      parts_[place_of_term_[t]].force.row(term.node) += term.coefficient * impulse.transpose();
    }
  }
}

void BodyMoves::respond(const std::vector<ContactBody>& bodies) {
  for (std::size_t a = 0; a < n_parts_; ++a) {
    OfBody& part = parts_[a];
    if (part.answered) continue;
    const NodeResponse& S = bodies[part.body].response;
    if (!S.is_diagonal()) {
      respond_together(part, partner_of(a, bodies), bodies);
      continue;
    }
    part.move.setZero(part.force.rows(), 3);
    S.add_product(part.force, part.move);
    part.answered = true;
  }
}

// The next body with the same response, or none.
BodyMoves::OfBody* BodyMoves::partner_of(std::size_t a, const std::vector<ContactBody>& bodies) {
  const NodeResponse& S = bodies[parts_[a].body].response;
  for (std::size_t b = a + 1; b < n_parts_; ++b) {
    const NodeResponse& other = bodies[parts_[b].body].response;
    if (!parts_[b].answered && other.block == S.block && other.thin == S.thin) return &parts_[b];
  }
  return nullptr;
}

// In the axes of the response.
void BodyMoves::respond_together(OfBody& a, OfBody* b, const std::vector<ContactBody>& bodies) {
  const NodeResponse& S = bodies[a.body].response;
  const Index n = S.n_dofs();
  std::array<OfBody*, 2> parts{&a, b};
  given_.resize(n, b ? 2 : 1);
  const bool is_known = S.thin && a.is_known && (b == nullptr || b->is_known);
  if (is_known) still_.resize(S.thin->rows->size(), given_.cols());
  for (Index k = 0; k < given_.cols(); ++k) {
    const Matrix3& axes = bodies[parts[k]->body].response.axes;
    for (Index i = 0; i < n / 3; ++i)
      given_.col(k).segment<3>(3 * i) = axes.transpose() * parts[k]->force.row(i).transpose();
    if (is_known) still_.col(k) = parts[k]->still;
  }
  if (S.thin) {
    bytes_ += cbr::respond(*S.thin, given_, answer_, still_, work_, is_known);
  } else {
    multiply_block(*S.block);
  }
  for (Index k = 0; k < given_.cols(); ++k) {
    OfBody& part = *parts[k];
    const Matrix3& axes = bodies[part.body].response.axes;
    part.move.resize(n / 3, 3);
    for (Index i = 0; i < n / 3; ++i)
      part.move.row(i) = (axes * answer_.col(k).segment<3>(3 * i)).transpose();
    if (S.thin) part.still = still_.col(k);
    part.answered = true;
  }
}

// Over the columns on which either body has a force. Where these are most, half of the block is
// read for all.
void BodyMoves::multiply_block(const Matrix& S) {
  const Index n = S.rows();
  columns_.clear();
  for (Index i = 0; i < n / 3; ++i)
    for (int c = 0; c < 3 && !given_.middleRows(3 * i, 3).isZero(0); ++c)
      columns_.push_back(3 * i + c);
  const Index loaded = static_cast<Index>(columns_.size());
  const bool half = 2 * loaded > n;
  bytes_ += 8 * static_cast<double>(n) *
            (half ? 0.5 * static_cast<double>(n + 1) : static_cast<double>(loaded));
  answer_.setZero(n, given_.cols());
  if (half) {
    add_symmetric_product(S, given_, answer_, n_threads());
  } else {
    add_columns(S, columns_, given_, answer_, n_threads());
  }
}

void BodyMoves::add_to_gaps(const ContactList& list, const std::vector<PointLaw>& laws,
                            Vector& gap) const {
  Index row = 0;
  for (std::size_t i = 0; i < list.points.size(); ++i) {
    const ContactPoint& point = list.points[i];
    Vector3 moved = Vector3::Zero();
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = list.terms[t];
      moved += term.coefficient * parts_[place_of_term_[t]].move.row(term.node).transpose();
    }
    for (Index d = 0; d < n_rows(laws[i].law); ++d, ++row)
      gap[row] += point.frame.row(d).dot(moved);
  }
}

void BodyMoves::give(std::vector<ContactBody>& bodies) const {
  for (std::size_t a = 0; a < n_parts_; ++a) {
    ContactBody& body = bodies[parts_[a].body];
    body.move = parts_[a].move;
    body.still = parts_[a].still;
    body.has_move = true;
  }
}

}  // namespace cbr

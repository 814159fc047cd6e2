// SPDX-License-Identifier: GPL-3.0-or-later
// What the impulses of a step do to the ends and gaps, by products with the bodies' own responses.
#pragma once

#include <unordered_map>
#include <vector>

#include "dynamics/contact/response/response.hpp"
#include "dynamics/contact/response/standing_response.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

class BodyMoves {
 public:
  // move(b) = S_b f_b of all bodies that the list has terms on, f = G^T p (`p`: rows of W, see
  // first_rows). Bodies that share a response are answered in one pass over it.
  // `known`: what static rows answer p, or null.
  void push(const ContactList& list, const std::vector<PointLaw>& laws, const Vector& p,
            const std::vector<ContactBody>& bodies, const StaticAnswers* known = nullptr);
  // gap += G move, as rows of W; the list and laws of the last push().
  void add_to_gaps(const ContactList& list, const std::vector<PointLaw>& laws, Vector& gap) const;
  // Hands the moves to the bodies.
  void give(std::vector<ContactBody>& bodies) const;
  double bytes() const { return bytes_; }  // of dense responses, read so far

 private:
  struct OfBody {
    Index body = 0;
    Points force, move;     // scene axes
    Vector still;           // of a thin response
    bool is_known = false;  // it is
    bool answered = false;
  };
  void find_bodies(const ContactList& list, const std::vector<ContactBody>& bodies);
  void add_forces(const ContactList& list, const std::vector<PointLaw>& laws, const Vector& p);
  void respond(const std::vector<ContactBody>& bodies);
  OfBody* partner_of(std::size_t a, const std::vector<ContactBody>& bodies);
  void respond_together(OfBody& a, OfBody* b, const std::vector<ContactBody>& bodies);
  void multiply_block(const Matrix& S);

  std::vector<OfBody> parts_;  // the first n_parts_ are of this list
  std::size_t n_parts_ = 0;
  // In parts_, of each body and of each term. Nothing here is as large as the scene: every group of
  // points that is solved together keeps its own.
  std::unordered_map<Index, std::size_t> place_of_body_;
  std::vector<std::size_t> place_of_term_;
  std::vector<Index> columns_;
  // in the axes of a response, a column for each body that shares it
  Matrix given_, answer_, still_;
  ThinWork work_;
  double bytes_ = 0;
};

}  // namespace cbr

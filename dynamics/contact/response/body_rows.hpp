// SPDX-License-Identifier: GPL-3.0-or-later
// What a body has of the rows of G.
#pragma once

#include <vector>

#include "dynamics/contact/response/response.hpp"

namespace cbr {

// G_b in the axes of the body's response (r x 3 m_b), and which rows of G these are (ascending).
struct BodyRows {
  Index body = 0;
  const NodeResponse* response = nullptr;
  RowMajorSparse G;
  std::vector<Index> rows;
};

// The rows of all bodies that have any, in the order of the bodies. A: as in gap_response().
// in_body_axes: the frames of the points are in the axes of the bodies' responses already.
std::vector<BodyRows> rows_of_bodies(const ContactList& list, const std::vector<PointLaw>& laws,
                                     const std::vector<ContactBody>& bodies,
                                     NodeResponse ContactBody::*of, const SparseMatrix* A,
                                     bool in_body_axes = false);

// G_b B of the static rows of a thin response   (r x s)
RowMajorSparse static_rows_of(const RowMajorSparse& G, const StaticRows& rows);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/response: how gaps answer contact impulses.
//
// The response W of the gaps to contact impulses.
#pragma once

#include <vector>

#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/contact_surface.hpp"

namespace cbr {

using RowMajorSparse = Eigen::SparseMatrix<double, Eigen::RowMajor, Index>;

// One of the two is filled: `sparse` when every body answers node by node and there are many rows,
// else `dense`.
struct GapResponse {
  Matrix dense;         // m x m
  SparseMatrix sparse;  // m x m, both triangles
  bool is_sparse = false;
  Index size() const { return is_sparse ? sparse.rows() : dense.rows(); }
};

bool all_finite(const GapResponse& W);

// W p.
Vector apply(const GapResponse& W, const Vector& p);

// Number of the first row of each point, and the number of all rows at the end.
std::vector<Index> first_rows(const std::vector<PointLaw>& laws);

// W = G S G^T (m x m): change of the gaps at the end of the step per unit impulse; S of all bodies'
// contact nodes. A row of G: coefficient x direction on the nodes of the point's terms, directions
// being the rows of its frame. `of`: whose S, of positions or of velocities
// (&ContactBody::velocity_response). A: not null: rows of the points x n, W = A^T G S G^T A   (n x
// n).
GapResponse gap_response(const ContactList& list, const std::vector<PointLaw>& laws,
                         const std::vector<ContactBody>& bodies,
                         NodeResponse ContactBody::*of = &ContactBody::response,
                         const SparseMatrix* A = nullptr);

// Adds impulses (points x 3, in the points' frames) to the bodies': normal ones, those of tied
// points as they are, to `impulses`, tangential ones to `friction`.
void spread_impulses(const ContactList& list, const std::vector<PointLaw>& laws, const Points& p,
                     std::vector<ContactBody>& bodies);

// Whether two lists have the same terms and directions, so that W and its factor can be kept
// (`tolerance` absolute, on numbers of the order of one). Tangents count where `laws` (of both)
// have rows for them.
bool same_rows(const ContactList& a, const ContactList& b, const std::vector<PointLaw>& laws,
               double tolerance);

// What a body has of the rows of G.

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

// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/surfaces: points, faces and surfaces that can touch; independent
// of bodies.
//
// Contact's view of the bodies: current and predicted points, and faces between them.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/contact/nodes/node_response.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/projection.hpp"

namespace cbr {

// All contact nodes of one body; m nodes, numbered 0 .. m - 1.
struct ContactBody {
  Points start, end;  // m x 3: positions at the start and, as predicted, at the end of the step
  Points impulses;    // m x 3: in this step, without friction; filled by the enforcement
  Points friction;    // m x 3: friction impulses of this step
  bool rubs = false;  // a pair of the body has friction
  // m x 3: friction impulses of this step, all groups of pairs, and of the last step; mean
  // velocities of the last step. 0 rows: none, unknown
  Points rubbed = Points(0, 3), rubbed_before = Points(0, 3), velocity_before = Points(0, 3);
  // m x 3: constant forces during this step, and during the next; 0 rows: none
  Points lasting = Points(0, 3), lasting_next = Points(0, 3);
  // m x 3: change of `end` by impulses and friction, if the enforcement has computed it (has_move)
  Points move;
  Vector still;  // with a thin response: their effect on its static rows
  bool has_move = false;
  NodeResponse response;  // for steps of length response_h
  double response_h = 0;
  // Large rotation: rotation of the body since the start of this step. The response rotates with
  // it.
  std::optional<Matrix3> turn;
  // Large rotation: moment of this step, those of the impulses excluded
  Vector3 moment = Vector3::Zero();
  // Newmark: response of the velocities at the end of a step, filled on demand
  NodeResponse velocity_response;
  // Swept box of all nodes in this step, and the longest path of one, see sweep(). Default:
  // unbounded.
  Box swept{Vector3::Constant(-HUGE_VAL), Vector3::Constant(HUGE_VAL)};
  double longest_way = HUGE_VAL;
};

// Before the impulses of a step, or before others in their place.
inline void clear_impulses(ContactBody& body) {
  body.impulses.setZero();
  body.friction.setZero();
  body.has_move = false;
}

// Fills `swept` and `longest_way`, once for all pairs of the body: distant pairs then cost one
// comparison each. Call again when `end` has changed.
void sweep(ContactBody& body);

// An edge of a surface, from contact node a to b in the order of its first face; faces[1] -1: an
// open edge.
struct SurfaceEdge {
  Index a = 0, b = 0;
  std::array<Index, 2> faces{-1, -1};
  bool sharp = false;  // convex by more than 15 degrees, or open; undeformed
};

struct ContactSurface {
  std::string name;          // INSTANCE.SURFACE, for messages
  Index body = 0;            // index into the contact bodies
  std::vector<Index> nodes;  // of the faces, ascending, contact nodes of the body
  IndexTable faces;          // f x 4, contact nodes of the body; a triangle repeats its last
  // f x 5, or empty unless mortar. Mid-side nodes of second-order faces, between corner a and the
  // next (a triangle has three), then the central node of nine. -1: none. Other formulations cut
  // such faces into linear ones.
  IndexTable middle;
  Vector sizes;     // f, sqrt of the undeformed area: the face's length scale
  double size = 0;  // mean of `sizes`
  // size of a face's bounding box along the scene's axes, the largest of all faces, undeformed;
  // with large rotation: a bound for any orientation
  Vector3 extent = Vector3::Zero();
  // per node of `nodes`: tributary undeformed area, each face's divided among its corners
  Vector areas;
  // likewise, outward area vectors, scene axes: shorter than `areas` where the surface bends
  Points area_vectors;
  // Faces that share a node with face f and rise from it by more than 15 degrees: from
  // rising[rising_begin[f]] up to rising_begin[f + 1]. Both are empty if there are none.
  std::vector<Index> rising_begin, rising;
  // Filled by fill_edges(), where edges are tested.
  std::vector<SurfaceEdge> edges;
  std::shared_ptr<const ContactSurface> ridge;  // nodes of sharp edges; without faces
};

// Cosines between normals. Above the first (45 degrees) they constrain a node in the same
// direction. Above the second (15 degrees) a concave edge counts as flat.
constexpr double same_side = 0.7, nearly_flat = 0.966;

// Sizes, areas and rising faces; `points` are the undeformed contact nodes of the body.
void fill_sizes(ContactSurface& surface, const Points& points);

inline bool is_triangle(const ContactSurface& surface, Index face) {
  return surface.faces(face, 2) == surface.faces(face, 3);
}

inline int n_corners(const ContactSurface& surface, Index face) {
  return is_triangle(surface, face) ? 3 : 4;
}

// Position of a face's corner in the surface's nodes.
Index slot_of(const ContactSurface& surface, Index face, int corner);

inline bool is_quadratic(const ContactSurface& surface, Index face) {
  return surface.middle.rows() > 0 && surface.middle(face, 0) >= 0;
}

// The part of a node's tributary area that faces a master with the given outward normal. At an
// edge, faces at its sides do not count. A minimum fraction remains, for a corner that slides
// along.
double facing_area(double area, const Vector3& area_vector, const Vector3& normal);
// `body`: rotation of the surface; without area_vectors: the whole area.
double facing_area(const ContactSurface& surface, Index slot, const ContactBody& body,
                   const Vector3& normal);

// Curvature of the surface from face to face: median of 1 - |area vector| / area over its nodes. 0:
// flat, or no area_vectors. beta^2 / 8 for faces that meet at an angle of beta.
double bend(const ContactSurface& surface);

inline bool has_centre(const ContactSurface& surface, Index face) {
  return surface.middle.rows() > 0 && surface.middle(face, 4) >= 0;
}

FaceCorners corners(const ContactSurface& surface, Index face, const Points& points);

// Outward unit normal from a face's diagonals; zero for a face without area.
Vector3 mean_normal(const FaceCorners& x);

Vector3 centre(const FaceCorners& x);

// Of the surface's nodes in the step: the mean motion, and the largest one relative to `drift`.
Vector3 mean_motion(const ContactSurface& surface, const ContactBody& body);
double largest_motion(const ContactSurface& surface, const ContactBody& body, const Vector3& drift);

// Fills `edges` and `ridge`; `points` are the undeformed contact nodes of the body.
void fill_edges(ContactSurface& surface, const Points& points);

// Unit vectors at a point of an edge: its direction, the outward normals of the adjacent faces, and
// the directions into these faces. At an open edge the missing face is assumed at a right angle.
struct EdgeWedge {
  Vector3 direction;
  std::array<Vector3, 2> normal, inward;
  // Normalised mean of the two normals.
  Vector3 outward() const { return (normal[0] + normal[1]).normalized(); }
};
EdgeWedge wedge_at(const ContactSurface& surface, const SurfaceEdge& edge, const Points& points);

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
// Front door of dynamics/contact/surfaces: points, faces and surfaces that can touch; knows no
// body.
//
// What contact knows of the bodies: points now and predicted, and faces between them.
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
  Points start, end;  // m x 3: positions now and predicted for the end of the step
  Points impulses;    // m x 3: of this step, filled by the enforcement; without friction
  Points friction;    // m x 3: of this step, of friction
  // m x 3: forces that last through this step, and those through the next; 0 rows: none
  struct Lasting {
    Points contact = Points(0, 3), friction = Points(0, 3);
    bool empty() const { return contact.rows() == 0; }
  };
  Lasting lasting, lasting_next;
  // m x 3: what both together do to `end`, where the enforcement knows it already (has_move)
  Points move;
  Vector still;  // with a thin response: what both do to its static rows
  bool has_move = false;
  NodeResponse response;  // for the step length response_h
  double response_h = 0;
  // Of a body that turns: by what it has turned in this step since the start. Its response turns
  // with it.
  std::optional<Matrix3> turn;
  // Of a body that turns: moments of this step beside those of the impulses, and of friction
  Vector3 moment = Vector3::Zero(), friction_moment = Vector3::Zero();
  // under newmark: of the velocities at the end of a step, once asked for
  NodeResponse velocity_response;
  // What all nodes sweep in this step and the longest way of one, see sweep(); not filled:
  // anywhere.
  Box swept{Vector3::Constant(-HUGE_VAL), Vector3::Constant(HUGE_VAL)};
  double longest_way = HUGE_VAL;
};

// Fills `swept` and `longest_way`, once for all pairs of the body: pairs that are apart then cost
// one comparison each. Again when `end` has changed.
void sweep(ContactBody& body);

// Of a surface, from contact node a to b as its first face goes around; faces[1] -1: an open edge.
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
  // f x 5 or empty, of mortar only: the mid-side nodes of faces of second order, between corner a
  // and the next (a triangle has three), and the one in the middle of a face of nine nodes. -1:
  // none. Elsewhere such faces are cut into linear ones.
  IndexTable middle;
  Vector sizes;     // f, sqrt of the undeformed area: the face's length scale
  double size = 0;  // their mean
  Vector3 extent =
      Vector3::Zero();  // of the box around a face, along each of the scene's axes, the largest of
                        // all faces, undeformed; of a body that turns: in any position
  // of `nodes`: their share of the undeformed area, a face's shared by its corners
  Vector areas;
  // likewise, outward, scene axes: shorter than `areas` where the surface bends at the node
  Points area_vectors;
  // Faces that rise by more than 15 degrees from face f where they share a node with it:
  // rising[rising_begin[f]] and so on up to rising_begin[f + 1]. Both empty where no two faces do.
  std::vector<Index> rising_begin, rising;
  // See fill_edges(): not filled where nothing but nodes is to be tested.
  std::vector<SurfaceEdge> edges;
  std::shared_ptr<const ContactSurface> ridge;  // the nodes of sharp edges; without faces
};

// Cosines between normals above which they hold a node in the same direction, 45 degrees, and above
// which a hollow edge between faces is as good as none, 15 degrees.
constexpr double same_side = 0.7, nearly_flat = 0.966;

// Sizes, areas and what rises from what; `points` are the undeformed contact nodes of the body.
void fill_sizes(ContactSurface& surface, const Points& points);

inline bool is_triangle(const ContactSurface& surface, Index face) {
  return surface.faces(face, 2) == surface.faces(face, 3);
}

inline int n_corners(const ContactSurface& surface, Index face) {
  return is_triangle(surface, face) ? 3 : 4;
}

// Place of a face's corner in the surface's nodes.
Index slot_of(const ContactSurface& surface, Index face, int corner);

inline bool is_quadratic(const ContactSurface& surface, Index face) {
  return surface.middle.rows() > 0 && surface.middle(face, 0) >= 0;
}

// Of a node's share of area, what faces a master whose outward normal is given: on an edge, the
// faces beside it do not count. At least a share of all of it, for a corner that slides along.
double facing_area(double area, const Vector3& area_vector, const Vector3& normal);
// `body` tells how the surface has turned; without area_vectors: all of it.
double facing_area(const ContactSurface& surface, Index slot, const ContactBody& body,
                   const Vector3& normal);

// How much the surface bends from face to face: 1 - |area vector| / area at its nodes, their
// median; 0: flat, beta^2 / 8 for faces that meet at an angle of beta. Without area_vectors: 0.
double bend(const ContactSurface& surface);

inline bool has_centre(const ContactSurface& surface, Index face) {
  return surface.middle.rows() > 0 && surface.middle(face, 4) >= 0;
}

FaceCorners corners(const ContactSurface& surface, Index face, const Points& points);

}  // namespace cbr

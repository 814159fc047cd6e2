// SPDX-License-Identifier: GPL-3.0-or-later
// Where bodies can touch, by all nodes against all faces: docs/theory.md, "Points".
#pragma once

#include <array>
#include <vector>

#include "common/base/types.hpp"

namespace cbr::test {

struct DenseSurface {
  Index body = 0;
  // linear ones, outward, visible nodes of the body; a triangle repeats its last
  std::vector<std::array<Index, 4>> faces;
  std::vector<Index> nodes;   // of the faces
  std::vector<double> sizes;  // of the faces, sqrt(area), undeformed
  double size = 0;            // their mean
  std::vector<std::vector<Index>>
      // of each face: those that meet it in a hollow corner sharper than 15 degrees, undeformed
      rising;
};
// Faces of 3, 4, 6 or 8 nodes a row; X: undeformed, scene axes.
DenseSurface dense_surface(Index body, const IndexTable& faces, const Points& X);

struct DenseWall {
  enum class Kind { plane, sphere, cylinder } kind = Kind::plane;
  Vector3 point, direction;
  double radius = 0;
  double distance(const Vector3& x) const;
  Vector3 normal(const Vector3& x) const;
};

// r = x of the slave node - sum of weight x of the master nodes; rows of `frame`: the normal out of
// the master, two tangents.
struct DensePoint {
  Matrix3 frame;
  // normal . r - g_0 at the end of the step without impulses, and at its start
  double gap = 0, start_gap = 0;
  // place of the slave node in its surface's nodes; of the master face
  Index slot = 0, face = -1;
  struct Term {
    Index body, node;
    double weight;
  };
  std::vector<Term> terms;
};

// What a pair remembers of each slave node.
struct DenseMemory {
  // touched in the last step; last since the surfaces were apart. -1: none
  std::vector<Index> face, known_face;
  std::vector<std::vector<Index>> touched;  // all faces, in the last step
  std::vector<double> offset;               // g_0, not above 0: an overlap that is left
  Points stretch;                           // of the springs of friction, scene axes
};

// Positions of all visible nodes of a body at the start and, without impulses, at the end of the
// step.
struct DensePath {
  const Points &start, &end;
};

// `initial`: the first step of the run.
std::vector<DensePoint> dense_wall_points(const DenseSurface& slave, const DenseWall& wall,
                                          const DensePath& path, bool initial, DenseMemory& memory);

std::vector<DensePoint> dense_face_points(const DenseSurface& slave, const DensePath& slave_path,
                                          const DenseSurface& master, const DensePath& master_path,
                                          bool initial, DenseMemory& memory);

// How deep a node that starts the step in front of a face, well over it, ends behind it, whatever
// the rules above make of the two: the deepest, as a share of the face's size.
double dense_depth(const DenseSurface& slave, const DensePath& slave_path,
                   const DenseSurface& master, const DensePath& master_path);

// After the step, with the gaps at its end and the normal impulses.
void dense_remember(const DenseSurface& slave, const std::vector<DensePoint>& points,
                    const std::vector<double>& end_gap, const std::vector<double>& p_n,
                    double master_size, DenseMemory& memory);

// What the searches share.
void start(const DenseSurface& slave, DenseMemory& memory);
Matrix3 dense_frame(const Vector3& normal);
// Gaps up to this belong to the step: nodes beside those in contact are drawn in by about as much
// as anything moves.
double dense_reach(double size, double way, bool initial);

}  // namespace cbr::test

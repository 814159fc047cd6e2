// SPDX-License-Identifier: GPL-3.0-or-later
// Contact points by all nodes against all faces: docs/theory.md, "Points".
#pragma once

#include <array>
#include <vector>

#include "common/base/types.hpp"

namespace cbr::test {

struct DenseSurface {
  Index body = 0;
  // linear, outward, visible nodes of the body; a triangle repeats its last
  std::vector<std::array<Index, 4>> faces;
  std::vector<Index> nodes;   // of the faces
  std::vector<double> sizes;  // of the faces, sqrt(area), undeformed
  double size = 0;            // mean of `sizes`
  std::vector<std::vector<Index>>
      // of each face: those that form a concave corner sharper than 15 degrees with it, undeformed
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

// r = x of the slave node - sum of weight x of the master nodes. Rows of `frame`: the normal out of
// the master, two tangents.
struct DensePoint {
  Matrix3 frame;
  // normal . r - g_0 at the end of the step without impulses, and at its start
  double gap = 0, start_gap = 0;
  // position of the slave node in its surface's nodes; of the master face
  Index slot = 0, face = -1;
  struct Term {
    Index body, node;
    double weight;
  };
  std::vector<Term> terms;
};

// State of a pair, per slave node.
struct DenseMemory {
  // touched in the last step; last one since the surfaces were apart. -1: none
  std::vector<Index> face, known_face;
  std::vector<std::vector<Index>> touched;  // all faces, in the last step
  std::vector<double> offset;               // g_0 <= 0: a tolerated overlap
  Points stretch;                           // of friction springs, scene axes
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

// Largest depth at the end of nodes that start the step in front of a face, well over it,
// independent of the rules above. Relative to the face's size.
double dense_depth(const DenseSurface& slave, const DensePath& slave_path,
                   const DenseSurface& master, const DensePath& master_path);

// Call after the step, with the final gaps and the normal impulses.
void dense_remember(const DenseSurface& slave, const std::vector<DensePoint>& points,
                    const std::vector<double>& end_gap, const std::vector<double>& p_n,
                    double master_size, DenseMemory& memory);

// Initialises `memory`, for all searches.
void start(const DenseSurface& slave, DenseMemory& memory);
Matrix3 dense_frame(const Vector3& normal);
// Largest gap of interest in the step: neighbours of nodes in contact are drawn in by about the
// largest motion.
double dense_reach(double size, double way, bool initial);

}  // namespace cbr::test

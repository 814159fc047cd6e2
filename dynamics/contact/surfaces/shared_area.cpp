// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/shared_area.hpp"

#include <algorithm>
#include <span>

#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/contact/surfaces/contact_point.hpp"
#include "dynamics/contact/surfaces/mortar_segment.hpp"

namespace cbr {
namespace {

Box box_of(const FaceCorners& corners, double margin) {
  Box box{corners[0], corners[0]};
  for (const Vector3& x : corners) {
    box.lower = box.lower.cwiseMin(x);
    box.upper = box.upper.cwiseMax(x);
  }
  return {box.lower.array() - margin, box.upper.array() + margin};
}

bool holds(const Polygon& polygon, const Vector2& x, double round_off) {
  for (int i = 0; i < polygon.n; ++i) {
    const Vector2& from = polygon.x[i];
    if (cross(polygon.x[(i + 1) % polygon.n] - from, x - from) < -round_off) return false;
  }
  return true;
}

// A face seen along its normal, and what lies over it.
struct CoveredFace {
  FaceCorners x;
  Matrix3 frame;
  FlatFace flat;
  double covered = 0;             // area
  std::array<bool, 4> is_over{};  // corners

  void add(const FaceCorners& other, bool triangle, double size) {
    const FlatFace over = flatten(other, triangle, frame, x[0], false);
    for (const FacePiece& theirs : std::span(over.pieces).first(over.n_pieces)) {
      for (const FacePiece& own : std::span(flat.pieces).first(flat.n_pieces))
        covered += std::max(0.0, area(clip(own.outline, theirs.outline)));
      for (std::size_t a = 0; a < 4; ++a)
        is_over[a] |=
            holds(theirs.outline, frame.bottomRows<2>() * (x[a] - x[0]), 1e-9 * size * size);
    }
  }
};

}  // namespace

Points shared_areas(const ContactSurface& slave, const Points& slave_positions,
                    const ContactSurface& master, const Points& master_positions,
                    const std::vector<char>& has_point) {
  std::vector<Index> faces;
  std::vector<Box> near, targets;
  for (Index f = 0; f < slave.faces.rows(); ++f) {
    bool any = false;
    for (int a = 0; a < n_corners(slave, f); ++a) any |= has_point[slot_of(slave, f, a)] != 0;
    if (!any) continue;
    faces.push_back(f);
    near.push_back(box_of(corners(slave, f, slave_positions), slave.sizes[f]));
  }
  for (Index f = 0; f < master.faces.rows(); ++f)
    targets.push_back(box_of(corners(master, f, master_positions), 0));
  BroadPhase grid;
  find_candidates(near, targets, grid);
  Points shared = Points::Zero(static_cast<Index>(slave.nodes.size()), 3);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Index f = faces[i];
    const double size = slave.sizes[f];
    const int n = n_corners(slave, f);
    CoveredFace face{corners(slave, f, slave_positions), {}, {}};
    face.frame = contact_frame(mean_normal(face.x));
    face.flat = flatten(face.x, n == 3, face.frame, face.x[0], true);
    for (int a = 0; a < n; ++a) face.is_over[a] = has_point[slot_of(slave, f, a)] != 0;
    for (Index k = grid.candidates.first[i]; k < grid.candidates.first[i + 1]; ++k) {
      const Index other = grid.candidates.target[k];
      face.add(corners(master, other, master_positions), is_triangle(master, other), size);
    }
    double whole = 0;
    for (const FacePiece& own : std::span(face.flat.pieces).first(face.flat.n_pieces))
      whole += own.area;
    if (!(whole > 0)) continue;
    const auto n_over = std::count(face.is_over.begin(), face.is_over.begin() + n, true);
    const double share =
        std::min(1.0, face.covered / whole) * size * size / static_cast<double>(n_over);
    for (int a = 0; a < n; ++a)
      if (face.is_over[a]) shared.row(slot_of(slave, f, a)) += share * face.frame.row(0);
  }
  return shared;
}

}  // namespace cbr

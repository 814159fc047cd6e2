// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/tie.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/linalg/dense.hpp"
#include "dynamics/contact/search/mortar.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"

namespace cbr {
namespace {

struct Foot {
  Index face = -1;
  std::array<double, 4> weights{};
  Vector3 offset = Vector3::Zero();
  double distance = HUGE_VAL;
};

// Boxes of slave nodes, without extent; of faces, each grown by the reach of a tie.
void fill_boxes(const ContactSurface& slave, const Points& slave_positions,
                const ContactSurface& master, const Points& master_positions, const Vector& reach,
                std::vector<Box>& nodes, std::vector<Box>& faces) {
  for (const Index node : slave.nodes) {
    const Vector3 x = slave_positions.row(node).transpose();
    nodes.push_back({x, x});
  }
  for (Index f = 0; f < master.faces.rows(); ++f) {
    Box box{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
    for (const Vector3& x : corners(master, f, master_positions)) {
      box.lower = box.lower.cwiseMin(x);
      box.upper = box.upper.cwiseMax(x);
    }
    faces.push_back({box.lower.array() - reach[f], box.upper.array() + reach[f]});
  }
}

Foot foot_on(const ContactSurface& master, Index face, const Points& positions, const Vector3& x) {
  const FaceCorners at = corners(master, face, positions);
  Foot foot;
  foot.face = face;
  foot.weights = project(at, is_triangle(master, face), x).weights;
  foot.offset = x;
  for (int a = 0; a < 4; ++a) foot.offset -= foot.weights[a] * at[a];
  foot.distance = foot.offset.norm();
  return foot;
}

void add_tie(const ContactSurface& slave, Index slot, const ContactSurface& master,
             const Foot& foot, ContactList& ties) {
  ContactPoint point;
  point.area = slave.areas[slot];
  point.slot = slot;
  point.face = foot.face;
  point.first_term = static_cast<Index>(ties.terms.size());
  ties.terms.push_back({slave.body, slave.nodes[slot], 1});
  for (int a = 0; a < 4; ++a)
    if (foot.weights[a] != 0)
      ties.terms.push_back({master.body, master.faces(foot.face, a), -foot.weights[a]});
  point.n_terms = static_cast<Index>(ties.terms.size()) - point.first_term;
  ties.points.push_back(point);
}

constexpr double line_width = 1e-6;  // relative to the length: a narrower set of points is a line

// Free rigid motions of points at positions `x` (n x 3), with all directions tied at each.
Index free_motions(const Points& x) {
  const Points apart = x.rowwise() - x.colwise().mean();
  const Vector3 spread = symmetric_eigenvalues3(apart.transpose() * apart);
  const double least = 1e-24 * x.cwiseAbs2().maxCoeff();  // round-off of the positions
  if (!(spread[2] > least)) return 3;
  return spread[1] > line_width * line_width * spread[2] ? 0 : 1;
}

Points tied_positions(const ContactList& ties, Index first_point, Index slave,
                      const Points& positions) {
  const Index n = static_cast<Index>(ties.points.size()) - first_point;
  Points x = Points::Zero(n, 3);
  for (Index i = 0; i < n; ++i) {
    const ContactPoint& point = ties.points[first_point + i];
    double sum = 0;
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = ties.terms[t];
      if (term.body != slave) continue;
      x.row(i) += term.coefficient * positions.row(term.node);
      sum += term.coefficient;
    }
    if (sum != 0) x.row(i) /= sum;
  }
  return x;
}

void append(const std::vector<Vector3>& found, Points& offsets) {
  const Index before = offsets.rows();
  offsets.conservativeResize(before + static_cast<Index>(found.size()), 3);
  for (std::size_t i = 0; i < found.size(); ++i)
    offsets.row(before + static_cast<Index>(i)) = found[i].transpose();
}

}  // namespace

std::string tie_text(const TieReport& report, const ContactSurface& slave) {
  const auto n = static_cast<Index>(slave.nodes.size());
  if (report.without_partner == 0 && report.free_motions == 0) return "";
  return std::to_string(n - report.without_partner) + " of the " + std::to_string(n) +
         " nodes of " + slave.name + " are tied" +
         (report.free_motions == 3   ? ", at one point: a ball joint, unless other ties hold too"
          : report.free_motions == 1 ? ", along one line: a hinge, unless other ties hold too"
                                     : "");
}

TieReport tie_surfaces(const ContactSurface& slave, const Points& slave_positions,
                       const ContactSurface& master, const Points& master_positions,
                       std::optional<double> tolerance, ContactList& ties, Points& offsets) {
  const Vector reach = tolerance ? Vector::Constant(master.faces.rows(), *tolerance)
                                 : Vector(usual_adjust * master.sizes);
  std::vector<Box> nodes, faces;
  fill_boxes(slave, slave_positions, master, master_positions, reach, nodes, faces);
  BroadPhase grid;
  find_candidates(nodes, faces, grid);
  const auto before = static_cast<Index>(ties.points.size());
  TieReport report;
  std::vector<Vector3> found;
  for (Index slot = 0; slot < static_cast<Index>(slave.nodes.size()); ++slot) {
    Foot nearest;
    for (Index k = grid.candidates.first[slot]; k < grid.candidates.first[slot + 1]; ++k) {
      const Index face = grid.candidates.target[k];
      const Foot foot = foot_on(master, face, master_positions, nodes[slot].lower);
      if (foot.distance <= reach[face] && foot.distance < nearest.distance) nearest = foot;
    }
    if (nearest.face < 0) {
      ++report.without_partner;
      continue;
    }
    add_tie(slave, slot, master, nearest, ties);
    found.push_back(nearest.offset);
    report.largest_offset = std::max(report.largest_offset, nearest.distance);
  }
  append(found, offsets);
  report.n_points = static_cast<Index>(found.size());
  if (!found.empty())
    report.free_motions = free_motions(tied_positions(ties, before, slave.body, slave_positions));
  return report;
}

TieReport tie_mortar(const ContactSurface& slave, const Points& slave_positions,
                     const ContactSurface& master, const Points& master_positions,
                     const DetectionOptions& options, std::optional<double> tolerance,
                     ContactList& ties, Points& offsets) {
  ContactBody a, b;
  a.start = a.end = slave_positions;
  b.start = b.end = master_positions;
  PairMemory memory;
  memory.lets_jump = true;
  ContactList near;
  detect_mortar(slave, a, master, b, true, options, memory, near);
  const auto before = static_cast<Index>(ties.points.size());
  TieReport report;
  std::vector<Vector3> found;
  for (ContactPoint point : near.points) {
    const double distance = std::abs(point.start_gap + memory.offset[point.slot]);
    if (distance > tolerance.value_or(usual_adjust * master.size)) continue;
    Vector3 r = Vector3::Zero();
    const Index first = static_cast<Index>(ties.terms.size());
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
      const ContactTerm& term = near.terms[t];
      ties.terms.push_back(term);
      r += term.coefficient * (term.body == slave.body ? a : b).start.row(term.node).transpose();
    }
    point.frame = Matrix3::Identity();
    point.first_term = first;
    ties.points.push_back(point);
    found.push_back(r);
    report.largest_offset = std::max(report.largest_offset, distance);
  }
  // Beside an edge a node may have two points. One without may be in those of its neighbours
  std::set<Index> held;
  for (const ContactTerm& term : ties.terms)
    if (term.body == slave.body) held.insert(term.node);
  report.without_partner = std::count_if(slave.nodes.begin(), slave.nodes.end(),
                                         [&](Index node) { return !held.count(node); });
  append(found, offsets);
  report.n_points = static_cast<Index>(found.size());
  if (!found.empty())
    report.free_motions = free_motions(tied_positions(ties, before, slave.body, slave_positions));
  return report;
}

void keep_independent(Index slave, const Points& positions, ContactList& ties, Points& offsets) {
  const Points x = tied_positions(ties, 0, slave, positions);
  std::array<Index, 3> at{};
  (x.rowwise() - x.colwise().mean()).rowwise().squaredNorm().maxCoeff(&at[0]);
  const Points apart = x.rowwise() - x.row(at[0]);
  const double length = std::sqrt(apart.rowwise().squaredNorm().maxCoeff(&at[1]));
  Matrix3 frame = Matrix3::Identity();  // rows: along the line, in the plane, normal to it
  if (length > 0) frame = contact_frame(apart.row(at[1]).transpose() / length);
  const Points beside = apart - apart * frame.row(0).transpose() * frame.row(0);
  const double width = std::sqrt(beside.rowwise().squaredNorm().maxCoeff(&at[2]));
  const std::size_t n = !(length > 0) ? 1 : width > line_width * length ? 3 : 2;
  if (n == 3) {
    frame.row(1) = beside.row(at[2]) / width;
    frame.row(2) = frame.row(0).cross(frame.row(1));
  }
  double area = 0;
  for (const ContactPoint& point : ties.points) area += point.area;
  ContactList kept;
  Points kept_offsets(static_cast<Index>(n), 3);
  for (std::size_t k = 0; k < n; ++k) {
    ContactPoint point = ties.points[at[k]];
    const auto first = ties.terms.begin() + point.first_term;
    point.frame = frame;
    point.frame.topRows(static_cast<Index>(k)).setZero();  // what the points before constrain
    point.area = k == 0 ? area : 0;
    point.first_term = static_cast<Index>(kept.terms.size());
    kept.terms.insert(kept.terms.end(), first, first + point.n_terms);
    kept.points.push_back(point);
    kept_offsets.row(static_cast<Index>(k)) = offsets.row(at[k]);
  }
  ties = std::move(kept);
  offsets = std::move(kept_offsets);
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/kept_candidates.hpp"

#include <algorithm>
#include <cmath>

#include "common/linalg/kernels/clones.hpp"

namespace cbr {
namespace {

// A skin of so many steps' motions, within shares of the mean face: a thick one holds for longer
// and holds more.
constexpr double skin_steps = 10, least_skin = 0.02, most_skin = 0.15;

// Searches that candidates serve before it pays to find fewer.
constexpr int enough_services = 3;

constexpr int lanes = 8;
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));

// Largest |x - ref - shift| of n rows of three, by components; not a number counts as infinite.
CBR_CLONES double largest_difference(const double* x, const double* ref, Index n,
                                     const double (&shift)[3]) {
  Lanes pattern[3], most[3] = {};
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < lanes; ++i) pattern[k][i] = shift[(k * lanes + i) % 3];
  Index at = 0;
  for (; at + 3 * lanes <= 3 * n; at += 3 * lanes) {
    for (int k = 0; k < 3; ++k) {
      Lanes a, b;
      __builtin_memcpy(&a, x + at + k * lanes, sizeof(Lanes));
      __builtin_memcpy(&b, ref + at + k * lanes, sizeof(Lanes));
      const Lanes d = a - b - pattern[k], size = d > 0 ? d : -d;
      most[k] = size <= most[k] ? most[k] : size;
    }
  }
  double largest = 0;
  const auto take = [&](double d) {
    largest = d <= largest ? largest : std::isnan(d) ? HUGE_VAL : d;
  };
  for (const Lanes& of : most)
    for (int i = 0; i < lanes; ++i) take(of[i]);
  for (; at < 3 * n; ++at) take(std::abs(x[at] - ref[at] - shift[at % 3]));
  return largest;
}

// Rows `nodes` of x; they follow each other where a body has no other contact nodes among them.
double largest_difference(const std::vector<Index>& nodes, const Points& x, const Points& ref,
                          const Vector3& shift) {
  const Index n = static_cast<Index>(nodes.size());
  const double s[3] = {shift[0], shift[1], shift[2]};
  if (n == 0) return 0;
  if (nodes.back() - nodes.front() + 1 == n)
    return largest_difference(x.row(nodes.front()).data(), ref.data(), n, s);
  double largest = 0;
  for (Index i = 0; i < n; ++i) {
    const double d = largest_difference(x.row(nodes[i]).data(), ref.row(i).data(), 1, s);
    largest = std::max(largest, d);
  }
  return largest;
}

Points rows(const std::vector<Index>& nodes, const Points& x) {
  Points of(static_cast<Index>(nodes.size()), 3);
  for (Index i = 0; i < of.rows(); ++i) of.row(i) = x.row(nodes[i]);
  return of;
}

Box box_of(const Vector3& a, const Vector3& b) { return {a.cwiseMin(b), a.cwiseMax(b)}; }

Box grown(const Box& box, const CandidateSearch& search, Index face, double skin) {
  const double far = std::max(search.margin, search.size_share * search.master.sizes[face]) + skin;
  const Vector3 margin = far + (search.overhang * (box.upper - box.lower)).array();
  return {box.lower - margin, box.upper + margin};
}

// How far any node is from where it was found, relative to the master, at any time of the step.
double moved(const CandidateSearch& search, const KeptCandidates& kept, double& of_master) {
  const Index first = search.master.nodes.front();
  const Vector3 shift = (search.master_body.end.row(first) - kept.master_at.row(0)).transpose();
  const Vector3 before = shift - search.drift;
  const auto largest = [&](const ContactSurface& surface, const ContactBody& body,
                           const Points& ref) {
    return std::max(largest_difference(surface.nodes, body.end, ref, shift),
                    largest_difference(surface.nodes, body.start, ref, before));
  };
  of_master = largest(search.master, search.master_body, kept.master_at);
  return of_master + largest(search.slave, search.slave_body, kept.slave_at);
}

// A search that reached far, as the first one does, has found more than is wanted from then on.
bool is_too_wide(const CandidateSearch& search, const KeptCandidates& kept) {
  return kept.served >= enough_services &&
         kept.margin > search.margin + 2 * most_skin * search.master.size;
}

bool still_holds(const CandidateSearch& search, const KeptCandidates& kept) {
  if (!kept.is_known || is_too_wide(search, kept)) return false;
  double of_master = 0;
  const double both = moved(search, kept, of_master);
  const double more = std::max(0.0, search.margin - kept.margin);
  return both + more + 2 * search.overhang * of_master <= kept.skin;
}

// Around where the nodes are at the end of the step, with the skin.
void keep(const CandidateSearch& search, PairMemory& memory) {
  KeptCandidates& kept = memory.kept;
  kept.slave_at = rows(search.slave.nodes, search.slave_body.end);
  kept.master_at = rows(search.master.nodes, search.master_body.end);
  kept.margin = search.margin;
  kept.is_known = true;
  kept.served = 0;
  memory.node_boxes.resize(search.slave.nodes.size());
  for (std::size_t i = 0; i < memory.node_boxes.size(); ++i) {
    const Vector3 x = kept.slave_at.row(static_cast<Index>(i)).transpose();
    memory.node_boxes[i] = {x, x};
  }
  memory.face_boxes.resize(static_cast<std::size_t>(search.master.faces.rows()));
  for (Index f = 0; f < search.master.faces.rows(); ++f) {
    const FaceCorners x = corners(search.master, f, search.master_body.end);
    const Box box{x[0].cwiseMin(x[1]).cwiseMin(x[2]).cwiseMin(x[3]),
                  x[0].cwiseMax(x[1]).cwiseMax(x[2]).cwiseMax(x[3])};
    memory.face_boxes[static_cast<std::size_t>(f)] = grown(box, search, f, kept.skin);
  }
}

void sweep_boxes(const CandidateSearch& search, PairMemory& memory) {
  memory.kept.is_known = false;
  memory.node_boxes.resize(search.slave.nodes.size());
  for (std::size_t i = 0; i < memory.node_boxes.size(); ++i)
    memory.node_boxes[i] = node_box(search, search.slave.nodes[i]);
  memory.face_boxes.resize(static_cast<std::size_t>(search.master.faces.rows()));
  for (Index f = 0; f < search.master.faces.rows(); ++f)
    memory.face_boxes[static_cast<std::size_t>(f)] = face_box(search, f);
}

}  // namespace

Box node_box(const CandidateSearch& search, Index node) {
  return box_of(search.slave_body.start.row(node).transpose() + search.drift,
                search.slave_body.end.row(node).transpose());
}

Box face_box(const CandidateSearch& search, Index face) {
  Box box{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
  for (int a = 0; a < 4; ++a) {
    const Index node = search.master.faces(face, a);
    const Box corner = box_of(search.master_body.start.row(node).transpose() + search.drift,
                              search.master_body.end.row(node).transpose());
    box.lower = box.lower.cwiseMin(corner.lower);
    box.upper = box.upper.cwiseMax(corner.upper);
  }
  return grown(box, search, face, 0);
}

void update_candidates(const CandidateSearch& search, PairMemory& memory) {
  if (still_holds(search, memory.kept)) {
    memory.kept.served = std::min(memory.kept.served + 1, enough_services);
    return;
  }
  const double size = search.master.size;
  // What is used up in a step or two is not worth a skin
  if (!(skin_steps * search.motion <= 3 * most_skin * size)) {
    sweep_boxes(search, memory);
  } else {
    memory.kept.skin = std::clamp(skin_steps * search.motion, least_skin * size, most_skin * size);
    keep(search, memory);
  }
  find_candidates(memory.node_boxes, memory.face_boxes, memory.grid);
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/search/kept_candidates.hpp"

#include <algorithm>
#include <cmath>

#include "common/linalg/kernels/clones.hpp"

namespace cbr {
namespace {

// Skin in motions of a step, within fractions of the mean face. A thick skin lasts longer and has
// more candidates.
constexpr double skin_steps = 10, least_skin = 0.02, most_skin = 0.15;

// Reuses of the candidates after which a smaller search pays off.
constexpr int enough_services = 3;

constexpr int lanes = 8;
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double))));

// Largest component of |x - ref - shift| over n rows of three; NaN counts as infinite.
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

// Rows `nodes` of x; they are contiguous unless other contact nodes of the body lie between.
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

Box grown(const Box& box, double by) { return {box.lower.array() - by, box.upper.array() + by}; }

Box grown(const Box& box, const CandidateSearch& search, Index face, double skin) {
  const double far = std::max(search.margin, search.size_share * search.master.sizes[face]) + skin;
  const Vector3 margin = far + (search.overhang * (box.upper - box.lower)).array();
  return {box.lower - margin, box.upper + margin};
}

Box joined(const Box& a, const Box& b) {
  return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
}

using Margins = std::array<double, 3>;

Margins margins_of(const CandidateSearch& search, const FurtherSearch* further) {
  if (further == nullptr) return {search.margin, 0, 0};
  return {search.margin, further->back.margin, further->edge_margin};
}

// Largest excess of `a` over `b`, at least 0.
double most_above(const Margins& a, const Margins& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, a[i] - b[i]);
  return most;
}

// Motion since the search relative to the master, in the whole step: the largest of the master's
// nodes plus that of the slave's. of_one: the larger of both.
double moved(const CandidateSearch& search, const KeptCandidates& kept, double& of_one) {
  const Index first = search.master.nodes.front();
  const Vector3 shift = (search.master_body.end.row(first) - kept.master_at.row(0)).transpose();
  const Vector3 before = shift - search.drift;
  const auto largest = [&](const ContactSurface& surface, const ContactBody& body,
                           const Points& ref) {
    return std::max(largest_difference(surface.nodes, body.end, ref, shift),
                    largest_difference(surface.nodes, body.start, ref, before));
  };
  const double of_master = largest(search.master, search.master_body, kept.master_at),
               of_slave = largest(search.slave, search.slave_body, kept.slave_at);
  of_one = std::max(of_master, of_slave);
  return of_master + of_slave;
}

// A search with a large reach, as the first one, finds more candidates than later steps need.
bool is_too_wide(const CandidateSearch& search, const FurtherSearch* further,
                 const KeptCandidates& kept) {
  return kept.served >= enough_services &&
         most_above(kept.margins, margins_of(search, further)) > 2 * most_skin * search.master.size;
}

bool still_holds(const CandidateSearch& search, const FurtherSearch* further,
                 const KeptCandidates& kept) {
  if (!kept.is_known || is_too_wide(search, further, kept)) return false;
  double of_one = 0;
  const double both = moved(search, kept, of_one);
  const double more = most_above(margins_of(search, further), kept.margins);
  return both + more + 2 * search.overhang * of_one <= kept.skin;
}

// Bounding boxes of nodes, faces and edges: at the end of the step with a skin, for reuse, or swept
// in the step.
class Boxes {
 public:
  Boxes(bool are_swept, double skin) : are_swept_(are_swept), skin_(skin) {}

  void of_nodes(const CandidateSearch& search, std::vector<Box>& boxes) const {
    boxes.clear();
    for (const Index node : search.slave.nodes)
      boxes.push_back(of_node(search.slave_body, search.drift, node));
  }
  void of_faces(const CandidateSearch& search, std::vector<Box>& boxes) const {
    boxes.clear();
    for (Index f = 0; f < search.master.faces.rows(); ++f) boxes.push_back(of_face(search, f));
  }
  Box of_face(const CandidateSearch& search, Index face) const {
    Box box = of_node(search.master_body, search.drift, search.master.faces(face, 0));
    for (int a = 1; a < 4; ++a)
      box = joined(box, of_node(search.master_body, search.drift, search.master.faces(face, a)));
    return grown(box, search, face, skin_);
  }
  Box of_node(const ContactBody& body, const Vector3& drift, Index node) const {
    const Vector3 x = body.end.row(node).transpose();
    return are_swept_ ? box_of(body.start.row(node).transpose() + drift, x) : Box{x, x};
  }
  Box of_edge(const ContactBody& body, const Vector3& drift, const SurfaceEdge& edge) const {
    return joined(of_node(body, drift, edge.a), of_node(body, drift, edge.b));
  }
  double skin() const { return skin_; }

 private:
  bool are_swept_;
  double skin_;
};

// Workspace of a search for edges.
struct EdgeBoxes {
  std::vector<Index> queried, tested;
  std::vector<Box> queries, targets;
  BroadPhase grid;
};

// Pairs of sharp edges of one side with edges of the other: all, or only those not sharp.
class EdgeCandidates {
 public:
  EdgeCandidates(const CandidateSearch& search, const Boxes& boxes, double margin)
      : search_(search), boxes_(boxes), margin_(margin + boxes.skin()) {}

  void find(std::vector<EdgePair>& pairs) {
    pairs.clear();
    const auto add = [&](bool slave_is_queried, bool any) {
      find(slave_is_queried, any);
      const CandidateList& list = work().grid.candidates;
      for (std::size_t i = 0; i + 1 < list.first.size(); ++i)
        for (Index k = list.first[i]; k < list.first[i + 1]; ++k) {
          const Index one = work().queried[i], other = work().tested[list.target[k]];
          pairs.push_back(slave_is_queried ? EdgePair{one, other} : EdgePair{other, one});
        }
    };
    add(true, true);
    add(false, false);
    std::sort(pairs.begin(), pairs.end());
  }

 private:
  static EdgeBoxes& work() {
    thread_local EdgeBoxes boxes;
    return boxes;
  }

  void find(bool slave_is_queried, bool any) {
    const ContactSurface &one = slave_is_queried ? search_.slave : search_.master,
                         &other = slave_is_queried ? search_.master : search_.slave;
    const ContactBody &one_body = slave_is_queried ? search_.slave_body : search_.master_body,
                      &other_body = slave_is_queried ? search_.master_body : search_.slave_body;
    EdgeBoxes& to = work();
    to.grid.candidates.first.clear();
    to.queried.clear();
    to.queries.clear();
    for (std::size_t e = 0; e < one.edges.size(); ++e) {
      if (!one.edges[e].sharp) continue;
      to.queried.push_back(static_cast<Index>(e));
      to.queries.push_back(boxes_.of_edge(one_body, search_.drift, one.edges[e]));
    }
    if (to.queried.empty()) return;
    to.tested.clear();
    to.targets.clear();
    for (std::size_t e = 0; e < other.edges.size(); ++e) {
      if (!any && other.edges[e].sharp) continue;
      to.tested.push_back(static_cast<Index>(e));
      to.targets.push_back(
          grown(boxes_.of_edge(other_body, search_.drift, other.edges[e]), margin_));
    }
    find_candidates(to.queries, to.targets, to.grid);
  }

  const CandidateSearch& search_;
  const Boxes& boxes_;
  double margin_;
};

// Records the positions of the nodes at the end of the step, for reuse of the candidates.
void keep(const CandidateSearch& search, const FurtherSearch* further, KeptCandidates& kept) {
  kept.slave_at = rows(search.slave.nodes, search.slave_body.end);
  kept.master_at = rows(search.master.nodes, search.master_body.end);
  kept.margins = margins_of(search, further);
  kept.is_known = true;
  kept.served = 0;
}

void find_nodes(const CandidateSearch& search, const Boxes& boxes, PairMemory& memory) {
  boxes.of_nodes(search, memory.node_boxes);
  boxes.of_faces(search, memory.face_boxes);
  find_candidates(memory.node_boxes, memory.face_boxes, memory.grid);
}

}  // namespace

Box node_box(const CandidateSearch& search, Index node) {
  return Boxes(true, 0).of_node(search.slave_body, search.drift, node);
}

Box face_box(const CandidateSearch& search, Index face) {
  return Boxes(true, 0).of_face(search, face);
}

void update_candidates(const CandidateSearch& search, const FurtherSearch* further,
                       PairMemory& memory) {
  KeptCandidates& kept = memory.kept;
  if (still_holds(search, further, kept)) {
    kept.served = std::min(kept.served + 1, enough_services);
    return;
  }
  const double size = search.master.size;
  // A skin that lasts only a step or two costs more than it saves
  const bool is_worth_it = search.skin > 0 || skin_steps * search.motion <= 3 * most_skin * size;
  kept.is_known = false;
  if (is_worth_it) {
    kept.skin = search.skin > 0
                    ? search.skin
                    : std::clamp(skin_steps * search.motion, least_skin * size, most_skin * size);
    keep(search, further, kept);
  }
  const Boxes boxes(!is_worth_it, is_worth_it ? kept.skin : 0);
  find_nodes(search, boxes, memory);
  if (further == nullptr) return;
  find_nodes(further->back, boxes, further->back_memory);
  EdgeCandidates(search, boxes, further->edge_margin).find(further->edge_memory.edge_candidates);
}

}  // namespace cbr

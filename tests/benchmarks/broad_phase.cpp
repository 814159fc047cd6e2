// SPDX-License-Identifier: GPL-3.0-or-later
// Candidates of node boxes against face boxes: the grid of cbr_dynamics and, as its rival, a
// bounding volume tree that is built once in the undeformed state and refitted in every step. Two
// scenes: a sheet that lies on another (all nodes touch) and two spheres (few do). Arguments:
// largest number of faces (default 100000). CSV to stdout: seconds a step, candidates; both must
// find the same.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>

#include "dynamics/contact/surfaces/broad_phase.hpp"

namespace {

using cbr::Box;
using cbr::Index;
using cbr::Vector3;

// Binary tree, split at the median of the longest side; nodes in the order of a depth-first walk,
// so that children follow parents.
class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box>& boxes) : order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), Index{0});
    build(boxes, 0, static_cast<Index>(boxes.size()));
  }

  void refit(const std::vector<Box>& boxes) {
    for (Index i = static_cast<Index>(nodes_.size()) - 1; i >= 0; --i) {
      Node& node = nodes_[i];
      if (node.right > 0) {
        const Box &a = nodes_[i + 1].box, &b = nodes_[node.right].box;
        node.box = {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
      } else {
        node.box = boxes[order_[node.first]];
        for (Index k = node.first + 1; k < node.last; ++k) {
          node.box.lower = node.box.lower.cwiseMin(boxes[order_[k]].lower);
          node.box.upper = node.box.upper.cwiseMax(boxes[order_[k]].upper);
        }
      }
    }
  }

  void find(const std::vector<Box>& queries, const std::vector<Box>& boxes,
            cbr::CandidateList& list) const {
    list.first.assign(1, 0);
    list.target.clear();
    std::vector<Index> stack;
    for (const Box& query : queries) {
      stack.assign(1, 0);
      while (!stack.empty()) {
        const Index i = stack.back();
        const Node& node = nodes_[i];
        stack.pop_back();
        if (!query.meets(node.box)) continue;
        if (node.right > 0) {
          stack.push_back(node.right);
          stack.push_back(i + 1);
        } else {
          for (Index k = node.first; k < node.last; ++k)
            if (query.meets(boxes[order_[k]])) list.target.push_back(order_[k]);
        }
      }
      std::sort(list.target.begin() + list.first.back(), list.target.end());
      list.first.push_back(static_cast<Index>(list.target.size()));
    }
  }

 private:
  struct Node {
    Box box{Vector3::Zero(), Vector3::Zero()};
    Index first = 0, last = 0, right = 0;  // right child, 0: a leaf
  };

  void build(const std::vector<Box>& boxes, Index first, Index last) {
    const std::size_t at = nodes_.size();
    nodes_.emplace_back();
    nodes_[at].first = first;
    nodes_[at].last = last;
    if (last - first <= 4) return;
    Vector3 lower = Vector3::Constant(HUGE_VAL), upper = -lower;
    const auto centre = [&](Index b) { return Vector3(0.5 * (boxes[b].lower + boxes[b].upper)); };
    for (Index k = first; k < last; ++k) {
      lower = lower.cwiseMin(centre(order_[k]));
      upper = upper.cwiseMax(centre(order_[k]));
    }
    Index axis = 0;
    (upper - lower).maxCoeff(&axis);
    const Index middle = (first + last) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](Index a, Index b) { return centre(a)[axis] < centre(b)[axis]; });
    build(boxes, first, middle);
    nodes_[at].right = static_cast<Index>(nodes_.size());
    build(boxes, middle, last);
  }

  std::vector<Index> order_;
  std::vector<Node> nodes_;
};

double seconds(int repeats, const auto& work) {
  double best = HUGE_VAL;
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

struct Sides {
  std::vector<Box> nodes, faces;
};

Sides sheets(Index n, double shift) {
  Sides s;
  const double size = 1 / double(n);
  for (Index i = 0; i <= n; ++i)
    for (Index j = 0; j <= n; ++j) {
      const Vector3 x(double(i) * size + shift, double(j) * size + 0.3 * shift, 0);
      s.nodes.push_back({x, x + Vector3(0, 0, 0.01 * size)});
      const Vector3 margin = Vector3::Constant(0.12 * size),
                    y(double(i) * size, double(j) * size, 0);
      if (i < n && j < n) s.faces.push_back({y - margin, y + Vector3(size, size, 0) + margin});
    }
  return s;
}

// Faces of two cubes blown up to spheres, which touch in a point.
Sides spheres(Index n, double shift) {
  Sides s;
  const auto point = [&](int side, double u, double v) {
    Vector3 x(1, u, v);
    x = Vector3(x[(3 - side % 3) % 3], x[(4 - side % 3) % 3], x[(5 - side % 3) % 3]);
    return Vector3((side < 3 ? 1 : -1) * x.normalized());
  };
  const auto at = [&](Index i) { return 2 * double(i) / double(n) - 1; };
  for (int side = 0; side < 6; ++side)
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) {
        const Vector3 x = point(side, at(i), at(j)) + Vector3(2 - 0.01 - 0.1 * shift, 0, 0);
        s.nodes.push_back({x, x + Vector3::Constant(0.01 / double(n))});
        Box box{Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
        for (int c = 0; c < 4; ++c) {
          const Vector3 y = point(side, at(i + c % 2), at(j + c / 2));
          box.lower = box.lower.cwiseMin(y);
          box.upper = box.upper.cwiseMax(y);
        }
        s.faces.push_back(
            {box.lower.array() - 0.2 / double(n), box.upper.array() + 0.2 / double(n)});
      }
  return s;
}

void row(const char* scene, Index n, Sides (*make)(Index, double)) {
  const Sides start = make(n, 0), now = make(n, 0.3 / double(n));
  const Index faces = static_cast<Index>(now.faces.size());
  BoxTree tree(start.faces);
  cbr::CandidateList found;
  cbr::BroadPhase grid;
  const int repeats = static_cast<int>(std::clamp<Index>(200000 / faces, 3, 200));
  const double t_grid = seconds(repeats, [&] { cbr::find_candidates(now.nodes, now.faces, grid); });
  const double t_refit = seconds(repeats, [&] { tree.refit(now.faces); });
  const double t_find = seconds(repeats, [&] { tree.find(now.nodes, now.faces, found); });
  std::printf("%s,%lld,%zu,%.3g,%.3g,%.3g,%s\n", scene, static_cast<long long>(faces),
              found.target.size(), t_grid, t_refit, t_refit + t_find,
              found.first == grid.candidates.first && found.target == grid.candidates.target
                  ? "yes"
                  : "NO");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const double largest = argc > 1 ? std::atof(argv[1]) : 100000;
  std::printf("scene,faces,candidates,grid,tree_refit,tree,same\n");
  for (double faces = 100; faces <= largest * 1.001; faces *= std::sqrt(10.0)) {
    row("sheets", std::lround(std::sqrt(faces)), sheets);
    row("spheres", std::lround(std::sqrt(faces / 6)), spheres);
  }
  return 0;
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/lattice_mesh.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "tests/support/scene_run.hpp"
#include "tests/unit/common/elements/box_mesh.hpp"

namespace cbr::test {
namespace {

using Point = std::array<Index, 3>;  // in half cells

// Corners of a cell in the order of a hex8, and its centre
constexpr std::array<Point, 9> cell_points = {{{0, 0, 0},
                                               {2, 0, 0},
                                               {2, 2, 0},
                                               {0, 2, 0},
                                               {0, 0, 2},
                                               {2, 0, 2},
                                               {2, 2, 2},
                                               {0, 2, 2},
                                               {1, 1, 1}}};

// Nodes of the elements of one cell, element by element.
std::vector<Point> cell_nodes(const Point& at, ElementType type) {
  std::vector<Point> nodes;
  for (const std::vector<int>& corners : cell_elements(type))
    for (const std::vector<int>& parents : node_corners(type)) {
      Point sum{};
      for (const int i : parents)
        for (std::size_t c = 0; c < 3; ++c) sum[c] += cell_points[corners[i]][c];
      for (std::size_t c = 0; c < 3; ++c)
        sum[c] = at[c] + sum[c] / static_cast<Index>(parents.size());
      nodes.push_back(sum);
    }
  return nodes;
}

// Nodes of the lattice that elements use, numbered in their order.
class Nodes {
 public:
  explicit Nodes(const LatticeShape& shape) : shape_(shape) {}

  Index of(const Point& p) {
    const auto [it, is_new] = index_.emplace(p, static_cast<Index>(points_.size()));
    if (is_new) points_.push_back(p);
    return it->second;
  }
  const Point& at(Index node) const { return points_[node]; }

  Points coordinates() const {
    Points X(static_cast<Index>(points_.size()), 3);
    for (Index i = 0; i < X.rows(); ++i) {
      Vector3 x;
      for (int c = 0; c < 3; ++c)
        x[c] = 0.5 * double(at(i)[c]) / double(shape_.n[c]) * shape_.size[c];
      X.row(i) = (shape_.map ? shape_.map(x) : x).transpose();
    }
    return X;
  }

 private:
  const LatticeShape& shape_;
  std::map<Point, Index> index_;
  std::vector<Point> points_;
};

void add_sidesets(const LatticeShape& shape, const Nodes& nodes, Mesh& mesh) {
  const char* names[] = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
  for (int f = 0; f < 6; ++f) {
    Sideset set{names[f], f + 1, {}};
    const Index level = f % 2 == 0 ? 0 : 2 * shape.n[f / 2];
    for (Index b = 0; b < static_cast<Index>(mesh.blocks.size()); ++b) {
      const Block& block = mesh.blocks[b];
      for (Index e = 0; e < block.connectivity.rows(); ++e)
        for (int s = 1; s <= n_sides(block.type); ++s) {
          const auto& local = side_nodes(block.type, s);
          if (std::all_of(local.begin(), local.end(), [&](int i) {
                return nodes.at(block.connectivity(e, i))[f / 2] == level;
              }))
            set.sides.push_back({b, e, s});
        }
    }
    mesh.sidesets.push_back(std::move(set));
  }
}

void add_nodesets(const LatticeShape& shape, Nodes& nodes, Mesh& mesh) {
  const Index x = 2 * shape.n[0], y = 2 * shape.n[1], z = 2 * shape.n[2];
  Nodeset three{"three", 2, {nodes.of({x, 0, 0}), nodes.of({x, y, 0}), nodes.of({x, 0, z})}};
  std::sort(three.nodes.begin(), three.nodes.end());
  mesh.nodesets = {{"end", 1, set_nodes(mesh, "x_max")}, three, {"one", 3, {nodes.of({0, 0, 0})}}};
}

// --- renumbering ---

// Old index of each new one
std::vector<Index> random_order(Index n, std::mt19937& random) {
  std::vector<Index> order = first_numbers(n);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> result(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) result[order[i]] = static_cast<Index>(i);
  return result;
}

using Permutation = std::vector<int>;

// Nodes of a side as a cycle that begins with its smallest corner, mid-side nodes after the
// corners.
std::vector<int> cycle(ElementType type, int side, const Permutation& p) {
  const auto& local = side_nodes(type, side);
  const auto n = static_cast<std::size_t>(n_corners(side_kind(type, side)));
  std::vector<int> corners, all;
  for (std::size_t i = 0; i < n; ++i) corners.push_back(p[local[i]]);
  const auto first =
      static_cast<std::size_t>(std::min_element(corners.begin(), corners.end()) - corners.begin());
  for (std::size_t i = 0; i < n; ++i) all.push_back(corners[(first + i) % n]);
  for (std::size_t i = 0; local.size() >= 2 * n && i < n; ++i)
    all.push_back(p[local[n + (first + i) % n]]);
  return all;
}

std::set<std::vector<int>> cycles(ElementType type, const Permutation& p) {
  std::set<std::vector<int>> found;
  for (int s = 1; s <= n_sides(type); ++s) found.insert(cycle(type, s, p));
  return found;
}

// All turns of an element onto itself: node i of the turned one is node p[i]. Found from its sides
// alone: corners by trial, what lies amid edges from the corners. A hex27 is left as it is: its
// sides do not tell of their centres.
std::vector<Permutation> turns_of(ElementType type) {
  Permutation identity(static_cast<std::size_t>(n_nodes(type)));
  std::iota(identity.begin(), identity.end(), 0);
  if (type == ElementType::hex27) return {identity};
  std::map<std::pair<int, int>, int> amid;  // corners of an edge -> node
  for (int s = 1; s <= n_sides(type); ++s) {
    const auto& local = side_nodes(type, s);
    const auto n = static_cast<std::size_t>(n_corners(side_kind(type, s)));
    for (std::size_t i = 0; local.size() > n && i < n; ++i)
      amid[std::minmax(local[i], local[(i + 1) % n])] = local[n + i];
  }
  const auto wanted = cycles(type, identity);
  std::vector<Permutation> turns;
  Permutation corners(identity.begin(), identity.begin() + n_corners(type));
  do {
    Permutation p = identity;
    std::copy(corners.begin(), corners.end(), p.begin());
    bool fits = true;
    for (const auto& [edge, node] : amid) {
      const auto image = amid.find(std::minmax(p[edge.first], p[edge.second]));
      fits = fits && image != amid.end();
      if (fits) p[node] = image->second;
    }
    if (fits && cycles(type, p) == wanted) turns.push_back(p);
  } while (std::next_permutation(corners.begin(), corners.end()));
  return turns;
}

const std::vector<Permutation>& turns(ElementType type) {
  static std::map<ElementType, std::vector<Permutation>> known;
  auto& list = known[type];
  if (list.empty()) list = turns_of(type);
  return list;
}

// Side `side` of the old element is which side of the turned one?
int turned_side(ElementType type, int side, const Permutation& p) {
  Permutation identity(p.size());
  std::iota(identity.begin(), identity.end(), 0);
  const auto old = cycle(type, side, identity);
  for (int s = 1; s <= n_sides(type); ++s)
    if (cycle(type, s, p) == old) return s;
  return 0;
}

}  // namespace

Mesh lattice_mesh(const LatticeShape& shape) {
  const auto& n = shape.n;
  Nodes nodes(shape);
  // (high, type) -> nodes of its elements
  std::map<std::pair<bool, ElementType>, std::vector<Index>> lists;
  for (Index i = 0; i < n[0]; ++i)
    for (Index j = 0; j < n[1]; ++j)
      for (Index k = 0; k < n[2]; ++k) {
        // Whole columns, as triangles of wedges lie on those of wedges
        const ElementType type = (i + j) % 2 == 0 ? shape.kind.even : shape.kind.odd;
        std::vector<Index>& list = lists[{2 * i >= n[0], type}];
        for (const Point& p : cell_nodes({2 * i, 2 * j, 2 * k}, type)) list.push_back(nodes.of(p));
      }
  Mesh mesh;
  Index next_id = 1;
  for (const auto& [key, list] : lists) {
    const auto [high, type] = key;
    Block block;
    block.name = std::string(high ? "high" : "low") + "_" + std::string(name(type));
    block.id = static_cast<Index>(mesh.blocks.size()) + 1;
    block.type = type;
    block.connectivity = Eigen::Map<const IndexTable>(
        list.data(), static_cast<Index>(list.size()) / n_nodes(type), n_nodes(type));
    for (Index e = 0; e < block.connectivity.rows(); ++e) block.element_ids.push_back(next_id++);
    mesh.blocks.push_back(std::move(block));
  }
  mesh.coordinates = nodes.coordinates();
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) mesh.node_ids.push_back(i + 1);
  add_sidesets(shape, nodes, mesh);
  add_nodesets(shape, nodes, mesh);
  return mesh;
}

Mesh renumbered_any(const Mesh& mesh, unsigned seed) {
  std::mt19937 random(seed);
  Mesh result = mesh;
  const std::vector<Index> nodes = random_order(mesh.coordinates.rows(), random),
                           new_node = inverse(nodes);
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
    result.coordinates.row(i) = mesh.coordinates.row(nodes[i]);
    result.node_ids[i] = 3 * i + 7;
  }
  for (Nodeset& set : result.nodesets) {
    for (Index& node : set.nodes) node = new_node[node];
    std::sort(set.nodes.begin(), set.nodes.end());
  }
  Index next_id = 11;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    Block& block = result.blocks[b];
    const Block& old = mesh.blocks[b];
    const std::vector<Index> elements = random_order(old.connectivity.rows(), random),
                             new_element = inverse(elements);
    std::vector<const Permutation*> turn;
    for (Index e = 0; e < old.connectivity.rows(); ++e) {
      turn.push_back(&turns(block.type)[random() % turns(block.type).size()]);
      for (Index a = 0; a < old.connectivity.cols(); ++a)
        block.connectivity(e, a) = new_node[old.connectivity(elements[e], (*turn.back())[a])];
      block.element_ids[e] = next_id += 2;
    }
    for (Sideset& set : result.sidesets)
      for (Side& side : set.sides) {
        if (side.block != static_cast<Index>(b)) continue;
        side.element = new_element[side.element];
        side.side = turned_side(block.type, side.side, *turn[side.element]);
      }
  }
  for (Sideset& set : result.sidesets) std::shuffle(set.sides.begin(), set.sides.end(), random);
  return result;
}

}  // namespace cbr::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/domains/decomposition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "common/base/error.hpp"
#include "reducer/partition/graph_partition.hpp"
#include "tests/unit/reducer/cut_meshes.hpp"

namespace cbr::test::decomposition_test {
namespace {

std::vector<std::set<Index>> corners_of(const Mesh& mesh) {
  std::vector<std::set<Index>> corners;
  for (const Block& block : mesh.blocks) {
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      auto& of = corners.emplace_back();
      for (Index a = 0; a < n_corners(block.type); ++a) of.insert(block.connectivity(e, a));
    }
  }
  return corners;
}

// Pieces joined by faces, by comparing all pairs: a face of these meshes is where three or more
// corners are the same, none of their edges has more than two.
Index n_pieces(const std::vector<std::set<Index>>& corners, const std::vector<Index>& members) {
  std::vector<bool> seen(members.size(), false);
  Index pieces = 0;
  for (std::size_t start = 0; start < members.size(); ++start) {
    if (seen[start]) continue;
    ++pieces;
    std::vector<std::size_t> stack = {start};
    seen[start] = true;
    while (!stack.empty()) {
      const std::size_t v = stack.back();
      stack.pop_back();
      for (std::size_t w = 0; w < members.size(); ++w) {
        if (seen[w]) continue;
        const auto &a = corners[members[v]], &b = corners[members[w]];
        if (std::count_if(a.begin(), a.end(), [&](Index node) { return b.contains(node); }) < 3)
          continue;
        seen[w] = true;
        stack.push_back(w);
      }
    }
  }
  return pieces;
}

std::vector<std::vector<Index>> members(const Decomposition& decomposition) {
  std::vector<std::vector<Index>> of(static_cast<std::size_t>(decomposition.n_domains));
  for (std::size_t e = 0; e < decomposition.domain.size(); ++e)
    of.at(static_cast<std::size_t>(decomposition.domain[e])).push_back(static_cast<Index>(e));
  return of;
}

struct Case {
  const char* name;
  Mesh mesh;
};

std::vector<Case> cases() {
  return {{"box", box_mesh({{6, 5, 4}, {6, 5, 4}, {0, 0, 0}, 0.08})},
          {"row", box_mesh({{30, 1, 1}, {30, 1, 1}, {0, 0, 0}, 0})},
          {"comb", comb_mesh(6, 7)},
          {"joined at an edge", blocks_joined_at_an_edge(3)},
          {"tet10", tet10_mesh({3, 2, 2}, 0.02)},
          {"mixed", mixed_mesh({4, 3, 3}, 0.05)},
          {"two parts", both(box_mesh({{3, 3, 3}, {3, 3, 3}, {0, 0, 0}, 0}),
                             box_mesh({{2, 2, 2}, {2, 2, 2}, {9, 0, 0}, 0}))}};
}

TEST(Decompose, EveryDomainIsOnePieceAndNoneIsEmpty) {
  for (const auto& [name, mesh] : cases()) {
    const auto corners = corners_of(mesh);
    for (const Index n : {2, 3, 4, 5, 7, 8, 13, 16, 27}) {
      const Decomposition decomposition = decompose(mesh, n);
      ASSERT_EQ(decomposition.domain.size(), corners.size());
      for (const auto& domain : members(decomposition)) {
        ASSERT_FALSE(domain.empty()) << name << " " << n;
        EXPECT_EQ(n_pieces(corners, domain), 1) << name << " " << n;
      }
    }
  }
}

TEST(Decompose, DomainsAreAboutEqual) {
  const Mesh mesh = box_mesh({{12, 12, 12}, {1, 1, 1}, {0, 0, 0}, 0});
  for (const Index n : {2, 3, 5, 8, 27}) {
    for (const auto& domain : members(decompose(mesh, n))) {
      EXPECT_LT(static_cast<double>(domain.size()), 1.35 * 1728 / static_cast<double>(n)) << n;
      EXPECT_GT(static_cast<double>(domain.size()), 0.65 * 1728 / static_cast<double>(n)) << n;
    }
  }
  // Two halves of a cube share a layer of nodes at best, eight parts three layers that cross.
  EXPECT_LT(shared_nodes(mesh, decompose(mesh, 2)).size(), 1.3 * 169);
  EXPECT_LT(shared_nodes(mesh, decompose(mesh, 8)).size(), 1.6 * (3 * 169 - 3 * 13 + 1));
}

TEST(Decompose, AsManyDomainsAsElements) {
  const Mesh mesh = box_mesh({{3, 2, 2}, {3, 2, 2}, {0, 0, 0}, 0});
  const Decomposition decomposition = decompose(mesh, 12);
  EXPECT_EQ(std::set<Index>(decomposition.domain.begin(), decomposition.domain.end()).size(), 12u);
  for (const Index n : {-1, 0, 13}) EXPECT_THROW(decompose(mesh, n), InputError) << n;
  EXPECT_EQ(decompose(mesh, 1).domain, std::vector<Index>(12, 0));
}

TEST(Decompose, TheSameMeshIsCutTheSameWay) {
  for (const auto& [name, mesh] : cases()) {
    const Decomposition first = decompose(mesh, 5);
    std::srand(17);  // METIS draws from these
    EXPECT_EQ(first.domain, decompose(mesh, 5).domain) << name;
  }
}

TEST(Decompose, MorePartsThanDomainsStayWhole) {
  Mesh mesh = both(box_mesh({{3, 1, 1}, {3, 1, 1}, {20, 0, 0}, 0}),
                   box_mesh({{2, 2, 2}, {2, 2, 2}, {0, 0, 0}, 0}));
  Block third = mesh.blocks[1];
  const Mesh single = box_mesh({{1, 1, 1}, {1, 1, 1}, {40, 0, 0}, 0});
  third.connectivity = single.blocks[0].connectivity.array() + mesh.coordinates.rows();
  third.element_ids = {1000};
  third.name = "third";
  mesh.coordinates.conservativeResize(mesh.coordinates.rows() + 8, 3);
  mesh.coordinates.bottomRows(8) = single.coordinates;
  for (const Index id : single.node_ids) mesh.node_ids.push_back(900000 + id);
  mesh.blocks.push_back(third);
  EXPECT_EQ(decompose(mesh, 2).domain, (std::vector<Index>{0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 0}));
}

TEST(FaceGraph, IsThatOfAllPairs) {
  for (const auto& [name, mesh] : cases()) {
    const Graph graph = face_graph(mesh);
    const auto corners = corners_of(mesh);
    ASSERT_EQ(graph.n_vertices(), std::ssize(corners));
    for (Index v = 0; v < graph.n_vertices(); ++v) {
      std::vector<Index> neighbours;
      const auto& a = corners[v];
      for (Index w = 0; w < graph.n_vertices(); ++w) {
        const auto& b = corners[w];
        if (v != w &&
            std::count_if(a.begin(), a.end(), [&](Index node) { return b.contains(node); }) >= 3)
          neighbours.push_back(w);
      }
      const auto first = graph.neighbours.begin();
      EXPECT_EQ(std::vector<Index>(first + graph.first[v],
                                   first + graph.first[static_cast<std::size_t>(v) + 1]),
                neighbours)
          << name << " " << v;
    }
  }
}

TEST(Split, GivesEveryElementSideAndNodeOnce) {
  const Mesh mesh = mixed_mesh({4, 3, 3}, 0.05);
  const Decomposition decomposition = decompose(mesh, 4);
  const std::vector<Index> interface = set_nodes(mesh, "x_min"),
                           shared = shared_nodes(mesh, decomposition);
  const std::vector<Domain> domains = split(mesh, decomposition, interface, {"x_min"});
  std::set<Index> elements, nodes, kept(interface.begin(), interface.end());
  kept.insert(shared.begin(), shared.end());
  std::size_t n_sides = 0, n_elements = 0;
  for (const Domain& domain : domains) {
    check_mesh(domain.mesh, "domain");
    ASSERT_TRUE(std::is_sorted(domain.node.begin(), domain.node.end()));
    nodes.insert(domain.node.begin(), domain.node.end());
    for (std::size_t i = 0; i < domain.node.size(); ++i) {
      EXPECT_EQ(domain.mesh.node_ids[i], mesh.node_ids[domain.node[i]]);
      EXPECT_EQ(std::binary_search(domain.interface.begin(), domain.interface.end(),
                                   static_cast<Index>(i)),
                kept.contains(domain.node[i]));
    }
    for (std::size_t b = 0; b < domain.mesh.blocks.size(); ++b) {
      const Block &part = domain.mesh.blocks[b], &whole = mesh.blocks[domain.block[b]];
      for (Index e = 0; e < part.connectivity.rows(); ++e) {
        const Index id = part.element_ids[e];
        const auto row = std::find(whole.element_ids.begin(), whole.element_ids.end(), id) -
                         whole.element_ids.begin();
        for (Index a = 0; a < part.connectivity.cols(); ++a)
          EXPECT_EQ(domain.node[part.connectivity(e, a)], whole.connectivity(row, a));
        elements.insert(id);
        ++n_elements;
      }
    }
    for (const Sideset& set : domain.mesh.sidesets) n_sides += set.sides.size();
  }
  EXPECT_EQ(elements.size(), decomposition.domain.size());
  EXPECT_EQ(n_elements, decomposition.domain.size());
  EXPECT_EQ(n_sides, mesh.sidesets[0].sides.size());
  EXPECT_EQ(std::ssize(nodes), mesh.coordinates.rows());
}

}  // namespace
}  // namespace cbr::test::decomposition_test

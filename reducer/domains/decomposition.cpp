// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/domains/decomposition.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "common/base/error.hpp"
#include "reducer/partition/graph_partition.hpp"

namespace cbr {
namespace {

// METIS from several seeds and in both ways; on larger graphs once each way.
constexpr Index many_elements = 200000;
constexpr std::array<int, 3> seeds = {1, 2, 3};

// Pieces of each part that are connected by faces. `piece`: per vertex; numbered by their first
// vertex.
struct Pieces {
  std::vector<Index> piece, part, weight;  // per vertex; per piece
};

Pieces pieces_of(const Graph& graph, const std::vector<Index>& part) {
  Pieces found;
  found.piece.assign(part.size(), -1);
  std::vector<Index> stack;
  for (std::size_t start = 0; start < part.size(); ++start) {
    if (found.piece[start] >= 0) continue;
    const auto number = static_cast<Index>(found.part.size());
    found.part.push_back(part[start]);
    found.weight.push_back(0);
    stack.push_back(static_cast<Index>(start));
    found.piece[start] = number;
    while (!stack.empty()) {
      const auto v = static_cast<std::size_t>(stack.back());
      stack.pop_back();
      found.weight.back() += graph.weight[v];
      for (Index i = graph.first[v]; i < graph.first[v + 1]; ++i) {
        const auto w = static_cast<std::size_t>(graph.neighbours[i]);
        if (found.piece[w] >= 0 || part[w] != part[v]) continue;
        found.piece[w] = number;
        stack.push_back(static_cast<Index>(w));
      }
    }
  }
  return found;
}

// The part that has most faces in common with a piece, of equal ones the first.
Index best_neighbour(const Graph& graph, const std::vector<Index>& part, const Pieces& pieces,
                     Index piece) {
  std::map<Index, Index> faces;
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (pieces.piece[v] != piece) continue;
    for (Index i = graph.first[v]; i < graph.first[v + 1]; ++i) {
      const Index other = part[graph.neighbours[i]];
      if (other != part[v]) ++faces[other];
    }
  }
  Index best = -1, most = 0;
  for (const auto& [other, count] : faces) {
    if (count > most) {
      best = other;
      most = count;
    }
  }
  return best;
}

// Each part keeps its heaviest piece. The lightest of the others joins a neighbour, which removes
// one piece from the total, until every part is one.
void move_strays(const Graph& graph, std::vector<Index>& part, Index n) {
  while (true) {
    const Pieces pieces = pieces_of(graph, part);
    std::vector<Index> keeps(n, -1);
    const auto weight = [&](Index piece) { return pieces.weight[piece]; };
    for (Index p = 0; p < static_cast<Index>(pieces.part.size()); ++p) {
      Index& kept = keeps[pieces.part[p]];
      if (kept < 0 || weight(p) > weight(kept)) kept = p;
    }
    Index stray = -1;
    for (Index p = 0; p < static_cast<Index>(pieces.part.size()); ++p) {
      if (keeps[pieces.part[p]] == p) continue;
      if (stray < 0 || weight(p) < weight(stray)) stray = p;
    }
    if (stray < 0) return;
    const Index target = best_neighbour(graph, part, pieces, stray);
    for (std::size_t v = 0; v < part.size(); ++v) {
      if (pieces.piece[v] == stray) part[v] = target;
    }
  }
}

// Vertices of a part in the order of a breadth-first walk from its first one's far end.
std::vector<Index> walk(const Graph& graph, const std::vector<Index>& part, Index number,
                        Index start) {
  std::vector<bool> seen(part.size(), false);
  std::vector<Index> order = {start};
  seen[start] = true;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto v = static_cast<std::size_t>(order[i]);
    for (Index j = graph.first[v]; j < graph.first[v + 1]; ++j) {
      const Index w = graph.neighbours[j];
      if (seen[w] || part[w] != number) continue;
      seen[w] = true;
      order.push_back(w);
    }
  }
  return order;
}

// Halves the largest part (one piece) for an empty one: the first half of a walk is connected, and
// the remaining pieces touch it.
void fill_empty(const Graph& graph, std::vector<Index>& part, Index n) {
  for (Index empty = 0; empty < n; ++empty) {
    std::vector<Index> count(n, 0);
    for (const Index p : part) ++count[p];
    if (count[empty] > 0) continue;
    const Index largest = std::max_element(count.begin(), count.end()) - count.begin();
    const Index first = std::find(part.begin(), part.end(), largest) - part.begin();
    const std::vector<Index> order =
        walk(graph, part, largest, walk(graph, part, largest, first).back());
    for (std::size_t i = order.size() / 2; i < order.size(); ++i) part[order[i]] = empty;
    move_strays(graph, part, n);
  }
}

// A connected graph in n parts, 1 <= n <= vertices.
std::vector<Index> connected_partition(const Graph& graph, Index n, GraphCut cut, int seed) {
  std::vector<Index> part = partition_graph(graph, n, cut, seed);
  move_strays(graph, part, n);
  fill_empty(graph, part, n);
  return part;
}

// How much a cut costs: nodes that are in several parts, once for each part beyond the first, times
// how uneven it is.
double cost(const ElementNodes& elements, const std::vector<Index>& members,
            const std::vector<Index>& part, Index n) {
  std::map<Index, std::vector<Index>> parts_of;
  std::vector<double> weight(n, 0);
  for (std::size_t i = 0; i < members.size(); ++i) {
    for (const Index node : elements.of(members[i])) {
      auto& parts = parts_of[node];
      if (std::find(parts.begin(), parts.end(), part[i]) == parts.end()) parts.push_back(part[i]);
      weight[part[i]] += 1;
    }
  }
  double shared = 0, sum = 0;
  for (const auto& [node, parts] : parts_of) shared += static_cast<double>(parts.size() - 1);
  for (const double w : weight) sum += w;
  return shared * *std::max_element(weight.begin(), weight.end()) * static_cast<double>(n) / sum;
}

std::vector<Index> best_partition(const ElementNodes& elements, const std::vector<Index>& members,
                                  const Graph& graph, Index n) {
  if (n == 1) return std::vector<Index>(members.size(), 0);
  std::vector<Index> best;
  double least = std::numeric_limits<double>::infinity();
  for (const int seed : seeds) {
    for (const GraphCut cut : {GraphCut::bisections, GraphCut::k_way}) {
      std::vector<Index> part = connected_partition(graph, n, cut, seed);
      const double price = cost(elements, members, part, n);
      if (price < least) {
        least = price;
        best = std::move(part);
      }
    }
    if (graph.n_vertices() > many_elements) break;
  }
  return best;
}

// The connected part `number` of the graph, with its vertices' numbers in the whole.
Graph subgraph(const Graph& graph, const std::vector<Index>& members) {
  std::map<Index, Index> local;
  for (std::size_t i = 0; i < members.size(); ++i) local[members[i]] = static_cast<Index>(i);
  Graph sub;
  for (const Index v : members) {
    for (Index i = graph.first[v]; i < graph.first[v + 1]; ++i) {
      sub.neighbours.push_back(local.at(graph.neighbours[i]));
    }
    sub.first.push_back(static_cast<Index>(sub.neighbours.size()));
    sub.weight.push_back(graph.weight[v]);
  }
  return sub;
}

struct ConnectedPart {
  std::vector<Index> members;  // vertices
  Index weight = 0, n_domains = 1;
};

std::vector<ConnectedPart> components_of(const Graph& graph) {
  const Pieces pieces = pieces_of(graph, std::vector<Index>(graph.weight.size(), 0));
  std::vector<ConnectedPart> components(pieces.part.size());
  for (std::size_t v = 0; v < pieces.piece.size(); ++v) {
    ConnectedPart& component = components[pieces.piece[v]];
    component.members.push_back(static_cast<Index>(v));
    component.weight += graph.weight[v];
  }
  return components;
}

// One domain after the other to the component that has the most weight for each of its domains.
void share_out(std::vector<ConnectedPart>& components, Index n) {
  for (Index given = static_cast<Index>(components.size()); given < n; ++given) {
    ConnectedPart* neediest = nullptr;
    for (ConnectedPart& c : components) {
      if (c.n_domains >= static_cast<Index>(c.members.size())) continue;
      if (neediest == nullptr || c.weight * neediest->n_domains > neediest->weight * c.n_domains)
        neediest = &c;
    }
    ++neediest->n_domains;
  }
}

// More components than domains: the heaviest first, each to the lightest domain.
void pack(const std::vector<ConnectedPart>& components, Index n, std::vector<Index>& domain) {
  std::vector<std::size_t> order(components.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return components[a].weight > components[b].weight;
  });
  std::vector<Index> weight(n, 0);
  for (const std::size_t c : order) {
    const auto lightest = std::min_element(weight.begin(), weight.end());
    *lightest += components[c].weight;
    for (const Index v : components[c].members) domain[v] = lightest - weight.begin();
  }
}

// Domains by their first element.
void renumber(std::vector<Index>& domain, Index n) {
  std::vector<Index> number(n, -1);
  Index next = 0;
  for (Index& d : domain) {
    Index& mapped = number[d];
    if (mapped < 0) mapped = next++;
    d = mapped;
  }
}

}  // namespace

Decomposition decompose(const Mesh& mesh, Index n) {
  const ElementNodes elements = element_nodes(mesh);
  if (n < 1) throw InputError("domains: " + std::to_string(n) + " found, 1 or more allowed");
  if (n > elements.size()) {
    throw InputError("domains: " + std::to_string(n) + " found, but the mesh has only " +
                     std::to_string(elements.size()) +
                     " volume elements: ask for at most that many");
  }
  Decomposition decomposition{n, std::vector<Index>(elements.size(), 0)};
  if (n == 1) return decomposition;
  const Graph graph = face_graph(mesh);
  std::vector<ConnectedPart> components = components_of(graph);
  if (n < static_cast<Index>(components.size())) {
    pack(components, n, decomposition.domain);
  } else {
    share_out(components, n);
    Index first = 0;
    for (const ConnectedPart& component : components) {
      const std::vector<Index> part = best_partition(
          elements, component.members, subgraph(graph, component.members), component.n_domains);
      for (std::size_t i = 0; i < part.size(); ++i)
        decomposition.domain[component.members[i]] = first + part[i];
      first += component.n_domains;
    }
  }
  renumber(decomposition.domain, n);
  return decomposition;
}

}  // namespace cbr

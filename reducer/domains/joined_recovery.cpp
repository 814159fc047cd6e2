// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/domains/joined_recovery.hpp"

#include "common/base/error.hpp"

namespace cbr {
namespace {

// A domain's coordinates [q_k; u_c] from the whole's [q_k; u_c]   (n_d x (k + c))
Matrix coordinates_of_domain(const std::vector<Index>& places, const Matrix& Psi,
                             const Matrix& Phi) {
  const Index k = Phi.cols(), c = Psi.cols();
  Matrix T(static_cast<Index>(places.size()), k + c);
  for (Index i = 0; i < T.rows(); ++i) {
    const Index place = places[static_cast<std::size_t>(i)];
    if (place >= 0) {
      T.row(i) << Phi.row(place), Psi.row(place);
    } else {
      T.row(i) = Vector::Unit(k + c, k + JoinedPlaces::of_interface(place)).transpose();
    }
  }
  return T;
}

Block& block_like(const Block& part, std::vector<Block>& blocks) {
  for (Block& block : blocks) {
    if (block.name == part.name && block.id == part.id && block.type == part.type) return block;
  }
  blocks.push_back({part.name, part.id, part.type, IndexTable(0, part.connectivity.cols()), {}});
  return blocks.back();
}

// Adds a domain's elements; `place`: of its nodes [interface; interior] among the whole's.
void add_blocks(const std::vector<Block>& parts, const std::vector<Index>& place,
                std::vector<Block>& blocks) {
  for (const Block& part : parts) {
    Block& block = block_like(part, blocks);
    const Index first = block.connectivity.rows();
    block.connectivity.conservativeResize(first + part.connectivity.rows(), Eigen::NoChange);
    for (Index e = 0; e < part.connectivity.rows(); ++e) {
      for (Index a = 0; a < part.connectivity.cols(); ++a)
        block.connectivity(first + e, a) = place[static_cast<std::size_t>(part.connectivity(e, a))];
    }
    block.element_ids.insert(block.element_ids.end(), part.element_ids.begin(),
                             part.element_ids.end());
  }
}

}  // namespace

Superelement::Recovery joined_recovery(const SuperelementGroup& group, const JoinedNodes& joined,
                                       const JoinedPlaces& places, const Matrix& Psi,
                                       const Matrix& Phi) {
  const auto n_kept = static_cast<Index>(places.interface_nodes.size()),
             n_shared = static_cast<Index>(places.shared_nodes.size());
  Index n = n_shared;
  for (const auto& s : group.domains) {
    if (s.recovery.empty())
      throw InputError(
          "second_reduction: a domain has no recovery data: reduce the domains with recovery: "
          "true");
    n += static_cast<Index>(s.recovery.front().node_ids.size());
  }
  Superelement::Recovery whole;
  whole.coordinates.resize(n, 3);
  whole.Psi.resize(3 * n, Psi.cols());
  whole.Phi.resize(3 * n, Phi.cols());
  std::vector<Index> place(joined.node_ids.size());  // among [kept; shared; interiors]
  for (Index i = 0; i < n_kept; ++i)
    place[static_cast<std::size_t>(places.interface_nodes[static_cast<std::size_t>(i)])] = i;
  for (Index i = 0; i < n_shared; ++i) {
    const auto node = static_cast<std::size_t>(places.shared_nodes[static_cast<std::size_t>(i)]);
    place[node] = n_kept + i;
    whole.node_ids.push_back(joined.node_ids[node]);
    whole.coordinates.row(i) = joined.coordinates.row(static_cast<Index>(node));
  }
  whole.Psi.topRows(3 * n_shared) = Psi.bottomRows(3 * n_shared);
  whole.Phi.topRows(3 * n_shared) = Phi.bottomRows(3 * n_shared);
  Index first = n_shared;
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    const auto& own = s.recovery.front();
    const auto n_I = static_cast<Index>(own.node_ids.size());
    const Matrix T = coordinates_of_domain(places.of_domain[d], Psi, Phi);
    // u_I = Phi_d q_d + Psi_d u_d   (3 n_I x (k + c))
    const Matrix u = own.Phi * T.topRows(s.k()) + own.Psi * T.bottomRows(s.c());
    whole.Phi.middleRows(3 * first, 3 * n_I) = u.leftCols(Phi.cols());
    whole.Psi.middleRows(3 * first, 3 * n_I) = u.rightCols(Psi.cols());
    whole.coordinates.middleRows(first, n_I) = own.coordinates;
    whole.node_ids.insert(whole.node_ids.end(), own.node_ids.begin(), own.node_ids.end());
    std::vector<Index> local;
    for (const Index node : joined.place[d]) local.push_back(place[static_cast<std::size_t>(node)]);
    for (Index i = 0; i < n_I; ++i) local.push_back(n_kept + first + i);
    add_blocks(own.blocks, local, whole.blocks);
    first += n_I;
  }
  return whole;
}

}  // namespace cbr

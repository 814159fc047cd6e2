// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/modes/component_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "common/base/format_text.hpp"

namespace cbr {
namespace {

constexpr Index beside = 4;  // modes of a part beyond its share, at first

// The number of a row in its own part's block.
struct Local {
  std::vector<Index> row;
  std::vector<std::vector<Index>> rows;  // of each part

  Local(const std::vector<Index>& part, std::size_t n_parts) : row(3 * part.size()), rows(n_parts) {
    for (std::size_t node = 0; node < part.size(); ++node)
      for (Index d = 0; d < 3; ++d) {
        auto& of_part = rows[part[node]];
        row[3 * node + d] = static_cast<Index>(of_part.size());
        of_part.push_back(3 * static_cast<Index>(node) + d);
      }
  }
};

// Columns of A, whose rows are all of one part.
SparseMatrix block(const SparseMatrix& A, const std::vector<Index>& local, Index n_rows,
                   const std::vector<Index>& columns) {
  SparseMatrix B(n_rows, static_cast<Index>(columns.size()));
  Index entries = 0;
  for (const Index j : columns) entries += A.col(j).nonZeros();
  B.reserve(entries);
  for (std::size_t j = 0; j < columns.size(); ++j) {
    B.startVec(static_cast<Index>(j));
    for (SparseMatrix::InnerIterator it(A, columns[j]); it; ++it)
      B.insertBack(local[it.row()], static_cast<Index>(j)) = it.value();
  }
  B.finalize();
  return B;
}

Index last_row(const SparseMatrix& A, Index first, Index count) {
  Index last = -1;
  for (Index j = first; j < first + count; ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it) last = std::max(last, it.row());
  return last;
}

// Six rows of G, in the part's columns.
SparseMatrix content_of(const SparseMatrix& G, Index first, const std::vector<Index>& columns) {
  SparseMatrix own(6, static_cast<Index>(columns.size()));
  if (G.rows() == 0) return own;
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (SparseMatrix::InnerIterator it(G, columns[j]); it; ++it)
      if (it.row() >= first && it.row() < first + 6)
        own.insert(it.row() - first, static_cast<Index>(j)) = it.value();
  own.makeCompressed();
  return own;
}

// Each six of the motions to the part whose interface they move.
void share_out(const RigidMotions& rigid, const Local& I, const Local& C,
               const std::vector<Index>& part_C, std::vector<ComponentPart>& parts) {
  for (Index first = 0; first < rigid.count(); first += 6) {
    const Index row = last_row(rigid.R_C, first, 6);
    if (row < 0) continue;
    std::vector<Index> six(6);
    std::iota(six.begin(), six.end(), first);
    ComponentPart& part = parts[part_C[row / 3]];
    const auto n_I = static_cast<Index>(part.inside.size()),
               c = static_cast<Index>(part.on_interface.size());
    part.p.rigid = {block(rigid.R_I, I.row, n_I, six), block(rigid.R_C, C.row, c, six),
                    block(rigid.P_I, I.row, n_I, six), block(rigid.P_C, C.row, c, six),
                    content_of(rigid.G, first, part.on_interface)};
  }
}

void keep_lowest(FixedInterfaceModes& modes, Index k) {
  if (modes.lambda.size() <= k) return;
  modes.next = modes.lambda(k);
  modes.lambda.conservativeResize(k);
  modes.Phi.conservativeResize(Eigen::NoChange, k);
}

}  // namespace

std::vector<ComponentPart> split(const Partition& p, const std::vector<Index>& part_I,
                                 const std::vector<Index>& part_C) {
  Index n = 0;
  for (const auto* numbers : {&part_I, &part_C})
    for (const Index number : *numbers) n = std::max(n, number + 1);
  Local I(part_I, n), C(part_C, n);
  std::vector<ComponentPart> parts(n);
  for (Index q = 0; q < n; ++q) {
    ComponentPart& part = parts[q];
    part.inside = std::move(I.rows[q]);
    part.on_interface = std::move(C.rows[q]);
    for (std::size_t i = 0; i < part.on_interface.size(); i += 3)
      part.interface_nodes.push_back(part.on_interface[i] / 3);
    const auto n_I = static_cast<Index>(part.inside.size()),
               c = static_cast<Index>(part.on_interface.size());
    part.p.K_II = block(p.K_II, I.row, n_I, part.inside);
    part.p.M_II = block(p.M_II, I.row, n_I, part.inside);
    part.p.K_IC = block(p.K_IC, I.row, n_I, part.on_interface);
    part.p.M_IC = block(p.M_IC, I.row, n_I, part.on_interface);
    part.p.K_CC = block(p.K_CC, C.row, c, part.on_interface);
    part.p.M_CC = block(p.M_CC, C.row, c, part.on_interface);
    part.p.lumped = p.lumped;
    part.p.rigid.R_I.resize(n_I, 0);
    part.p.rigid.P_I.resize(n_I, 0);
    part.p.rigid.R_C.resize(c, 0);
    part.p.rigid.P_C.resize(c, 0);
  }
  share_out(p.rigid, I, C, part_C, parts);
  std::erase_if(parts, [](const ComponentPart& part) {
    return part.inside.empty() && part.on_interface.empty();
  });
  return parts;
}

Superelement part_of(const Superelement& s, const ComponentPart& part) {
  Superelement own;
  own.basis = s.basis;
  own.coordinates = s.coordinates(part.interface_nodes, Eigen::all);
  for (const Index node : part.interface_nodes) own.node_ids.push_back(s.node_ids[node]);
  for (std::size_t i = 0; i < part.on_interface.size(); ++i) {
    own.dof_node.push_back(static_cast<Index>(i) / 3);
    own.dof_component.push_back(static_cast<int>(i % 3));
  }
  own.K_cc = s.K_cc(part.on_interface, part.on_interface);
  own.M_cc = s.M_cc(part.on_interface, part.on_interface);
  own.rigid_body.center = own.coordinates.colwise().mean();
  return own;
}

std::vector<std::size_t> owners(const std::vector<ComponentPart>& parts, const Matrix& Phi) {
  std::vector<std::size_t> owner(Phi.cols(), 0);
  Vector most = Vector::Zero(Phi.cols());
  for (std::size_t q = 0; q < parts.size(); ++q) {
    Vector size = Vector::Zero(Phi.cols());
    for (Index j = 0; j < Phi.cols(); ++j)
      for (const Index i : parts[q].inside) size(j) += Phi(i, j) * Phi(i, j);
    for (Index j = 0; j < Phi.cols(); ++j)
      if (size(j) > most(j)) {
        most(j) = size(j);
        owner[j] = q;
      }
  }
  return owner;
}

FixedInterfaceModes joined(const std::vector<ComponentPart>& parts,
                           const std::vector<FixedInterfaceModes>& modes, Index n_I) {
  struct Place {
    double lambda;
    std::size_t part;
    Index column;
  };
  std::vector<Place> order;
  FixedInterfaceModes all;
  all.method = "none";
  all.proven = true;
  for (std::size_t q = 0; q < modes.size(); ++q) {
    for (Index j = 0; j < modes[q].lambda.size(); ++j) order.push_back({modes[q].lambda(j), q, j});
    all.proven = all.proven && modes[q].proven;
    if (all.method == "none") all.method = modes[q].method;
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Place& a, const Place& b) { return a.lambda < b.lambda; });
  all.lambda.resize(static_cast<Index>(order.size()));
  all.Phi.setZero(n_I, all.lambda.size());
  for (Index j = 0; j < all.lambda.size(); ++j) {
    const Place& from = order[j];
    all.lambda(j) = from.lambda;
    all.Phi(parts[from.part].inside, j) = modes[from.part].Phi.col(from.column);
  }
  return all;
}

FixedInterfaceModes fixed_interface_modes_by_part(const std::vector<ComponentPart>& parts,
                                                  Index n_I, Index k, Report& report) {
  std::vector<FixedInterfaceModes> found(parts.size());
  std::vector<Index> wanted(parts.size());
  for (std::size_t q = 0; q < parts.size(); ++q) {
    const auto n = static_cast<Index>(parts[q].inside.size());
    found[q].Phi.resize(n, 0);
    found[q].method = "none";
    found[q].proven = true;
    wanted[q] = k == 0 ? 0 : std::min(n, k * n / n_I + 1 + beside);
  }
  // A part is done when it has all of its modes, or one above the k-th lowest of all
  for (double threshold = HUGE_VAL;;) {
    Index total = 0;
    for (std::size_t q = 0; q < parts.size(); ++q) {
      if (found[q].lambda.size() < wanted[q]) {
        const SparseCholesky factor(parts[q].p.K_II);  // one at a time: the whole's is there, too
        found[q] = more_modes(parts[q].p, factor, std::move(found[q]), wanted[q], report);
      }
      total += found[q].lambda.size();
    }
    if (total >= k && k > 0) {
      std::vector<double> lambda;
      for (const auto& modes : found)
        lambda.insert(lambda.end(), modes.lambda.begin(), modes.lambda.end());
      std::nth_element(lambda.begin(), lambda.begin() + (k - 1), lambda.end());
      threshold = lambda[k - 1];
    }
    bool done = true;
    for (std::size_t q = 0; q < parts.size(); ++q) {
      const Index n = static_cast<Index>(parts[q].inside.size()), have = found[q].lambda.size();
      if (k == 0 || have == n || found[q].lambda(have - 1) > threshold) continue;
      wanted[q] = std::min(n, 2 * have);
      done = false;
    }
    if (done) break;
  }
  const bool counted = std::any_of(found.begin(), found.end(),
                                   [](const auto& modes) { return !modes.counts.empty(); });
  FixedInterfaceModes all = joined(parts, found, n_I);
  keep_lowest(all, k);
  if (counted && all.proven)
    all.counts =
        format_text("%lld up to %.6g Hz, as many found, in %lld parts", static_cast<long long>(k),
                    std::sqrt(all.lambda(k - 1)) / (2 * std::numbers::pi),
                    static_cast<long long>(parts.size()));
  return all;
}

}  // namespace cbr

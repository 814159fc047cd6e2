// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/mesh_forces.hpp"

#include <algorithm>
#include <numeric>

#include "dynamics/motion/nodal/mesh_kernels.hpp"

namespace cbr {
namespace {

constexpr std::size_t batches_at_a_time = 32;
constexpr Index rows_at_a_time = 256;
constexpr double bytes_of_block = 9 * sizeof(double) + sizeof(std::int32_t);
// Rows of what is not shared are read beside lines of shared elements, by planes: taken as twice
// the time of a matrix alone.
constexpr double time_of_rest = 2;

// P A P^T with row i of the result that of node order[i].
SparseMatrix permuted(const SparseMatrix& A, const std::vector<Index>& order) {
  std::vector<Index> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<Index>(i);
  std::vector<Eigen::Triplet<double, Index>> entries;
  entries.reserve(A.nonZeros());
  for (Index j = 0; j < A.cols(); ++j)
    for (SparseMatrix::InnerIterator it(A, j); it; ++it)
      entries.emplace_back(3 * number[it.row() / 3] + it.row() % 3, 3 * number[j / 3] + j % 3,
                           it.value());
  SparseMatrix B(A.rows(), A.cols());
  B.setFromTriplets(entries.begin(), entries.end());
  return B;
}

// K of the elements `rest` alone, on all nodes of the model.
SparseMatrix rest_stiffness(const FiniteElementModel& model, Mesh mesh,
                            const std::vector<BlockProperties>& properties,
                            const std::vector<std::vector<Index>>& rest) {
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    Block& block = mesh.blocks[b];
    block.connectivity = IndexTable(block.connectivity(rest[b], Eigen::all));
    std::vector<Index> ids;
    for (const Index e : rest[b]) ids.push_back(block.element_ids[e]);
    block.element_ids = std::move(ids);
  }
  const FiniteElementModel part = assemble(mesh, properties, MassKind::lumped);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index j = 0; j < part.K.cols(); ++j)
    for (SparseMatrix::InnerIterator it(part.K, j); it; ++it)
      entries.emplace_back(3 * model.row[part.nodes[it.row() / 3]] + it.row() % 3,
                           3 * model.row[part.nodes[j / 3]] + j % 3, it.value());
  SparseMatrix K(model.K.rows(), model.K.cols());
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

// Nodes by their place along the longest side of what holds them all: neighbours get numbers that
// are a cross-section apart.
std::vector<Index> along_longest_side(const Points& X) {
  Index axis = 0;
  (X.colwise().maxCoeff() - X.colwise().minCoeff()).maxCoeff(&axis);
  return order_by(X.rows(), [&](Index a, Index b) { return X(a, axis) < X(b, axis); });
}

// On one core: rates that a core of a server of the 2020s reaches, about half of its best.
double seconds(double bytes, double operations) { return bytes / 15e9 + operations / 30e9; }

}  // namespace

MeshForces::MeshForces(const SparseMatrix& K) : n_(K.rows() / 3), order_(first_numbers(n_)) {
  K_ = symmetric_block_matrix(K, order_);
}

MeshForces::MeshForces(const FiniteElementModel& model, const Mesh& mesh,
                       const std::vector<BlockProperties>& properties, Variant variant) {
  if (variant != Variant::assembled) shared_ = share_elements(model, mesh, properties);
  Index n_rest = 0;
  for (const auto& rows : shared_.rest) n_rest += static_cast<Index>(rows.size());
  if (!shared_.batches.empty()) {
    n_ = static_cast<Index>(model.nodes.size());
    order_ = shared_.order;
    if (n_rest > 0)
      rest_ = block_matrix(permuted(rest_stiffness(model, mesh, properties, shared_.rest), order_));
    if (variant == Variant::shared) return;
    const double assembled =
        (static_cast<double>(model.K.nonZeros()) / 9 + static_cast<double>(n_)) / 2 *
        bytes_of_block;
    const double rest = static_cast<double>(rest_.column.size()) * bytes_of_block;
    if (seconds(time_of_rest * rest, operations()) < seconds(assembled, 0)) return;
  }
  *this = MeshForces();
  n_ = static_cast<Index>(model.nodes.size());
  order_ = along_longest_side(mesh.coordinates(model.nodes, Eigen::all));
  K_ = symmetric_block_matrix(model.K, order_);
}

double MeshForces::estimated_seconds() const { return seconds(bytes(), operations()); }

double MeshForces::bytes() const {
  return static_cast<double>(K_.column.size() + rest_.column.size()) * bytes_of_block +
         static_cast<double>(shared_.batches.size() * sizeof(SharedElements::Batch));
}

double MeshForces::operations() const {
  // Walsh transforms there and back, eight 3 x 3 products, and the sums into the field, of all
  // lanes
  constexpr double of_box = 2 * 3 * 24 + 8 * 15 + 24;
  return static_cast<double>(shared_.batches.size() * SharedElements::lanes) * of_box +
         18 * static_cast<double>(2 * K_.column.size() + rest_.column.size());
}

void MeshForces::each(const Field& u, RowThreads& threads, Work& work, const Use& use) const {
  shared_.batches.empty() ? each_assembled(u, threads, work, use)
                          : each_shared(u, threads, work, use);
}

void MeshForces::each_assembled(const Field& u, RowThreads& threads, Work& work,
                                const Use& use) const {
  work.x.resize(4 * n_, 0);
  work.window.resize(threads.size());
  threads.for_rows(n_, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      for (int c = 0; c < 3; ++c) work.x[4 * i + c] = u(i, c);
  });
  threads.run([&](int t) {
    assembled_part(work.x, threads.part(n_, t), threads.part(n_, t + 1), work.window[t], use);
  });
}

// Forces on rows begin .. end - 1. What rows before them add to them is computed here too, so that
// threads need not wait for each other; a row is whole when all before it are done.
void MeshForces::assembled_part(const std::vector<double>& x, Index begin, Index end,
                                std::vector<double>& window, const Use& use) const {
  const Index stop = std::min(n_, end + K_.reach);
  window.resize(4 * (stop - begin), 0);
  // From the last row but `reach` on, in the order in which one thread would
  const Index from = std::max<Index>(0, begin - K_.reach);
  symmetric_block_carry(K_, x.data(), from, begin, window.data());
  double f[3 * rows_at_a_time];
  for (Index first = begin; first < end; first += rows_at_a_time) {
    const Index last = std::min(end, first + rows_at_a_time);
    symmetric_block_products(K_, x.data(), first, last, window.data(), begin, f, rows_at_a_time);
    use(first, last, f, rows_at_a_time);
  }
  std::fill(window.begin() + 4 * (end - begin), window.end(), 0.0);
}

void MeshForces::each_shared(const Field& u, RowThreads& threads, Work& work,
                             const Use& use) const {
  work.window.resize(threads.size());
  threads.run([&](int t) {
    shared_part(u, threads.part(n_, t), threads.part(n_, t + 1), work.window[t], use);
  });
}

// Forces on rows begin .. end - 1. Elements that reach over an end are computed on both sides, so
// that threads need not wait for each other; a row is whole once all elements with a lower lowest
// row are done.
void MeshForces::shared_part(const Field& u, Index begin, Index end, std::vector<double>& window,
                             const Use& use) const {
  const auto& batches = shared_.batches;
  const auto at = [&](Index low) {
    return static_cast<std::size_t>(
        std::lower_bound(batches.begin(), batches.end(), low,
                         [](const auto& batch, Index row) { return batch.low < row; }) -
        batches.begin());
  };
  const Index first_row = std::max<Index>(0, begin - shared_.reach),
              stride = std::min(n_, end + shared_.reach) - first_row;
  window.resize(3 * stride, 0);  // all zero between steps
  double* f = window.data();
  const auto clear = [&](Index from, Index to) {
    for (int c = 0; c < 3; ++c)
      std::fill(f + c * stride + from - first_row, f + c * stride + to - first_row, 0.0);
  };
  Index done = begin;
  const std::size_t last = at(end);
  for (std::size_t k = at(first_row);; k += batches_at_a_time) {
    const std::size_t next = std::min(last, k + batches_at_a_time);
    if (k < next) add_box_forces(shared_, k, next, u.data(), n_, f, stride, first_row);
    const Index whole = next >= last ? end : std::min<Index>(end, batches[next].low);
    if (whole > done) {
      if (rest_.rows() > 0)
        add_rows(rest_, u.data(), n_, done, whole, f + done - first_row, stride);
      use(done, whole, f + done - first_row, stride);
      clear(done, whole);
      done = whole;
    }
    if (next >= last) break;
  }
  clear(first_row, begin);
  clear(end, first_row + stride);
}

}  // namespace cbr

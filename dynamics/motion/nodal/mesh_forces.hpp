// SPDX-License-Identifier: GPL-3.0-or-later
// f = K u of a full mesh, in one pass over what has to be read, handed on while it is in the cache.
#pragma once

#include <functional>
#include <vector>

#include "common/base/threads.hpp"
#include "common/fem/assembly.hpp"
#include "dynamics/motion/nodal/block_matrix.hpp"
#include "dynamics/motion/nodal/shared_elements.hpp"

namespace cbr {

// n x 3 by columns: a plane for each component, rows in the order of MeshForces.
using Field = Eigen::Matrix<double, Eigen::Dynamic, 3>;

class MeshForces {
 public:
  enum class Variant : char { automatic, assembled, shared };

  MeshForces() = default;
  // Elements that are translates of each other work by their one stiffness, the rest (and all when
  // `variant` or the counts of bytes and operations say so: docs/decisions/full-mesh.md) by an
  // assembled matrix. model.K must be that of the mesh.
  MeshForces(const FiniteElementModel& model, const Mesh& mesh,
             const std::vector<BlockProperties>& properties, Variant variant = Variant::automatic);
  // Assembled, rows in the order of the model's nodes.
  explicit MeshForces(const SparseMatrix& K);

  Index rows() const { return n_; }
  // Node of the model of each row.
  const std::vector<Index>& order() const { return order_; }
  // What one product reads, but for the fields, and computes.
  Index n_shared_elements() const { return shared_.n_elements; }
  double bytes() const;
  double operations() const;
  // Of one product on one core: what the choice goes by.
  double estimated_seconds() const;

  // Room that each body needs of its own.
  struct Work {
    std::vector<std::vector<double>> window;  // per thread; all zero between steps
    std::vector<double> x;                    // u by rows of four numbers, the last of them zero
  };
  // Component c of the force on row i, begin <= i < end, is f[c * stride + i - begin].
  using Use = std::function<void(Index begin, Index end, const double* f, Index stride)>;
  // Each row comes once, in parts, from several threads at a time; u must not change until it
  // returns. The same bits for any number of threads.
  void each(const Field& u, RowThreads& threads, Work& work, const Use& use) const;

 private:
  void each_shared(const Field& u, RowThreads& threads, Work& work, const Use& use) const;
  void shared_part(const Field& u, Index begin, Index end, std::vector<double>& window,
                   const Use& use) const;
  void each_assembled(const Field& u, RowThreads& threads, Work& work, const Use& use) const;
  void assembled_part(const std::vector<double>& x, Index begin, Index end,
                      std::vector<double>& window, const Use& use) const;

  Index n_ = 0;
  std::vector<Index> order_;
  SharedElements shared_;
  // beside shared elements, of those that are not; no rows when there are none
  BlockMatrix rest_;
  SymmetricBlockMatrix K_;  // without shared elements, of all
};

}  // namespace cbr

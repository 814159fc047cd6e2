// SPDX-License-Identifier: GPL-3.0-or-later
// K_II, M_II and the factor of K_II over all processes: PETSc's matrices, MUMPS's L D L^T (Amestoy,
// Duff, L'Excellent, Koster 2001, doi 10.1137/S0895479899358194), SLEPc's Krylov-Schur (Hernandez,
// Roman, Vidal 2005, doi 10.1145/1089014.1089019).
#pragma once

#include <memory>
#include <vector>

#include "common/fem/assembly.hpp"
#include "common/mesh/mesh.hpp"
#include "reducer/partition/interior.hpp"

namespace cbr {

// --- rows of K and M that one process has: its nodes', by PT-Scotch on the graph of elements'
// nodes. It assembles them from the elements around these nodes. ---

// Of the interior's nodes, numbered as in Partition::interior_nodes. Each process's are numbered
// together, in the order of the whole.
struct NodeShares {
  std::vector<int> owner;     // per node its process
  std::vector<Index> number;  // per node its number in the order of the processes
  std::vector<Index> first;   // per process its first number; one more: of all
};

// node: per node of the mesh its place in the interior, or -1. To be called in all processes.
NodeShares share_nodes(const Mesh& mesh, const std::vector<Index>& node, Index n_interior);

// Square, symmetric, distributed by rows: compressed rows, columns ascending, numbered over all
// processes.
struct DistributedRows {
  std::vector<int> start, column;
  std::vector<double> value;
};

struct InteriorRows {
  // dofs of the interior, of this process, and the number of its first
  Index n = 0, n_own = 0, first = 0;
  std::vector<Index> nodes;  // of this process, in the interior's order
  DistributedRows K_II, M_II;
  SparseMatrix K_IC, M_IC;  // n_own x c
  // as rigid_residual(), of the stiffness of the elements around the own nodes
  double rigid_residual = 0;
  // c x c in the first process, 0 in the others, so that sums over processes are right
  SparseMatrix K_CC, M_CC;
};

// node, place: per node of the mesh its place in the interior and among the nodes of the interface,
// or -1. InputErrors: assemble()'s, of this process's elements.
InteriorRows assemble_rows(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                           MassKind mass, const std::vector<Index>& node,
                           const std::vector<Index>& place, Index n_interface_nodes,
                           const NodeShares& shares, int rank);

// ---

class DistributedInterior final : public Interior {
 public:
  // Takes the rows of K_II and M_II.
  DistributedInterior(const Partition& partition, InteriorRows&& rows);
  ~DistributedInterior() override;

  const std::vector<Index>* own_nodes() const override { return &nodes_; }
  Matrix times_stiffness(const Matrix& X) const override;
  void add_mass(const Matrix& X, Matrix& Y) const override;
  void solve_in_place(Matrix& X) const override;  // after factorise()
  Matrix sum(Matrix part) const override;
  // By columns, to store nothing else twice.
  Matrix gather(Matrix own) const override;
  void in_first(const std::function<void()>& work) const override;
  Matrix from_first(const std::function<Matrix()>& result) const override;

  // Rows of the whole interior, in the order in which processes have them, in the first process.
  std::vector<Index> order_of_rows() const;

  // RunError when memory does not suffice. Returns how many pivots are not positive: any, and K_II
  // is singular or indefinite.
  Index factorise();
  double n_nonzeros() const;  // of the factor, in all processes
  double flops() const;

  const Vector& diagonal() const;  // n_rows, of K_II
  double one_norm() const;         // |K_II|_1
  double scaled_one_norm() const;  // |D K_II D|_1, D = diag(K_II)^-1/2

  // The k lowest of K_II x = lambda M_II x, M-orthonormal; ncv: vectors of the Krylov space, 0:
  // SLEPc's choice. RunError when they do not converge.
  struct Modes {
    Vector lambda;
    Matrix Phi;
    int restarts = 0;
  };
  Modes lowest_modes(Index k, Index ncv) const;

  // How many eigenvalues are below sigma, by the inertia of K_II - sigma M_II; -1 when a pivot
  // vanished. Its factor takes the place of K_II's: factorise() again before the next solve.
  Index count_below(double sigma);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<Index> nodes_;
};

// Columns `first` and up of B, in the first process. order: order_of_rows().
void gather_columns(const std::vector<Index>& order, const Matrix& own, Index first, Matrix& B);

}  // namespace cbr

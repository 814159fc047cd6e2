// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/assembly.hpp"

#include <algorithm>
#include <cassert>

#include "common/base/error.hpp"
#include "common/base/threads.hpp"
#include "common/fem/block_elements.hpp"
#include "common/fem/elements/shell.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {
namespace {

// Element matrices kept at a time, between their computation and their addition to K and M.
constexpr std::size_t batch_bytes = 32u << 20;

// For each node the nodes that share an element with it, itself too, ascending: compressed rows.
struct Neighbours {
  std::vector<Index> start, list;
  Index count(Index i) const { return start[i + 1] - start[i]; }
  const Index* begin(Index i) const { return list.data() + start[i]; }
  // Position of j among i's neighbours.
  Index position(Index i, Index j) const {
    return std::lower_bound(begin(i), begin(i) + count(i), j) - begin(i);
  }
};

// Compressed rows too: which elements (block, row) each node is in. A counting sort over the
// connectivity.
struct ElementsOfNodes {
  struct Entry {
    const Block* block;
    Index e;
  };
  std::vector<Index> start;
  std::vector<Entry> list;
};

ElementsOfNodes elements_of_nodes(const Mesh& mesh, const FiniteElementModel& model) {
  ElementsOfNodes result;
  result.start.assign(model.nodes.size() + 2, 0);
  const auto each = [&](auto action) {
    for (const Block& block : mesh.blocks)
      if (is_volume(block))
        for (Index e = 0; e < block.connectivity.rows(); ++e)
          for (Index i = 0; i < block.connectivity.cols(); ++i)
            action(block, e, static_cast<std::size_t>(model.row[block.connectivity(e, i)]));
  };
  // Counted two places on, so that filling moves each start to its place.
  each([&](const Block&, Index, std::size_t row) { ++result.start[row + 2]; });
  for (std::size_t i = 2; i < result.start.size(); ++i) result.start[i] += result.start[i - 1];
  result.list.resize(result.start.back());
  each([&](const Block& block, Index e, std::size_t row) {
    result.list[result.start[row + 1]++] = {&block, e};
  });
  result.start.pop_back();
  return result;
}

Neighbours find_neighbours(const Mesh& mesh, const FiniteElementModel& model) {
  const ElementsOfNodes elements = elements_of_nodes(mesh, model);
  const auto n = static_cast<std::size_t>(model.n_translations());
  Neighbours neighbours;
  neighbours.start.assign(n + 1, 0);
  std::vector<Index> seen(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = neighbours.list.size();
    for (Index k = elements.start[i]; k < elements.start[i + 1]; ++k) {
      const auto [block, e] = elements.list[k];
      for (Index a = 0; a < block->connectivity.cols(); ++a) {
        const Index j = model.row[block->connectivity(e, a)];
        if (seen[j] == static_cast<Index>(i)) continue;
        seen[j] = static_cast<Index>(i);
        neighbours.list.push_back(j);
      }
    }
    std::sort(neighbours.list.begin() + static_cast<std::ptrdiff_t>(first), neighbours.list.end());
    neighbours.start[i + 1] = static_cast<Index>(neighbours.list.size());
  }
  return neighbours;
}

// Zeros at 3 x 3 blocks for each pair of neighbours (full), or at their diagonals only. Into an
// argument, because Eigen 3.4 copies a sparse matrix that is returned and assigned.
void set_pattern(const Neighbours& neighbours, bool full, SparseMatrix& A) {
  const Index n = static_cast<Index>(neighbours.start.size()) - 1, height = full ? 3 : 1;
  A.resize(3 * n, 3 * n);
  A.resizeNonZeros(3 * height * static_cast<Index>(neighbours.list.size()));
  Index* outer = A.outerIndexPtr();
  Index* inner = A.innerIndexPtr();
  for (Index i = 0; i < n; ++i)
    for (Index c = 0; c < 3; ++c) {
      outer[3 * i + c + 1] = outer[3 * i + c] + height * neighbours.count(i);
      for (Index k = 0; k < neighbours.count(i); ++k)
        for (Index a = 0; a < height; ++a) *inner++ = 3 * neighbours.begin(i)[k] + (full ? a : c);
    }
  std::fill(A.valuePtr(), A.valuePtr() + A.nonZeros(), 0.0);
}

struct ElementMatrices {
  Matrix K, M;  // 3 n x 3 n; n x n, or n x 1 when lumped
};

ElementMatrices element_matrices(const Mesh& mesh, const Block& block,
                                 const BlockProperties& properties, MassKind mass, Index e) {
  const Points X = element_points(mesh, block, e);
  const double rho = properties.material.density;
  return {element_stiffness(block.type, properties.hex, X, properties.material),
          mass == MassKind::lumped
              ? Matrix(element_lumped_mass(block.type, X, rho))
              : element_mass(block.type, X, rho,
                             properties.reduced_mass ? properties.hex : HexFormulation::full)};
}

// Adds the columns that belong to thread t, so no two threads write to one place, and each sum has
// one order.
void add_element(const ElementMatrices& element, const std::vector<Index>& rows,
                 const Neighbours& neighbours, int t, int n_threads, FiniteElementModel& model) {
  const Index n = static_cast<Index>(rows.size());
  for (Index j = 0; j < n; ++j) {
    const Index column = rows[j];
    if (column % n_threads != t) continue;
    const bool lumped = element.M.cols() == 1;
    if (lumped)
      for (Index c = 0; c < 3; ++c) model.M.valuePtr()[3 * column + c] += element.M(j, 0);
    for (Index i = 0; i < n; ++i) {
      const Index k = neighbours.position(column, rows[i]);
      for (Index c = 0; c < 3; ++c) {
        double* values = model.K.valuePtr() + model.K.outerIndexPtr()[3 * column + c] + 3 * k;
        for (Index a = 0; a < 3; ++a) values[a] += element.K(3 * i + a, 3 * j + c);
        if (!lumped)
          model.M.valuePtr()[model.M.outerIndexPtr()[3 * column + c] + k] += element.M(i, j);
      }
    }
  }
}

void add_block(const Mesh& mesh, const Block& block, const BlockProperties& properties,
               MassKind mass, const Neighbours& neighbours, FiniteElementModel& model) {
  const Index n = block.connectivity.cols(), n_e = block.connectivity.rows();
  if (n_e == 0) return;
  const Index batch =
      std::max<Index>(1, static_cast<Index>(batch_bytes / sizeof(double)) / (10 * n * n));
  const int threads = n_threads();
  std::vector<ElementMatrices> matrices(std::min(batch, n_e));
  for (Index first = 0; first < n_e; first += batch) {
    const Index size = std::min(batch, n_e - first);
    run_threads(threads, [&](int t) {
      const Share share(size, t, threads);
      for (Index k = share.begin; k < share.end; ++k)
        matrices[k] = element_matrices(mesh, block, properties, mass, first + k);
    });
    run_threads(threads, [&](int t) {
      std::vector<Index> rows(n);
      for (Index k = 0; k < size; ++k) {
        for (Index i = 0; i < n; ++i) rows[i] = model.row[block.connectivity(first + k, i)];
        add_element(matrices[k], rows, neighbours, t, threads, model);
      }
    });
  }
}

using Triplets = std::vector<Eigen::Triplet<double, Index>>;

// Dofs of a shell's corners as shell_stiffness() has them: rotations stand behind all translations.
std::vector<Index> dofs_of_shell(const Block& block, Index e, const FiniteElementModel& model,
                                 const std::vector<Index>& rotation) {
  std::vector<Index> dofs;
  for (const Index node : block.connectivity.row(e)) {
    const Index u = 3 * model.row[node], r = 3 * rotation[node];
    dofs.insert(dofs.end(), {u, u + 1, u + 2, r, r + 1, r + 2});
  }
  return dofs;
}

void add_shell_mass(const Block& block, const Points& X, const ShellProperties& shell,
                    MassKind mass, const std::vector<Index>& dofs, Triplets& M) {
  const Index n = X.rows();
  const auto dof = [&](Index node, Index c) { return dofs[6 * node + c]; };
  if (mass == MassKind::lumped) {
    const ShellMass lumped = shell_lumped_mass(block.type, X, shell);
    for (Index i = 0; i < n; ++i)
      for (Index c = 0; c < 6; ++c)
        M.emplace_back(dof(i, c), dof(i, c), c < 3 ? lumped.mass(i) : lumped.rotary(i));
    return;
  }
  const Matrix consistent = shell_mass(block.type, X, shell);
  const Matrix3 rotary = shell_rotary_factors(block.type, X, shell);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j)
      for (Index c = 0; c < 3; ++c) {
        M.emplace_back(dof(i, c), dof(j, c), consistent(i, j));
        for (Index d = 0; d < 3; ++d)
          M.emplace_back(dof(i, 3 + c), dof(j, 3 + d), consistent(i, j) * rotary(c, d));
      }
}

void add_triplets(const Triplets& entries, SparseMatrix& A) {
  const Index n = A.rows();
  SparseMatrix B(n, n);
  B.setFromTriplets(entries.begin(), entries.end());
  SparseMatrix sum = A + B;
  A.swap(sum);
}

// Of all shells at once: their rows of rotations come in behind the nodes of solids.
void add_shells(const Mesh& mesh, const std::vector<BlockProperties>& properties, MassKind mass,
                FiniteElementModel& model) {
  if (model.n_rotations == 0) return;
  std::vector<Index> rotation(model.row.size(), -1);
  for (Index i = model.n_translations(); i < static_cast<Index>(model.nodes.size()); ++i)
    rotation[model.nodes[i]] = i;
  Triplets K, M;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!is_shell(block)) continue;
    const ShellProperties shell{properties[b].material, block.thickness};
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      const Points X = element_points(mesh, block, e);
      const std::vector<Index> dofs = dofs_of_shell(block, e, model, rotation);
      const Matrix K_e = shell_stiffness(block.type, X, shell);
      for (Index j = 0; j < K_e.cols(); ++j)
        for (Index i = 0; i < K_e.rows(); ++i) K.emplace_back(dofs[i], dofs[j], K_e(i, j));
      add_shell_mass(block, X, shell, mass, dofs, M);
    }
  }
  const auto n = 3 * static_cast<Index>(model.nodes.size());
  model.K.conservativeResize(n, n);
  model.M.conservativeResize(n, n);
  add_triplets(K, model.K);
  add_triplets(M, model.M);
}

}  // namespace

void number_nodes(const Mesh& mesh, FiniteElementModel& model) {
  std::vector<char> has_rotation(mesh.coordinates.rows(), 0);
  model = FiniteElementModel();
  model.row.assign(mesh.coordinates.rows(), -1);
  for (const Block& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    for (const Index node : block.connectivity.reshaped()) {
      model.row[node] = 0;
      if (is_shell(block)) has_rotation[node] = 1;
    }
  }
  for (std::size_t i = 0; i < model.row.size(); ++i) {
    if (model.row[i] < 0) continue;
    model.row[i] = static_cast<Index>(model.nodes.size());
    model.nodes.push_back(static_cast<Index>(i));
  }
  const std::size_t n_translations = model.nodes.size();
  for (std::size_t i = 0; i < has_rotation.size(); ++i)
    if (has_rotation[i] != 0) model.nodes.push_back(static_cast<Index>(i));
  model.n_rotations = static_cast<Index>(model.nodes.size() - n_translations);
}

Vector consistent_mass_products(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                const FiniteElementModel& model, const Matrix& X) {
  Vector products = Vector::Zero(X.cols());
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!is_volume(block)) continue;
    const Index n = block.connectivity.cols();
    Matrix x(n, 3 * X.cols());  // of each column x, y and z
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      for (Index i = 0; i < n; ++i) {
        const Index node = model.row[block.connectivity(e, i)];
        x.row(i) = X.middleRows(3 * node, 3).reshaped().transpose();
      }
      const Matrix M_e =
          element_mass(block.type, element_points(mesh, block, e), properties[b].material.density);
      const Vector of_axes = x.cwiseProduct(M_e * x).colwise().sum().transpose();
      products += of_axes.reshaped(3, X.cols()).colwise().sum().transpose();
    }
  }
  return products;
}

FiniteElementModel assemble(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                            MassKind mass) {
  assert(properties.size() == mesh.blocks.size());
  check_mesh(mesh, properties);
  FiniteElementModel model;
  number_nodes(mesh, model);
  if (model.nodes.empty()) throw InputError(no_volume_elements);

  const Neighbours neighbours = find_neighbours(mesh, model);
  set_pattern(neighbours, true, model.K);
  if (mass == MassKind::consistent) {
    set_pattern(neighbours, false, model.M);
  } else {
    model.M.resize(model.K.rows(), model.K.rows());
    model.M.setIdentity();
    model.M *= 0.0;
  }
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
    if (is_volume(mesh.blocks[b]))
      add_block(mesh, mesh.blocks[b], properties[b], mass, neighbours, model);
  add_shells(mesh, properties, mass, model);
  return model;
}

}  // namespace cbr

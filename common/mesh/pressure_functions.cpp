// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/pressure_functions.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "common/mesh/face_weights.hpp"

namespace cbr {
namespace {

// cos 20 degrees: the faces of a coarse cylinder are one side still, those of a box are not.
constexpr double same_side_of_edge = 0.94;

// Of squares of distances that are equal on paper.
constexpr double round_off = 1e-9;

int corners_of(const Surface& surface, Index face) {
  return n_corners(static_cast<FaceKind>(nodes_of_face(surface, face).size()));
}

Vector3 face_normal(const Surface& surface, Index face, const Points& x) {
  const int n = corners_of(surface, face);
  const auto row = [&](int a) -> Vector3 { return x.row(surface.faces(face, a)).transpose(); };
  return (row(2) - row(0)).cross(row(n == 3 ? 0 : 3) - row(1)).normalized();
}

struct FaceName {
  std::size_t surface = 0;
  Index face = 0;
};

// Faces that hang together over edges that are not sharp.
std::vector<std::vector<FaceName>> smooth_patches(const std::vector<Surface>& surfaces,
                                                  const Points& x) {
  std::vector<FaceName> faces;
  std::vector<Vector3> normals;
  std::map<std::pair<Index, Index>, std::vector<std::size_t>> at_edge;
  for (std::size_t s = 0; s < surfaces.size(); ++s)
    for (Index f = 0; f < surfaces[s].n_faces(); ++f) {
      const int n = corners_of(surfaces[s], f);
      for (int a = 0; a < n; ++a) {
        const Index p = surfaces[s].faces(f, a), q = surfaces[s].faces(f, (a + 1) % n);
        at_edge[std::minmax(p, q)].push_back(faces.size());
      }
      faces.push_back({s, f});
      normals.push_back(face_normal(surfaces[s], f, x));
    }
  std::vector<std::size_t> root(faces.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t f) {
    for (; root[f] != f; f = root[f]) root[f] = root[root[f]];
    return f;
  };
  for (const auto& [edge, of] : at_edge)
    for (std::size_t i = 1; i < of.size(); ++i)
      if (normals[of[0]].dot(normals[of[i]]) > same_side_of_edge) {
        // The lower one is the root, so that patches have the order of the faces
        const auto [low, high] = std::minmax(find(of[0]), find(of[i]));
        root[high] = low;
      }
  std::map<std::size_t, std::vector<FaceName>> by_root;
  for (std::size_t f = 0; f < faces.size(); ++f) by_root[find(f)].push_back(faces[f]);
  std::vector<std::vector<FaceName>> patches;
  for (auto& [of, patch] : by_root) patches.push_back(std::move(patch));
  return patches;
}

// Faces of one side of sharp edges, one surface a kind.
struct Patch {
  std::vector<Surface> surfaces;
  std::vector<Index> nodes;  // ascending, of the owner
  SparseMatrix M;            // of the owner's nodes
  double area = 0;

  Index local(Index node) const {
    return std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin();
  }
};

Patch patch_of(const std::vector<Surface>& surfaces, const std::vector<FaceName>& faces,
               const Points& x) {
  Patch patch;
  std::vector<std::vector<Index>> rows(surfaces.size());
  for (const FaceName& of : faces) rows[of.surface].push_back(of.face);
  patch.M.resize(x.rows(), x.rows());
  for (std::size_t s = 0; s < surfaces.size(); ++s) {
    if (rows[s].empty()) continue;
    Surface part;
    part.kind = surfaces[s].kind;
    part.faces = surfaces[s].faces(rows[s], Eigen::all);
    patch.M += face_mass(part, x);
    const std::vector<Index> of = surface_nodes(part);
    patch.nodes.insert(patch.nodes.end(), of.begin(), of.end());
    patch.surfaces.push_back(std::move(part));
  }
  sort_uniquely(patch.nodes);
  patch.area = patch.M.sum();
  return patch;
}

// Means over the nodes of the faces around a node, itself included   (m x m).
SparseMatrix averages(const Patch& patch) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (const Surface& surface : patch.surfaces)
    for (Index f = 0; f < surface.n_faces(); ++f)
      for (const Index a : surface.faces.row(f))
        for (const Index b : surface.faces.row(f))
          entries.emplace_back(patch.local(a), patch.local(b), 1);
  const auto m = static_cast<Index>(patch.nodes.size());
  SparseMatrix average(m, m);
  average.setFromTriplets(entries.begin(), entries.end(), [](double, double) { return 1.0; });
  const Vector count = average * Vector::Ones(m);
  return count.cwiseInverse().asDiagonal() * average;
}

// The row of the largest value; of rows as large but for round-off the one whose place comes first
// by x, y, z, so that it does not depend on the numbering of nodes.
Index largest_row(const Vector& value, const Points& x) {
  const double least = value.maxCoeff() * (1 - round_off);
  const auto before = [&](Index a, Index b) {
    for (int d = 0; d < 3; ++d)
      if (x(a, d) != x(b, d)) return x(a, d) < x(b, d);
    return false;
  };
  Index best = -1;
  for (Index i = 0; i < value.size(); ++i)
    if (value[i] >= least && (best < 0 || before(i, best))) best = i;
  return best;
}

// The cell of each node: that of the nearest seed. Seeds are as far from each other as can be; the
// first is the node farthest from the middle.
std::vector<Index> cells_around_seeds(const Points& x, Index k) {
  const auto m = x.rows();
  const auto far_from = [&](const Eigen::RowVector3d& at) -> Vector {
    return (x.rowwise() - at).rowwise().squaredNorm();
  };
  std::vector<Index> cell(m, 0);
  Index seed = largest_row(far_from(x.colwise().mean()), x);
  Vector nearest = far_from(x.row(seed));
  for (Index c = 1; c < k; ++c) {
    seed = largest_row(nearest, x);
    const Vector distance = far_from(x.row(seed));
    for (Index i = 0; i < m; ++i) {
      if (!(distance[i] < nearest[i] * (1 - round_off))) continue;
      nearest[i] = distance[i];
      cell[i] = c;
    }
  }
  return cell;
}

// Adds functions of patches.
class Builder {
 public:
  explicit Builder(const Points& x) : x_(x) {}

  // Psi (m x k) on the patch's nodes; cell: of each of them, of the patch's own functions
  void add(const Patch& patch, const SparseMatrix& Psi, const std::vector<Index>& cell) {
    SparseMatrix on_owner(x_.rows(), Psi.cols());
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (Index a = 0; a < Psi.cols(); ++a)
      for (SparseMatrix::InnerIterator it(Psi, a); it; ++it)
        entries.emplace_back(patch.nodes[it.row()], a, it.value());
    on_owner.setFromTriplets(entries.begin(), entries.end());
    const SparseMatrix N = patch.M * on_owner;
    for (Index a = 0; a < N.cols(); ++a)
      for (SparseMatrix::InnerIterator it(N, a); it; ++it) {
        if (it.value() == 0) continue;
        N_.emplace_back(it.row(), n_ + a, it.value());
        cells_.emplace_back(it.row(), n_ + a, n_ + cell[patch.local(it.row())]);
      }
    n_ += Psi.cols();
    nodes_.insert(nodes_.end(), patch.nodes.begin(), patch.nodes.end());
  }

  // The same, and their values and normals.
  void add_corners(const Patch& patch, const SparseMatrix& Psi, const std::vector<Index>& cell) {
    Points normals = Points::Zero(x_.rows(), 3);
    for (const Surface& surface : patch.surfaces) normals += face_normals(surface, x_);
    const Points of_patch = normals(patch.nodes, Eigen::all);
    for (Index a = 0; a < Psi.cols(); ++a) {
      Vector3 normal = Vector3::Zero();
      for (SparseMatrix::InnerIterator it(Psi, a); it; ++it) {
        Psi_.emplace_back(patch.nodes[it.row()], n_ + a, it.value());
        normal += it.value() * of_patch.row(it.row()).transpose();
      }
      normals_.push_back(normal);
    }
    add(patch, Psi, cell);
  }

  PressureFunctions finish() {
    PressureFunctions functions;
    sort_uniquely(nodes_);
    functions.N = compressed(N_);
    functions.Psi = compressed(Psi_);
    functions.normals.resize(static_cast<Index>(normals_.size()), 3);
    for (std::size_t a = 0; a < normals_.size(); ++a)
      functions.normals.row(static_cast<Index>(a)) = normals_[a].transpose();
    for (const auto& entry : ordered(cells_))
      functions.entry_cell.push_back(static_cast<Index>(entry.value()));
    functions.nodes = std::move(nodes_);
    return functions;
  }

 private:
  using Entry = Eigen::Triplet<double, Index>;

  static std::vector<Entry> ordered(std::vector<Entry> entries) {
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return std::pair(a.col(), a.row()) < std::pair(b.col(), b.row());
    });
    return entries;
  }

  SparseMatrix compressed(const std::vector<Entry>& entries) const {
    std::vector<Entry> local;
    for (const Entry& entry : entries)
      local.emplace_back(
          std::lower_bound(nodes_.begin(), nodes_.end(), entry.row()) - nodes_.begin(), entry.col(),
          entry.value());
    SparseMatrix matrix(static_cast<Index>(nodes_.size()), n_);
    matrix.setFromTriplets(local.begin(), local.end());
    return matrix;
  }

  const Points& x_;
  std::vector<Index> nodes_;
  std::vector<Entry> N_, cells_, Psi_;
  std::vector<Vector3> normals_;
  Index n_ = 0;
};

std::vector<Patch> patches_of(const std::vector<Surface>& faces, const Points& x) {
  std::vector<Patch> patches;
  for (const auto& names : smooth_patches(faces, x)) patches.push_back(patch_of(faces, names, x));
  return patches;
}

}  // namespace

PressureFunctions pressure_functions(const std::vector<Surface>& faces, const Points& coordinates,
                                     Index wanted) {
  const std::vector<Patch> patches = patches_of(faces, coordinates);
  double area = 0;
  for (const Patch& patch : patches) area += patch.area;
  Builder builder(coordinates);
  for (const Patch& patch : patches) {
    const auto m = static_cast<Index>(patch.nodes.size());
    const double share = static_cast<double>(wanted) * patch.area / area;
    const Index k = std::clamp<Index>(std::lround(share), 1, m);
    const Points x = coordinates(patch.nodes, Eigen::all);
    const std::vector<Index> cell = cells_around_seeds(x, k);
    SparseMatrix Psi(m, k);
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (Index i = 0; i < m; ++i) entries.emplace_back(i, cell[i], 1.0);
    Psi.setFromTriplets(entries.begin(), entries.end());
    const SparseMatrix average = averages(patch);
    const double nodes_of_radius = std::sqrt(static_cast<double>(m) / static_cast<double>(k)) / 2;
    const long rounds = std::max(1L, std::lround(nodes_of_radius));
    for (long round = 0; round < rounds; ++round) Psi = SparseMatrix(average * Psi);
    builder.add(patch, Psi, cell);
  }
  return builder.finish();
}

PressureFunctions corner_functions(const std::vector<Surface>& faces, const Points& coordinates) {
  Builder builder(coordinates);
  for (const Patch& patch : patches_of(faces, coordinates)) {
    std::map<std::pair<Index, Index>, double> value;  // node, corner, both of the patch
    for (const Surface& surface : patch.surfaces)
      for (Index f = 0; f < surface.n_faces(); ++f) {
        const std::vector<Index> nodes = nodes_of_face(surface, f);
        const auto per_face = static_cast<int>(nodes.size());
        const int n = n_corners(static_cast<FaceKind>(per_face));
        const auto at = [&](int a) { return patch.local(nodes[a]); };
        for (int a = 0; a < n; ++a) value[{at(a), at(a)}] = 1;
        if (per_face < 2 * n) continue;
        for (int a = 0; a < n; ++a)
          value[{at(n + a), at(a)}] = value[{at(n + a), at((a + 1) % n)}] = 0.5;
        for (int a = 0; a < n && per_face == 9; ++a) value[{at(8), at(a)}] = 0.25;
      }
    const auto m = static_cast<Index>(patch.nodes.size());
    std::vector<Index> function(m, -1);
    Index k = 0;
    for (const auto& [at, share] : value)
      if (at.first == at.second) function[at.first] = k++;
    std::vector<Index> cell = function;
    std::vector<Eigen::Triplet<double, Index>> entries;
    for (const auto& [at, share] : value) {
      const Index a = function[at.second];
      entries.emplace_back(at.first, a, share);
      // A node between corners is of the first one's cell
      Index& its = cell[at.first];
      if (its < 0) its = a;
    }
    SparseMatrix Psi(m, k);
    Psi.setFromTriplets(entries.begin(), entries.end());
    builder.add_corners(patch, Psi, cell);
  }
  return builder.finish();
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/shared_elements.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace cbr {
namespace {

constexpr std::array<int, 8> corner_of_bits{0, 1, 3, 2, 4, 5, 7, 6};  // Exodus' node at each corner
// of equal elements: a mesh that needs more has no lattice
constexpr std::size_t most_groups = 16;
// of a batch: below, its elements are cheaper assembled
constexpr int fewest_lanes = 3;

using Corners = Eigen::Matrix<double, 8, 3>;  // from corner 0, ordered by bits

struct Group {
  std::size_t block;
  Corners shape;
  std::int32_t stiffness;  // -1: not a box
  Index size = 0;
};

struct Element {
  std::size_t block;
  Index row;
  std::int32_t base, pattern;
};

Corners corners_of(const Mesh& mesh, const Block& block, Index e) {
  Corners X;
  for (int b = 0; b < 8; ++b)
    X.row(b) = mesh.coordinates.row(block.connectivity(e, corner_of_bits[b]));
  return X.rowwise() - X.row(0).eval();
}

// Nothing when the element is not a box along the axes, for all that K tells.
std::optional<BoxStiffness> box_stiffness(const BlockProperties& properties, const Corners& shape) {
  const auto& orthotropy = properties.material.orthotropy;
  if (orthotropy && orthotropy->center) return {};  // K depends on the place
  Points X(8, 3);
  for (int b = 0; b < 8; ++b) X.row(corner_of_bits[b]) = shape.row(b);
  const Matrix K = element_stiffness(ElementType::hex8, properties.hex, X, properties.material);
  Matrix H = Matrix::Zero(24, 24);
  for (unsigned w = 0; w < 8; ++w)
    for (unsigned b = 0; b < 8; ++b)
      for (int c = 0; c < 3; ++c)
        H(3 * w + c, 3 * corner_of_bits[b] + c) = std::popcount(w & b) % 2 ? -0.125 : 0.125;
  // S = H K H^T   (24 x 24), all zero but for the eight blocks
  Matrix S = H * K * H.transpose();
  const double small = 1e-13 * S.cwiseAbs().maxCoeff();
  BoxStiffness box;
  for (int s = 0; s < 8; ++s)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        box[s][3 * r + c] = std::exchange(S(3 * (s ^ (1 << r)) + r, 3 * (s ^ (1 << c)) + c), 0.0);
  if (!(S.cwiseAbs().maxCoeff() <= small)) return {};
  // A translation, component c of function 0, makes no force: to the last bit, so that momentum is
  // kept.
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < 3; ++k) box[1 << c][3 * c + k] = box[1 << c][3 * k + c] = 0;
  return box;
}

class Sharing {
 public:
  Sharing(const FiniteElementModel& model, const Mesh& mesh,
          const std::vector<BlockProperties>& properties)
      : model_(model), mesh_(mesh), properties_(properties) {}

  SharedElements run() {
    shared_.rest.resize(mesh_.blocks.size());
    find_groups();
    const auto largest =
        std::max_element(groups_.begin(), groups_.end(), [](const Group& a, const Group& b) {
          return (a.stiffness >= 0 ? a.size : -1) < (b.stiffness >= 0 ? b.size : -1);
        });
    if (largest == groups_.end() || largest->stiffness < 0) return std::move(shared_);
    number_nodes(largest->shape);
    find_patterns();
    make_batches();
    std::sort(shared_.batches.begin(), shared_.batches.end(), [](const auto& a, const auto& b) {
      return std::pair(a.low, a.pattern) < std::pair(b.low, b.pattern);
    });
    for (const auto& batch : shared_.batches)
      shared_.reach = std::max<Index>(shared_.reach, batch.high - batch.low);
    if (shared_.batches.empty()) shared_.order.clear();
    return std::move(shared_);
  }

 private:
  // Group of each hex; the elements of no group, and of groups that are no boxes, are rest.
  void find_groups() {
    const double largest = mesh_.coordinates.cwiseAbs().maxCoeff(),
                 equal = 64 * std::numeric_limits<double>::epsilon() * largest;
    for (std::size_t b = 0; b < mesh_.blocks.size(); ++b) {
      const Block& block = mesh_.blocks[b];
      if (dimension(block.type) != 3) continue;
      for (Index e = 0; e < block.connectivity.rows(); ++e) {
        const int group = block.type == ElementType::hex8 ? group_of(b, e, equal) : -1;
        if (group < 0 || groups_[group].stiffness < 0) {
          shared_.rest[b].push_back(e);
        } else {
          ++groups_[group].size;
          elements_.push_back({b, e, 0, group});
        }
      }
    }
  }

  int group_of(std::size_t b, Index e, double equal) {
    const Corners shape = corners_of(mesh_, mesh_.blocks[b], e);
    for (std::size_t g = 0; g < groups_.size(); ++g)
      if (groups_[g].block == b && (groups_[g].shape - shape).cwiseAbs().maxCoeff() <= equal)
        return static_cast<int>(g);
    if (groups_.size() == most_groups) return -1;
    const auto box = box_stiffness(properties_[b], shape);
    if (box) shared_.stiffness.push_back(*box);
    groups_.push_back(
        {b, shape, box ? static_cast<std::int32_t>(shared_.stiffness.size()) - 1 : -1});
    return static_cast<int>(groups_.size()) - 1;
  }

  // By the lattice of one group: along its longest direction first, along its shortest next.
  void number_nodes(const Corners& shape) {
    Matrix3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = shape.row(1 << k).transpose();
    const Index n = static_cast<Index>(model_.nodes.size());
    const Matrix3 inverse = edges.inverse();
    const Vector3 origin = mesh_.coordinates.row(model_.nodes[0]).transpose();
    std::vector<std::array<Index, 3>> place(n);
    std::array<Index, 3> lowest{}, highest{};
    for (Index i = 0; i < n; ++i) {
      const Vector3 xi = inverse * (mesh_.coordinates.row(model_.nodes[i]).transpose() - origin);
      for (int k = 0; k < 3; ++k) {
        place[i][k] = std::llround(xi[k]);
        lowest[k] = std::min(lowest[k], place[i][k]);
        highest[k] = std::max(highest[k], place[i][k]);
      }
    }
    std::array<int, 3> axis{0, 1, 2};
    std::stable_sort(axis.begin(), axis.end(),
                     [&](int a, int b) { return highest[a] - lowest[a] > highest[b] - lowest[b]; });
    const auto key = [&](Index i) {
      return std::tuple(place[i][axis[1]], place[i][axis[2]], place[i][axis[0]], i);
    };
    shared_.order.resize(n);
    std::iota(shared_.order.begin(), shared_.order.end(), Index{0});
    std::sort(shared_.order.begin(), shared_.order.end(),
              [&](Index a, Index b) { return key(a) < key(b); });
    number_.resize(n);
    for (Index i = 0; i < n; ++i) number_[shared_.order[i]] = static_cast<std::int32_t>(i);
  }

  void find_patterns() {
    std::map<std::array<std::int32_t, 9>, std::int32_t> known;
    for (Element& element : elements_) {
      const IndexTable& connectivity = mesh_.blocks[element.block].connectivity;
      const auto node = [&](int b) {
        return number_[model_.row[connectivity(element.row, corner_of_bits[b])]];
      };
      element.base = node(0);
      std::array<std::int32_t, 9> key;
      for (int b = 0; b < 8; ++b) key[b] = node(b) - element.base;
      key[8] = groups_[element.pattern].stiffness;
      const auto [it, is_new] =
          known.try_emplace(key, static_cast<std::int32_t>(shared_.patterns.size()));
      if (is_new) {
        shared_.patterns.push_back({{}, key[8]});
        std::copy(key.begin(), key.begin() + 8, shared_.patterns.back().offset.begin());
      }
      element.pattern = it->second;
    }
  }

  void make_batches() {
    std::sort(elements_.begin(), elements_.end(), [](const Element& a, const Element& b) {
      return std::pair(a.pattern, a.base) < std::pair(b.pattern, b.base);
    });
    const auto n = static_cast<std::int32_t>(model_.nodes.size());
    for (std::size_t i = 0, next = 0; i < elements_.size(); i = next) {
      const Element& first = elements_[i];
      const auto& offset = shared_.patterns[first.pattern].offset;
      const auto [least, most] = std::minmax_element(offset.begin(), offset.end());
      SharedElements::Batch batch{first.base, 0, 0, first.pattern, 0};
      // Lanes that hold no element are read all the same: they must be nodes.
      batch.base = std::min(batch.base, n - SharedElements::lanes - *most);
      const bool fits = batch.base + *least >= 0;
      next = i;
      while (next < elements_.size() && elements_[next].pattern == first.pattern &&
             elements_[next].base < batch.base + SharedElements::lanes) {
        const std::uint32_t lane = 1u << (elements_[next].base - batch.base);
        if (batch.used & lane) break;  // two elements on the same nodes
        batch.used |= lane;
        ++next;
      }
      batch.low = batch.base + *least;
      batch.high = batch.base + *most + SharedElements::lanes - 1;
      if (fits && std::popcount(batch.used) >= fewest_lanes) {
        shared_.batches.push_back(batch);
        shared_.n_elements += static_cast<Index>(next - i);
      } else {
        next = std::max(next, i + 1);
        for (std::size_t k = i; k < next; ++k)
          shared_.rest[elements_[k].block].push_back(elements_[k].row);
      }
    }
    for (auto& rows : shared_.rest) std::sort(rows.begin(), rows.end());
  }

  const FiniteElementModel& model_;
  const Mesh& mesh_;
  const std::vector<BlockProperties>& properties_;
  SharedElements shared_;
  std::vector<Group> groups_;
  std::vector<Element> elements_;     // `pattern` is the group until the nodes are numbered
  std::vector<std::int32_t> number_;  // internal, per node of the model
};

}  // namespace

SharedElements share_elements(const FiniteElementModel& model, const Mesh& mesh,
                              const std::vector<BlockProperties>& properties) {
  return Sharing(model, mesh, properties).run();
}

}  // namespace cbr

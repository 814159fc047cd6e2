// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/fem/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/base/threads.hpp"
#include "common/fem/block_elements.hpp"
#include "common/fem/elements/shell_plane.hpp"
#include "common/linalg/blas_threads.hpp"

namespace cbr {
namespace {

// Below this an element's Jacobian is zero within the round-off of coordinates.
constexpr double smallest_quality = 1e-10;

std::string rounded_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

std::string element_text(const Block& block, Index e) {
  return "block '" + block.name + "': element " + std::to_string(block.element_ids[e]) + " (" +
         std::string(name(block.type)) + ")";
}

void check_material(const Block& block, const Material& material) {
  const auto refuse = [&](const std::string& what, double got, const std::string& allowed) {
    throw InputError("block '" + block.name + "': " + what + " is " + number_text(got) +
                     ": it must be " + allowed);
  };
  const double E = material.youngs_modulus, nu = material.poissons_ratio, rho = material.density;
  if (!(E > 0) || !std::isfinite(E)) refuse("youngs_modulus", E, "positive and finite");
  if (!(nu > -1 && nu < 0.5)) refuse("poissons_ratio", nu, "above -1 and below 0.5");
  if (!(rho > 0) || !std::isfinite(rho)) refuse("density", rho, "positive and finite");
}

void check_nodes(const Mesh& mesh, const Block& block, Index e) {
  const auto nodes = block.connectivity.row(e);
  for (Index i = 0; i < nodes.size(); ++i) {
    const std::string id = std::to_string(mesh.node_ids[nodes(i)]);
    if (!mesh.coordinates.row(nodes(i)).allFinite())
      throw InputError("node " + id + " of " + element_text(block, e) +
                       " has a coordinate that is not a finite number");
    for (Index j = 0; j < i; ++j)
      if (nodes(i) == nodes(j))
        throw InputError(element_text(block, e) + " has node " + id +
                         " twice: give the element the type that it really has");
  }
}

bool nodes_are_usable(const Mesh& mesh, const Block& block, Index e) {
  for (Index i = 0; i < block.connectivity.cols(); ++i) {
    if (!mesh.coordinates.row(block.connectivity(e, i)).allFinite()) return false;
    for (Index j = 0; j < i; ++j)
      if (block.connectivity(e, i) == block.connectivity(e, j)) return false;
  }
  return true;
}

// The first element in the block's order that is not usable is the one reported, whatever the
// number of threads.
void check_elements(const Mesh& mesh, const Block& block) {
  const Index n = block.connectivity.rows();
  const int threads = n_threads();
  std::vector<Index> first(threads, n);
  run_threads(threads, [&](int t) {
    const Share share(n, t, threads);
    for (Index e = share.begin; e < share.end; ++e)
      if (!nodes_are_usable(mesh, block, e) ||
          !(element_quality(block.type, element_points(mesh, block, e)) > smallest_quality)) {
        first[t] = e;
        return;
      }
  });
  const Index e = *std::min_element(first.begin(), first.end());
  if (e == n) return;
  check_nodes(mesh, block, e);
  const double quality = element_quality(block.type, element_points(mesh, block, e));
  const std::string found = std::isfinite(quality)
                                ? "its smallest Jacobian is " + rounded_text(quality) +
                                      " of the mean one, allowed: above " +
                                      rounded_text(smallest_quality)
                                : "its volume is below 0";
  throw InputError(element_text(block, e) + (quality < 0 ? " is inverted (" : " is degenerate (") +
                   found + "): check its node order and coordinates");
}

// Stiffness E h, mass rho h^3 and frequency sqrt(E / rho) / h of an element of size h must leave
// room for products of them.
void check_magnitudes(const Mesh& mesh, const Block& block, const Material& material) {
  constexpr double least = 1e-290, most = 1e200;
  if (block.connectivity.rows() == 0) return;
  double smallest = HUGE_VAL, largest = 0;
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    const Points X = element_points(mesh, block, e);
    const double h = (X.colwise().maxCoeff() - X.colwise().minCoeff()).maxCoeff();
    smallest = std::min(smallest, h);
    largest = std::max(largest, h);
  }
  const auto require = [&](double value, const std::string& what) {
    if (value >= least && value <= most) return;
    throw InputError("block '" + block.name + "': elements of size " + rounded_text(smallest) +
                     " to " + rounded_text(largest) + ", youngs_modulus " +
                     number_text(material.youngs_modulus) + " and density " +
                     number_text(material.density) + " give a " + what + " of about " +
                     rounded_text(value) + ", allowed: " + rounded_text(least) + " to " +
                     rounded_text(most) + ": look at the units of the mesh and the material");
  };
  for (const double h : {smallest, largest}) {
    require(material.youngs_modulus * h, "stiffness");
    require(material.density * h * h * h, "mass");
    require(material.youngs_modulus / material.density / h / h, "squared frequency");
  }
}

std::vector<Index> sorted_nodes(const Block& block, Index e) {
  std::vector<Index> nodes(block.connectivity.row(e).begin(), block.connectivity.row(e).end());
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

// Two elements of the same nodes fill one place twice: its mass and stiffness would count twice.
void check_repeated(const Mesh& mesh) {
  struct Entry {
    std::uint64_t hash;
    const Block* block;
    Index e;
  };
  std::vector<Entry> entries;
  for (const Block& block : mesh.blocks) {
    if (!is_structure(block)) continue;
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      std::uint64_t hash = 0;  // a sum: the order of the nodes does not matter
      for (const Index node : block.connectivity.row(e)) {
        std::uint64_t x = static_cast<std::uint64_t>(node) * 0x9E3779B97F4A7C15u;
        x = (x ^ (x >> 29)) * 0xBF58476D1CE4E5B9u;
        hash += x ^ (x >> 32);
      }
      entries.push_back({hash, &block, e});
    }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.hash < b.hash; });
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const Entry &a = entries[i - 1], &b = entries[i];
    if (a.hash != b.hash || sorted_nodes(*a.block, a.e) != sorted_nodes(*b.block, b.e)) continue;
    throw InputError(element_text(*b.block, b.e) + " has the same nodes as " +
                     element_text(*a.block, a.e) +
                     ", so that its mass and stiffness would count twice: remove one of them");
  }
}

void check_shells(const Mesh& mesh, const Block& block) {
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    check_nodes(mesh, block, e);
    if (!(shell::corner_jacobian(block.type, element_points(mesh, block, e)) > shell::flat_corner))
      throw InputError(element_text(block, e) +
                       " is degenerate: its nodes lie on a line, or do not make a convex face: "
                       "check its node order and coordinates");
  }
}

}  // namespace

void check_mesh(const Mesh& mesh, const std::vector<BlockProperties>& properties) {
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!is_structure(block)) continue;
    check_material(block, properties[b].material);
    if (is_shell(block))
      check_shells(mesh, block);
    else
      check_elements(mesh, block);
    check_magnitudes(mesh, block, properties[b].material);
  }
  check_repeated(mesh);
}

}  // namespace cbr

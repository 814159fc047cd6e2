// SPDX-License-Identifier: GPL-3.0-or-later
// Topology of element types: nodes, dimension and sides, in Exodus II's order.
// Tables, no numerics.
#pragma once

#include <string_view>
#include <vector>

namespace cbr {

enum class ElementType {
  tri3,
  tri6,
  quad4,
  quad8,
  quad9,
  tet4,
  tet10,
  pyramid5,
  wedge6,
  wedge15,
  hex8,
  hex20,
  hex27
};

// The faces of contact and of superelement files; the value is the number of nodes.
enum class FaceKind { tri3 = 3, quad4 = 4, tri6 = 6, quad8 = 8, quad9 = 9 };

std::string_view name(ElementType type);  // "hex8"
std::string_view name(FaceKind kind);     // "quad4"
int n_nodes(ElementType type);
int n_nodes(FaceKind kind);
int dimension(ElementType type);  // 2 or 3
int n_sides(ElementType type);    // faces of a volume element; 0 for shells

// Local node numbers (from 0) of a side (from 1), outward by the right-hand rule, corners first,
// then mid-side nodes. A side of a hex27 is a quad9: its centre node comes last.
const std::vector<int>& side_nodes(ElementType type, int side);
FaceKind side_kind(ElementType type, int side);

int n_corners(ElementType type);
int n_corners(FaceKind kind);

// Node i of the mirrored element is node mirrored_order(type)[i] of the original one: a reflected
// mesh whose elements are reordered so keeps positive volumes, and shells the side that they look
// to. An involution.
const std::vector<int>& mirrored_order(ElementType type);
// the number that the side gets by it; volume elements
int mirrored_side(ElementType type, int side);

}  // namespace cbr

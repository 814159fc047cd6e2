// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/surface_edges.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <tuple>

namespace cbr {
namespace {

// A side of a face, from a to b in the order of its corners.
struct FaceSide {
  Index a, b, face;
  Index low() const { return std::min(a, b); }
  Index high() const { return std::max(a, b); }
  bool operator<(const FaceSide& other) const {
    return std::tuple(low(), high(), face) < std::tuple(other.low(), other.high(), other.face);
  }
};

std::vector<FaceSide> sides_of_faces(const ContactSurface& surface) {
  std::vector<FaceSide> sides;
  sides.reserve(static_cast<std::size_t>(4 * surface.faces.rows()));
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const int n = n_corners(surface, f);
    for (int a = 0; a < n; ++a)
      sides.push_back({surface.faces(f, a), surface.faces(f, (a + 1) % n), f});
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

// Convex with more than the angle that counts as flat; open edges are sharp.
bool is_sharp(const ContactSurface& surface, const SurfaceEdge& edge, const Points& points) {
  if (edge.faces[1] < 0) return true;
  const EdgeWedge wedge = wedge_at(surface, edge, points);
  return wedge.normal[0].dot(wedge.normal[1]) < nearly_flat &&
         wedge.normal[0].dot(wedge.inward[1]) < 0;
}

// Nodes of faces that are none of the surface are tied to the other side.
bool has_node(const ContactSurface& surface, Index node) {
  return std::binary_search(surface.nodes.begin(), surface.nodes.end(), node);
}

// The nodes of sharp edges as a separate slave.
std::shared_ptr<const ContactSurface> ridge_of(const ContactSurface& surface) {
  auto ridge = std::make_shared<ContactSurface>();
  ridge->name = surface.name;
  ridge->body = surface.body;
  for (const SurfaceEdge& edge : surface.edges)
    if (edge.sharp) ridge->nodes.insert(ridge->nodes.end(), {edge.a, edge.b});
  std::erase_if(ridge->nodes, [&](Index node) { return !has_node(surface, node); });
  std::sort(ridge->nodes.begin(), ridge->nodes.end());
  ridge->nodes.erase(std::unique(ridge->nodes.begin(), ridge->nodes.end()), ridge->nodes.end());
  const auto n = static_cast<Index>(ridge->nodes.size());
  ridge->size = surface.size;
  ridge->areas.resize(n);
  ridge->area_vectors.resize(n, 3);
  for (Index i = 0; i < n; ++i) {
    const Index slot =
        std::lower_bound(surface.nodes.begin(), surface.nodes.end(), ridge->nodes[i]) -
        surface.nodes.begin();
    ridge->areas[i] = surface.areas[slot];
    ridge->area_vectors.row(i) = surface.area_vectors.row(slot);
  }
  return ridge;
}

}  // namespace

EdgeWedge wedge_at(const ContactSurface& surface, const SurfaceEdge& edge, const Points& points) {
  EdgeWedge wedge;
  const Vector3 from = points.row(edge.a).transpose();
  wedge.direction = (points.row(edge.b).transpose() - from).normalized();
  for (std::size_t i = 0; i < 2; ++i) {
    if (edge.faces[i] < 0) {
      wedge.normal[i] = -wedge.inward[0];
      wedge.inward[i] = -wedge.normal[0];
      continue;
    }
    const FaceCorners x = corners(surface, edge.faces[i], points);
    wedge.normal[i] = mean_normal(x);
    wedge.inward[i] = wedge.normal[i].cross(wedge.direction).normalized();
    if (wedge.inward[i].dot(centre(x) - from) < 0) wedge.inward[i] *= -1;
  }
  return wedge;
}

void fill_edges(ContactSurface& surface, const Points& points) {
  surface.edges.clear();
  const std::vector<FaceSide> sides = sides_of_faces(surface);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const FaceSide& side = sides[i];
    SurfaceEdge edge{side.a, side.b, {side.face, -1}, false};
    // More than two faces at an edge: pairs in turn
    const bool is_shared = i + 1 < sides.size() && sides[i + 1].low() == side.low() &&
                           sides[i + 1].high() == side.high();
    if (is_shared) edge.faces[1] = sides[++i].face;
    if (!has_node(surface, edge.a) && !has_node(surface, edge.b)) continue;
    edge.sharp = is_sharp(surface, edge, points);
    surface.edges.push_back(edge);
  }
  surface.ridge = ridge_of(surface);
}

}  // namespace cbr

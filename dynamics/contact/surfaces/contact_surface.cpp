// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/contact_surface.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
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
  sort_uniquely(ridge->nodes);
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

void sweep(ContactBody& body) {
  body.swept = {Vector3::Constant(HUGE_VAL), Vector3::Constant(-HUGE_VAL)};
  double way2 = 0;
  for (Index i = 0; i < body.end.rows(); ++i) {
    const Vector3 x0 = body.start.row(i).transpose(), x1 = body.end.row(i).transpose();
    body.swept.lower = body.swept.lower.cwiseMin(x0).cwiseMin(x1);
    body.swept.upper = body.swept.upper.cwiseMax(x0).cwiseMax(x1);
    way2 = std::max(way2, (x1 - x0).squaredNorm());
  }
  body.longest_way = std::sqrt(way2);
}

FaceCorners corners(const ContactSurface& surface, Index face, const Points& points) {
  FaceCorners x;
  for (int a = 0; a < 4; ++a) x[a] = points.row(surface.faces(face, a)).transpose();
  return x;
}

Index slot_of(const ContactSurface& surface, Index face, int corner) {
  return std::lower_bound(surface.nodes.begin(), surface.nodes.end(), surface.faces(face, corner)) -
         surface.nodes.begin();
}

double facing_area(double area, const Vector3& area_vector, const Vector3& normal) {
  constexpr double least_share = 0.2;
  return std::max(-area_vector.dot(normal), least_share * area);
}

double facing_area(const ContactSurface& surface, Index slot, const ContactBody& body,
                   const Vector3& normal) {
  if (surface.area_vectors.rows() == 0) return surface.areas[slot];
  return facing_area(surface.areas[slot], surface.area_vectors.row(slot),
                     body.turn ? body.turn->transpose() * normal : normal);
}

double bend(const ContactSurface& surface) {
  if (surface.area_vectors.rows() == 0) return 0;
  std::vector<double> of_nodes;  // without mid-side nodes of second-order faces, whose area is 0
  for (Index i = 0; i < surface.areas.size(); ++i)
    if (surface.areas[i] > 0)
      of_nodes.push_back(1 - surface.area_vectors.row(i).norm() / surface.areas[i]);
  if (of_nodes.empty()) return 0;
  const auto middle = of_nodes.begin() + static_cast<std::ptrdiff_t>(of_nodes.size() / 2);
  std::nth_element(of_nodes.begin(), middle, of_nodes.end());
  return std::max(0.0, *middle);
}

namespace {

// Centre and normal of a face.
struct FacePlane {
  Vector3 centre, normal;
};

// Whether two faces that share a corner node form a concave corner sharper than 15 degrees.
bool make_a_corner(const FacePlane& a, const FacePlane& b) {
  if (!(a.normal.dot(b.normal) < nearly_flat)) return false;
  const Vector3 between = b.centre - a.centre;
  return a.normal.dot(between) > 0 && b.normal.dot(between) < 0;
}

void fill_rising(ContactSurface& surface, const Points& points) {
  const Index n = surface.faces.rows();
  std::vector<FacePlane> planes(static_cast<std::size_t>(n));
  std::vector<std::vector<Index>> faces_of(surface.nodes.size());
  for (Index f = 0; f < n; ++f) {
    const FaceCorners x = corners(surface, f, points);
    planes[f] = {centre(x), mean_normal(x)};
    for (int a = 0; a < n_corners(surface, f); ++a) faces_of[slot_of(surface, f, a)].push_back(f);
  }
  surface.rising.clear();
  surface.rising_begin.assign(1, 0);
  for (Index f = 0; f < n; ++f) {
    const std::ptrdiff_t first = surface.rising_begin.back();
    for (int a = 0; a < n_corners(surface, f); ++a)
      for (const Index other : faces_of[slot_of(surface, f, a)])
        if (other != f && make_a_corner(planes[f], planes[other]) &&
            std::find(surface.rising.begin() + first, surface.rising.end(), other) ==
                surface.rising.end())
          surface.rising.push_back(other);
    surface.rising_begin.push_back(static_cast<Index>(surface.rising.size()));
  }
  if (surface.rising.empty()) surface.rising_begin.clear();
}

}  // namespace

void fill_sizes(ContactSurface& surface, const Points& points) {
  surface.sizes.resize(surface.faces.rows());
  surface.extent.setZero();
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const FaceCorners x = corners(surface, f, points);
    // Half the cross product of the diagonals, also valid for a triangle with a repeated corner
    surface.sizes[f] = std::sqrt(0.5 * (x[2] - x[0]).cross(x[3] - x[1]).norm());
    for (int a = 1; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        surface.extent = surface.extent.cwiseMax((x[a] - x[b]).cwiseAbs());
  }
  fill_rising(surface, points);
  surface.size = surface.sizes.size() ? surface.sizes.mean() : 0;
  surface.areas.setZero(static_cast<Index>(surface.nodes.size()));
  surface.area_vectors.setZero(surface.areas.size(), 3);
  for (Index f = 0; f < surface.faces.rows(); ++f) {
    const FaceCorners x = corners(surface, f, points);
    const Vector3 outward = 0.5 * (x[2] - x[0]).cross(x[3] - x[1]);
    const int n = n_corners(surface, f);
    for (int a = 0; a < n; ++a) {
      const Index slot = slot_of(surface, f, a);
      surface.areas[slot] += surface.sizes[f] * surface.sizes[f] / n;
      surface.area_vectors.row(slot) += outward.transpose() / n;
    }
  }
}

Vector3 mean_normal(const FaceCorners& x) {
  const Vector3 across = (x[2] - x[0]).cross(x[3] - x[1]);
  const double length2 = across.squaredNorm();
  // Where squares neither overflow nor underflow, this saves two divisions
  if (length2 > 1e-200 && length2 < 1e200) return across * (1 / std::sqrt(length2));
  return across.stableNormalized();
}

Vector3 centre(const FaceCorners& x) {
  return x[2] == x[3] ? Vector3((x[0] + x[1] + x[2]) / 3)
                      : Vector3((x[0] + x[1] + x[2] + x[3]) / 4);
}

Vector3 mean_motion(const ContactSurface& surface, const ContactBody& body) {
  Vector3 sum = Vector3::Zero();
  for (const Index node : surface.nodes)
    sum += (body.end.row(node) - body.start.row(node)).transpose();
  return sum / static_cast<double>(std::max<std::size_t>(1, surface.nodes.size()));
}

double largest_motion(const ContactSurface& surface, const ContactBody& body,
                      const Vector3& drift) {
  double largest = 0;
  for (const Index node : surface.nodes)
    largest =
        std::max(largest, (body.end.row(node) - body.start.row(node) - drift.transpose()).norm());
  return largest;
}

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

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_search.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

namespace cbr::test {
namespace {

// From the centre, or straight from the axis.
Vector3 from_middle(const DenseWall& wall, const Vector3& x) {
  Vector3 r = x - wall.point;
  if (wall.kind == DenseWall::Kind::cylinder) r -= r.dot(wall.direction) * wall.direction;
  return r;
}

std::vector<std::array<int, 4>> pieces(Index n) {
  if (n == 3) return {{0, 1, 2, 2}};
  if (n == 4) return {{0, 1, 2, 3}};
  if (n == 6) return {{0, 3, 5, 5}, {3, 1, 4, 4}, {5, 4, 2, 2}, {3, 4, 5, 5}};
  if (n == 8) return {{0, 4, 7, 7}, {4, 1, 5, 5}, {5, 2, 6, 6}, {6, 3, 7, 7}, {4, 5, 6, 7}};
  if (n == 9) return {{0, 4, 8, 7}, {4, 1, 5, 8}, {8, 5, 2, 6}, {7, 8, 6, 3}};
  throw std::runtime_error("the oracle knows no such face");
}

void fill_rising(DenseSurface& surface, const Points& X) {
  const auto normal_and_middle = [&](const std::array<Index, 4>& face) {
    std::array<Vector3, 4> x;
    for (std::size_t a = 0; a < 4; ++a) x[a] = X.row(face[a]).transpose();
    Vector3 middle = x[0] + x[1] + x[2];
    middle = face[2] == face[3] ? Vector3(middle / 3) : Vector3((middle + x[3]) / 4);
    return std::pair<Vector3, Vector3>((x[2] - x[0]).cross(x[3] - x[1]).normalized(), middle);
  };
  surface.rising.resize(surface.faces.size());
  for (std::size_t f = 0; f < surface.faces.size(); ++f)
    for (std::size_t g = 0; g < surface.faces.size(); ++g) {
      const auto &at = surface.faces[f], &other = surface.faces[g];
      if (f == g ||
          std::find_first_of(at.begin(), at.end(), other.begin(), other.end()) == at.end())
        continue;
      const auto [n_f, x_f] = normal_and_middle(at);
      const auto [n_g, x_g] = normal_and_middle(other);
      if (n_f.dot(n_g) < 0.966 && n_f.dot(x_g - x_f) > 0 && n_g.dot(x_g - x_f) < 0)
        surface.rising[f].push_back(static_cast<Index>(g));
    }
}

}  // namespace

DenseSurface dense_surface(Index body, const IndexTable& faces, const Points& X) {
  DenseSurface surface;
  surface.body = body;
  std::set<Index> nodes;
  for (Index f = 0; f < faces.rows(); ++f)
    for (const auto& piece : pieces(faces.cols())) {
      std::array<Index, 4> face;
      std::array<Vector3, 4> x;
      for (std::size_t a = 0; a < 4; ++a) {
        face[a] = faces(f, piece[a]);
        x[a] = X.row(face[a]).transpose();
        nodes.insert(face[a]);
      }
      surface.faces.push_back(face);
      surface.sizes.push_back(std::sqrt(0.5 * (x[2] - x[0]).cross(x[3] - x[1]).norm()));
      surface.size += surface.sizes.back();
    }
  fill_rising(surface, X);
  surface.size /= static_cast<double>(surface.faces.size());
  surface.nodes.assign(nodes.begin(), nodes.end());
  return surface;
}

double DenseWall::distance(const Vector3& x) const {
  return kind == Kind::plane ? direction.dot(x - point) : from_middle(*this, x).norm() - radius;
}

Vector3 DenseWall::normal(const Vector3& x) const {
  return kind == Kind::plane ? direction : from_middle(*this, x).normalized();
}

Matrix3 dense_frame(const Vector3& normal) {
  Matrix3 frame;
  const Vector3 t = normal.unitOrthogonal();
  frame.row(0) = normal.transpose();
  frame.row(1) = t.transpose();
  frame.row(2) = normal.cross(t).transpose();
  return frame;
}

double dense_reach(double size, double way, bool initial) {
  const double reach = 0.02 * size + 0.5 * way;
  return initial ? std::max(size, reach) : reach;
}

void start(const DenseSurface& slave, DenseMemory& memory) {
  if (!memory.face.empty()) return;
  const std::size_t n = slave.nodes.size();
  memory.face.assign(n, -1);
  memory.known_face.assign(n, -1);
  memory.offset.assign(n, 0);
  memory.touched.assign(n, {});
  memory.stretch = Points::Zero(static_cast<Index>(n), 3);
}

std::vector<DensePoint> dense_wall_points(const DenseSurface& slave, const DenseWall& wall,
                                          const DensePath& path, bool initial,
                                          DenseMemory& memory) {
  start(slave, memory);
  double way = 0;
  for (const Index node : slave.nodes)
    way = std::max(way, (path.end.row(node) - path.start.row(node)).norm());
  std::vector<DensePoint> points;
  for (std::size_t i = 0; i < slave.nodes.size(); ++i) {
    const Vector3 x0 = path.start.row(slave.nodes[i]).transpose(),
                  x1 = path.end.row(slave.nodes[i]).transpose();
    const bool touches = memory.face[i] >= 0;
    const double gap_0 = wall.distance(x0);
    // What touches is held along the normal of the start
    const Vector3 normal = wall.normal(touches ? x0 : x1);
    const double gap_1 = touches ? gap_0 + normal.dot(x1 - x0) : wall.distance(x1);
    if (gap_1 > dense_reach(slave.size, way, initial)) continue;
    double& offset = memory.offset[i];
    if (initial || (!touches && gap_0 < 0)) offset = std::min(0.0, gap_0);
    DensePoint point;
    point.frame = dense_frame(normal);
    point.gap = gap_1 - offset;
    point.start_gap = gap_0 - offset;
    point.slot = static_cast<Index>(i);
    point.face = 0;
    point.terms = {{slave.body, slave.nodes[i], 1}};
    points.push_back(point);
  }
  return points;
}

void dense_remember(const DenseSurface& slave, const std::vector<DensePoint>& points,
                    const std::vector<double>& end_gap, const std::vector<double>& p_n,
                    double master_size, DenseMemory& memory) {
  start(slave, memory);
  std::fill(memory.face.begin(), memory.face.end(), -1);
  for (auto& faces : memory.touched) faces.clear();
  if (points.empty()) {  // apart
    std::fill(memory.known_face.begin(), memory.known_face.end(), -1);
    std::fill(memory.offset.begin(), memory.offset.end(), 0.0);
    memory.stretch.setZero();
    return;
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto slot = static_cast<std::size_t>(points[k].slot);
    const bool touches = p_n[k] > 0 || end_gap[k] < 1e-6 * master_size;
    if (memory.face[slot] < 0 && touches)
      memory.face[slot] = memory.known_face[slot] = points[k].face;
    if (touches) memory.touched[slot].push_back(points[k].face);
    const bool is_first = k == 0 || points[k - 1].slot != points[k].slot;
    // What has opened of an overlap stays open
    double& offset = memory.offset[slot];
    if (is_first && offset < 0) offset = std::min(0.0, offset + std::max(0.0, end_gap[k]));
  }
}

}  // namespace cbr::test

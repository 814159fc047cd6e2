// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of components, and links between those of instances.
#include <cmath>

#include "common/base/error.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

const std::vector<std::pair<std::string, std::size_t>> motions{{"x", 0},  {"y", 1},  {"z", 2},
                                                               {"rx", 3}, {"ry", 4}, {"rz", 5}};

std::array<bool, 6> parse_motions(const SceneNode& node) {
  std::array<bool, 6> fix{};
  for (const auto& item : node.list_or_one()) {
    const auto motion = item.one_of<std::size_t>(motions);
    if (fix[motion]) item.fail("'" + item.text() + "' is listed twice: remove one");
    fix[motion] = true;
  }
  if (fix == std::array<bool, 6>{}) node.fail("is empty, expected some of x, y, z, rx, ry, rz");
  return fix;
}

// [x axis, y axis]: of any length, at right angles.
Matrix3 parse_link_axes(const SceneNode& node) {
  const auto vectors = node.list();
  if (vectors.size() != 2)
    node.fail("has " + std::to_string(vectors.size()) +
              " vectors, expected two: [[x, y, z], [x, y, z]]");
  const Vector3 x = vectors[0].vector3(), y = vectors[1].vector3();
  if (!(x.norm() > 0) || !(y.norm() > 0) || std::abs(x.normalized().dot(y.normalized())) > 1e-9)
    node.fail("are not at right angles, or zero");
  const Vector3 a = x.normalized(), b = (y - a.dot(y) * a).normalized();
  Matrix3 axes;
  axes.row(0) = a.transpose();
  axes.row(1) = b.transpose();
  axes.row(2) << a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0];
  return axes;
}

// Positive definite but for rows of zeros: the pivots of its elimination are above 0.
bool is_definite_where_not_zero(Matrix A) {
  constexpr double singular = 1e-12;
  const Vector diagonal = A.diagonal();
  for (Index i = 0; i < A.rows(); ++i) {
    if (diagonal[i] == 0 && A.row(i).isZero(0)) continue;
    if (!(A(i, i) > singular * diagonal[i])) return false;
    for (Index j = i + 1; j < A.rows(); ++j) A.row(j) -= A(j, i) / A(i, i) * A.row(i);
  }
  return true;
}

void require_definite(const SceneNode& node, const Matrix& A) {
  if (!A.isApprox(A.transpose(), 1e-9)) node.fail("is not symmetric");
  if (!is_definite_where_not_zero(A))
    node.fail(
        "is not positive definite, expected a matrix that resists every motion on whose diagonal "
        "it is not 0");
}

// Six numbers, of x, y, z, rx, ry, rz, or six rows of six.
Matrix6 parse_six(const SceneNode& node) {
  const auto rows = node.list();
  if (rows.size() != 6)
    node.fail("has " + std::to_string(rows.size()) +
              " entries, expected six numbers, or six rows of six numbers");
  Matrix6 A = Matrix6::Zero();
  for (Index i = 0; i < 6; ++i) {
    const SceneNode& row = rows[static_cast<std::size_t>(i)];
    if (!row.is_list()) {
      A(i, i) = row.not_negative();
      continue;
    }
    const std::vector<double> values = row.numbers();
    if (values.size() != 6)
      row.fail("has " + std::to_string(values.size()) + " numbers, expected six");
    for (Index j = 0; j < 6; ++j) A(i, j) = values[static_cast<std::size_t>(j)];
  }
  require_definite(node, A);
  if (A.isZero(0)) node.fail("is zero: leave it out");
  return 0.5 * (A + A.transpose());
}

// [xx, yy, zz], or [xx, yy, zz, xy, yz, xz].
Matrix3 parse_inertia(const SceneNode& node) {
  const std::vector<double> v = node.numbers();
  if (v.size() != 3 && v.size() != 6)
    node.fail("has " + std::to_string(v.size()) +
              " numbers, expected three: [xx, yy, zz], or six: [xx, yy, zz, xy, yz, xz]");
  Matrix3 inertia = Vector3(v[0], v[1], v[2]).asDiagonal();
  if (v.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = v[3];
    inertia(1, 2) = inertia(2, 1) = v[4];
    inertia(0, 2) = inertia(2, 0) = v[5];
  }
  require_definite(node, inertia);
  return inertia;
}

// A motion is held or sprung, not both. With springs nothing is held unless it is named.
void parse_springs(const SceneMap& map, LinkOptions& link) {
  const SceneNode *stiffness = map.find("stiffness"), *damping = map.find("damping"),
                  *fix = map.find("fix");
  if (stiffness != nullptr) link.stiffness = parse_six(*stiffness);
  if (damping != nullptr) link.damping = parse_six(*damping);
  if (stiffness == nullptr && damping == nullptr) return;
  if (fix == nullptr) link.fix.fill(false);
  for (const auto& [word, m] : motions)
    if (link.fix[m] && link.is_sprung(m))
      fix->fail("holds " + word + ", which has a spring or a dashpot too: give it one of the two");
}

void refuse_twice(const SceneNode& node, const LinkOptions& link, const Scene& scene) {
  for (const LinkOptions& other : scene.links)
    if (other.first.text() == link.first.text() && other.second.text() == link.second.text())
      node.fail("links '" + link.first.text() + "' and '" + link.second.text() + "' as line " +
                std::to_string(other.source.line) + " does: put both into one entry");
}

SurfaceName parse_point_name(const SceneNode& node, const Scene& scene, const SceneNames& names) {
  const SurfaceName name = parse_surface_name(node, scene, names);
  if (point_of(scene, name.instance, name.surface) != nullptr) return name;
  node.fail("found '" + name.text() + "', which is no point: give it under components.NAME.points");
}

}  // namespace

void parse_points(const SceneNode& node, Component& component) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    require_plain_name(value, "a point", name);
    const SceneMap of = value.map({"surface", "at", "coupling", "mass", "inertia"});
    Component::Point point;
    point.source = value.source();
    point.nodes = of.at("surface").text();
    if (const auto* at = of.find("at")) point.at = at->vector3();
    if (const auto* coupling = of.find("coupling"))
      point.rigid = coupling->one_of<bool>({{"average", false}, {"rigid", true}});
    if (const auto* mass = of.find("mass")) point.mass = mass->positive();
    if (const auto* inertia = of.find("inertia")) point.inertia = parse_inertia(*inertia);
    component.points.emplace(name, point);
  }
}

void parse_links(const SceneNode& node, const SceneNames& names, Scene& scene) {
  node.for_each_item([&](const SceneNode& item) {
    const SceneMap map = item.map({"between", "fix", "axes", "stiffness", "damping"});
    LinkOptions link;
    link.source = item.source();
    const auto ends = map.at("between").list();
    if (ends.size() != 2)
      map.at("between").fail("has " + std::to_string(ends.size()) +
                             " ends, expected two: [a.POINT, b.POINT], or ground");
    link.first = parse_point_name(ends[0], scene, names);
    if (ends[1].text() == "ground") {
      link.second = {"", "ground", ends[1].source()};
    } else {
      link.second = parse_point_name(ends[1], scene, names);
    }
    if (link.first.text() == link.second.text())
      map.at("between").fail("'" + link.first.text() + "' cannot be linked to itself");
    if (const auto* fix = map.find("fix")) link.fix = parse_motions(*fix);
    if (const auto* axes = map.find("axes")) link.axes = parse_link_axes(*axes);
    parse_springs(map, link);
    refuse_twice(map.at("between"), link, scene);
    scene.links.push_back(link);
  });
}

}  // namespace cbr

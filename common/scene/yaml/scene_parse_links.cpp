// SPDX-License-Identifier: GPL-3.0-or-later
// Reference points of components, and links between those of instances.
#include <algorithm>
#include <cmath>
#include <functional>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/scene/yaml/scene_parse.hpp"

namespace cbr {
namespace {

// `line`, or [x axis, y axis]: of any length, at right angles.
void read_link_axes(const SceneNode& node, const SceneReading&, LinkOptions& link) {
  if (!node.is_list()) {
    if (node.text() != "line")
      node.fail("found '" + node.text() + "', expected line, or [[x, y, z], [x, y, z]]");
    link.follows_line = true;
    return;
  }
  const auto vectors = node.list();
  if (vectors.size() != 2)
    node.fail("has " + std::to_string(vectors.size()) +
              " vectors, expected two: [[x, y, z], [x, y, z]]");
  const Vector3 x = vectors[0].vector3(), y = vectors[1].vector3();
  if (!(x.norm() > 0) || !(y.norm() > 0) || std::abs(x.normalized().dot(y.normalized())) > 1e-9)
    node.fail("are not at right angles, or zero");
  const Vector3 a = x.normalized(), b = (y - a.dot(y) * a).normalized();
  link.axes.row(0) = a.transpose();
  link.axes.row(1) = b.transpose();
  link.axes.row(2) << a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
      a[0] * b[1] - a[1] * b[0];
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
void read_six(const SceneNode& node, const SceneReading&, Matrix6& A) {
  const auto rows = node.list();
  if (rows.size() != 6)
    node.fail("has " + std::to_string(rows.size()) +
              " entries, expected six numbers, or six rows of six numbers");
  for (Index i = 0; i < 6; ++i) {
    const SceneNode& row = rows[i];
    if (!row.is_list()) {
      A(i, i) = row.number(not_negative);
      continue;
    }
    const std::vector<double> values = row.numbers();
    if (values.size() != 6)
      row.fail("has " + std::to_string(values.size()) + " numbers, expected six");
    for (Index j = 0; j < 6; ++j) A(i, j) = values[j];
  }
  require_definite(node, A);
  if (A.isZero(0)) node.fail("is zero: leave it out");
  A = (0.5 * (A + A.transpose())).eval();
}

// [xx, yy, zz], or [xx, yy, zz, xy, yz, xz].
void read_inertia(const SceneNode& node, const SceneReading&, Matrix3& inertia) {
  const std::vector<double> v = node.numbers();
  if (v.size() != 3 && v.size() != 6)
    node.fail("has " + std::to_string(v.size()) +
              " numbers, expected three: [xx, yy, zz], or six: [xx, yy, zz, xy, yz, xz]");
  inertia = Vector3(v[0], v[1], v[2]).asDiagonal();
  if (v.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = v[3];
    inertia(1, 2) = inertia(2, 1) = v[4];
    inertia(0, 2) = inertia(2, 0) = v[5];
  }
  require_definite(node, inertia);
}

// A value for some motions: {x: ..., rz: ...}.
template <typename Take>
void read_by_motion(const SceneNode& node, const Take& take) {
  const SceneMap map = node.map(std::vector<std::string>(motion_names, motion_names + 6));
  for (std::size_t m = 0; m < 6; ++m)
    if (const SceneNode* value = map.find(motion_names[m])) take(m, *value);
}

void read_forces(const SceneNode& node, const SceneReading&, std::array<ForceTable, 6>& force) {
  read_by_motion(node,
                 [&](std::size_t m, const SceneNode& value) { read_force_table(value, force[m]); });
}

void read_frictions(const SceneNode& node, const SceneReading&, std::array<double, 6>& friction) {
  read_by_motion(
      node, [&](std::size_t m, const SceneNode& value) { friction[m] = value.number(positive); });
}

// Values as {x: ..., rz: ...}; empty texts are left out.
template <typename Text>
std::string by_motion_text(const Text& text) {
  std::string all;
  for (std::size_t m = 0; m < 6; ++m)
    if (const std::string one = text(m); !one.empty())
      all += (all.empty() ? "{" : ", ") + motion_names[m] + ": " + one;
  return all.empty() ? all : all + "}";
}

std::string forces_text(const std::array<ForceTable, 6>& force) {
  return by_motion_text([&](std::size_t m) { return force_table_text(force[m]); });
}

std::string frictions_text(const std::array<double, 6>& friction) {
  return by_motion_text(
      [&](std::size_t m) { return friction[m] > 0 ? number_text(friction[m]) : std::string(); });
}

// Prescribed motions are among the fixed ones. A motion of zeros is none.
void take_motion(const SceneMap& map, const SceneReading& reading, LinkOptions& link) {
  GivenMotion given = parse_motion(map, reading);
  for (std::size_t m = 0; m < 6; ++m) {
    const bool turns = m >= 3;
    const Vector3& value = turns ? given.turn : given.value;
    if (value[static_cast<Index>(m % 3)] == 0 || link.fix[m]) continue;
    map.at(turns ? word_of(turn_words, given.motion) : word_of(motion_words, given.motion))
        .fail("prescribes " + motion_names[m] +
              ", which 'fix' leaves free: add it to 'fix', or "
              "give 0 there");
  }
  if (given.value.isZero(0) && given.turn.isZero(0)) return;
  link.motion = given.motion;
  link.value = given.value;
  link.turn = given.turn;
  link.history = std::move(given.history);
}

// A motion is held or sprung, not both. With springs nothing is held unless it is named.
void check_springs(const SceneMap& map, LinkOptions& link) {
  const auto is_given = [&](const char* key) { return map.find(key) != nullptr; };
  if (!is_given("stiffness") && !is_given("damping") && !is_given("force") && !is_given("friction"))
    return;
  const SceneNode* fix = map.find("fix");
  if (fix == nullptr) link.fix.fill(false);
  for (std::size_t m = 0; m < 6; ++m)
    if (link.fix[m] && link.is_sprung(m))
      fix->fail("holds " + motion_names[m] +
                ", which has a spring, a dashpot or friction too: give it one of the two");
}

// A line has one motion, and two ends.
void check_line(const SceneMap& map, LinkOptions& link) {
  if (link.follows_line && map.find("fix") == nullptr) {
    link.fix.fill(false);
    link.fix[0] = !link.is_sprung(0);
  }
  const bool on_ground = link.second.is_wall();
  if (link.ground && !(link.follows_line && on_ground))
    map.at("ground").fail("is for `axes: line` and the second end `ground`: leave it out");
  if (!link.follows_line) return;
  for (std::size_t m = 1; m < 6; ++m)
    if (link.fix[m] || link.is_sprung(m))
      map.at("axes").fail("line has the motion x alone, found " + motion_names[m] +
                          ": leave it out, or link other points by it");
  if (on_ground && !link.ground)
    map.at("axes").fail("line needs the place of the ground's end: ground: [x, y, z]");
}

void refuse_twice(const SceneNode& node, const LinkOptions& link, const Scene& scene) {
  for (const LinkOptions& other : scene.links)
    if (other.first.text() == link.first.text() && other.second.text() == link.second.text())
      node.fail("links '" + link.first.text() + "' and '" + link.second.text() + "' as line " +
                std::to_string(other.source.line) + " does: put both into one entry");
}

SurfaceName parse_point_name(const SceneNode& node, const SceneReading& reading) {
  const SurfaceName name = parse_surface_name(node, reading);
  if (point_of(reading.scene, name.instance, name.surface) != nullptr) return name;
  node.fail("found '" + name.text() + "', which is no point: give it under components.NAME.points");
}

void read_ends(const SceneNode& node, const SceneReading& reading, LinkOptions& link) {
  const auto ends = node.list();
  if (ends.size() != 2)
    node.fail("has " + std::to_string(ends.size()) +
              " ends, expected two: [a.POINT, b.POINT], or ground");
  link.first = parse_point_name(ends[0], reading);
  const bool is_ground = ends[1].text() == "ground";
  link.second =
      is_ground ? SurfaceName{"", "ground", ends[1].source()} : parse_point_name(ends[1], reading);
  if (link.first.text() == link.second.text())
    node.fail("'" + link.first.text() + "' cannot be linked to itself");
}

std::string six_text(const Matrix6& A) {
  std::vector<std::string> rows;
  for (Index i = 0; i < 6; ++i)
    rows.push_back(yaml_numbers(std::vector<double>(A.row(i).begin(), A.row(i).end())));
  return A.isZero(0) ? "" : yaml_list(rows);
}

std::string inertia_text(const Matrix3& J) {
  if (J.isZero(0)) return "";
  return yaml_numbers({J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(1, 2), J(0, 2)});
}

}  // namespace

std::vector<SceneKey> scene_keys(Component::Point& p) {
  return {{"surface", Text{p.nodes}, true, true},
          {"at", ThreeNumbers{p.at}},
          {"coupling", OneWord{p.rigid, coupling_words}, p.rigid},
          {"mass", Number{p.mass, positive}, p.mass > 0},
          {"inertia", Own{p.inertia, read_inertia, inertia_text}}};
}

void read_points(const SceneNode& node, const SceneReading& reading, Component& component) {
  const SceneMap map = node.map_of_any();
  for (const auto& [name, value] : map.entries()) {
    require_plain_name(value, "a point", name);
    Component::Point& point = component.points[name] = {};
    point.source = value.source();
    read_keys(value, scene_keys(point), reading);
  }
}

std::vector<SceneKey> scene_keys(LinkOptions& link) {
  const auto ends = [](const LinkOptions& of) {
    return yaml_words({of.first.text(), of.second.text()});
  };
  const auto axes = [](const LinkOptions& of) {
    return of.follows_line ? "line" : of.axes.isIdentity(0) ? "" : yaml_rows(of.axes);
  };
  const bool fixes_any = std::any_of(link.fix.begin(), link.fix.end(), std::identity());
  std::vector<SceneKey> keys{{"between", Own{link, read_ends, ends}, true, true},
                             {"fix", Own{link.fix, read_motions, motions_text}, fixes_any},
                             {"stiffness", Own{link.stiffness, read_six, six_text}},
                             {"damping", Own{link.damping, read_six, six_text}},
                             {"force", Own{link.force, read_forces, forces_text}},
                             {"friction", Own{link.friction, read_frictions, frictions_text}},
                             {"axes", Own{link, read_link_axes, axes}},
                             {"ground", ThreeNumbers{link.ground}}};
  const bool moves = link.value != Vector3::Zero(), turns = link.turn != Vector3::Zero();
  add_motion_keys(keys, motion_words, moves ? link.motion : SupportMotion::none, link.value);
  add_motion_keys(keys, turn_words, turns ? link.motion : SupportMotion::none, link.turn);
  keys.push_back({"history", Own{link.history, history_text}});
  return keys;
}

void parse_links(const SceneNode& node, SceneReading& reading) {
  node.for_each_item([&](const SceneNode& item) {
    LinkOptions link;
    link.source = item.source();
    const SceneMap map = read_keys(item, scene_keys(link), reading);
    check_springs(map, link);
    check_line(map, link);
    take_motion(map, reading, link);
    refuse_twice(map.at("between"), link, reading.scene);
    reading.scene.links.push_back(link);
  });
}

}  // namespace cbr

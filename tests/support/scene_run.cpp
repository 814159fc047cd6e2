// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/scene_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>

#include "reducer/command.hpp"

namespace cbr::test {
namespace {

// Exodus: sides 1 to 4 go round the element's edges from node 1, 5 is below, 6 above.
struct Face {
  const char* name;
  int axis;
  bool upper;
  int side;
};
constexpr Face faces[] = {{"x_min", 0, false, 4}, {"x_max", 0, true, 2},  {"y_min", 1, false, 1},
                          {"y_max", 1, true, 3},  {"z_min", 2, false, 5}, {"z_max", 2, true, 6}};

template <class T>
std::vector<T> permuted(const std::vector<T>& values, const std::vector<Index>& old_of_new) {
  std::vector<T> result;
  for (const Index i : old_of_new) result.push_back(values[i]);
  return result;
}

// A quarter turn of a hex about its third axis: node a of the turned one is node (a + 1) % 4 of the
// old; sides follow.
void turn(Block& block, Index element, std::vector<Sideset>& sidesets, Index block_index) {
  Eigen::Matrix<Index, 1, 8> old = block.connectivity.row(element);
  for (int a = 0; a < 8; ++a) block.connectivity(element, a) = old[4 * (a / 4) + (a + 1) % 4];
  for (Sideset& set : sidesets)
    for (Side& side : set.sides)
      if (side.block == block_index && side.element == element && side.side <= 4)
        side.side = 1 + (side.side + 2) % 4;
}

Report quiet(const std::string& program) { return Report(program, Verbosity::quiet); }

template <class Named>
std::size_t index_of(const std::vector<Named>& list, const std::string& name) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].name == name) return i;
  throw std::out_of_range("the scene has no " + name);
}

}  // namespace

Mesh block_mesh(const BlockShape& shape) {
  const auto& n = shape.n;
  Mesh mesh;
  mesh.coordinates.resize((n[0] + 1) * (n[1] + 1) * (n[2] + 1), 3);
  const auto node = [&](Index i, Index j, Index k) {
    return i + (n[0] + 1) * (j + (n[1] + 1) * k);
  };
  Block block;
  block.name = "block";
  block.id = 1;
  block.type = ElementType::hex8;
  block.connectivity.resize(n[0] * n[1] * n[2], 8);
  for (const Face& face : faces)
    mesh.sidesets.push_back({face.name, static_cast<Index>(mesh.sidesets.size()) + 1, {}});
  Index e = 0;
  for (Index k = 0; k <= n[2]; ++k) {
    for (Index j = 0; j <= n[1]; ++j) {
      for (Index i = 0; i <= n[0]; ++i) {
        const Vector3 x = shape.size.cwiseProduct(
            Vector3(double(i) / double(n[0]), double(j) / double(n[1]), double(k) / double(n[2])));
        mesh.coordinates.row(node(i, j, k)) = (shape.map ? shape.map(x) : x).transpose();
        mesh.node_ids.push_back(node(i, j, k) + 1);
        if (i == n[0] || j == n[1] || k == n[2]) continue;
        block.connectivity.row(e) << node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k),
            node(i, j + 1, k), node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1),
            node(i, j + 1, k + 1);
        block.element_ids.push_back(e + 1);
        const Index at[] = {i, j, k};
        for (std::size_t f = 0; f < std::size(faces); ++f)
          if (at[faces[f].axis] == (faces[f].upper ? n[faces[f].axis] - 1 : 0))
            mesh.sidesets[f].sides.push_back({0, e, faces[f].side});
        ++e;
      }
    }
  }
  mesh.blocks.push_back(std::move(block));
  return mesh;
}

Mesh renumbered(const Mesh& mesh, unsigned seed) {
  std::mt19937 random(seed);
  Mesh result = mesh;
  const std::vector<Index> nodes = random_order(mesh.coordinates.rows(), random),
                           new_node = inverse(nodes);
  for (Index i = 0; i < mesh.coordinates.rows(); ++i) {
    result.coordinates.row(i) = mesh.coordinates.row(nodes[i]);
    result.node_ids[i] = 3 * i + 7;
  }
  for (Nodeset& set : result.nodesets) {
    for (Index& node : set.nodes) node = new_node[node];
    std::sort(set.nodes.begin(), set.nodes.end());
  }
  Index next_id = 11;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    Block& block = result.blocks[b];
    const std::vector<Index> elements = random_order(block.connectivity.rows(), random),
                             new_element = inverse(elements);
    for (Index e = 0; e < block.connectivity.rows(); ++e) {
      for (int a = 0; a < 8; ++a) {
        const Index old = mesh.blocks[b].connectivity(elements[e], a);
        block.connectivity(e, a) = new_node[old];
      }
      block.element_ids[e] = next_id += 2;
    }
    for (Sideset& set : result.sidesets)
      for (Side& side : set.sides)
        if (side.block == static_cast<Index>(b)) side.element = new_element[side.element];
    for (Index e = 0; e < block.connectivity.rows(); ++e)
      for (auto turns = random() % 4; turns > 0; --turns)
        turn(block, e, result.sidesets, static_cast<Index>(b));
  }
  for (Sideset& set : result.sidesets)
    set.sides = permuted(set.sides, random_order(static_cast<Index>(set.sides.size()), random));
  return result;
}

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return buffer;
}

std::string text(const Vector3& value) {
  return "[" + text(value[0]) + ", " + text(value[1]) + ", " + text(value[2]) + "]";
}

const RunResult::OfMonitor& Ran::monitor(const std::string& surface) const {
  return result.monitors[index_of(built.simulation.monitors, surface)];
}
const RunResult::OfBody& Ran::body(const std::string& instance) const {
  return result.bodies[index_of(built.instances, instance)];
}
double Ran::mass(const std::string& instance) const {
  return built.instances[index_of(built.instances, instance)].mass;
}

Ran SceneFolder::prepare(const std::string& yaml) const {
  const std::filesystem::path file = folder_ / "scene.yaml";
  write_bytes(file, yaml);
  ReduceCommand reduce;
  reduce.input = file.string();
  reduce.diagonal_limit = diagonal_limit;
  Report reduction = quiet("cbr-reduce"), report = quiet("cbr-dyn");
  run_reduce(reduce, nullptr, reduction);
  Ran ran;
  ran.scene = read_scene(file.string());
  ran.built = build(ran.scene, report, {diagonal_limit});
  return ran;
}

Ran SceneFolder::run(const std::string& yaml, const RunOptions& options) const {
  Ran ran = prepare(yaml);
  ran.result = cbr::run(ran.built.simulation, options);
  return ran;
}

Vector3 total(const RunResult& result, Series3 RunResult::OfBody::*series, std::size_t k) {
  Vector3 sum = Vector3::Zero();
  for (const RunResult::OfBody& body : result.bodies)
    if (!(body.*series).values.empty()) sum += at(body.*series, k);
  return sum;
}

double largest_change(const RunResult& result, Series3 RunResult::OfBody::*series) {
  const Vector3 start = total(result, series, 0);
  double most = 0;
  for (std::size_t k = 0; k < result.time.size(); ++k)
    most = std::max(most, (total(result, series, k) - start).norm());
  return most;
}

Vector3 integral(const RunResult& result, const Series3& series) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 1; i < result.time.size(); ++i)
    sum += (result.time[i] - result.time[i - 1]) * at(series, i);
  return sum;
}

double rms(const RunResult& result, const Series3& series,
           const std::function<Vector3(double)>& expected) {
  double sum = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i)
    sum += (at(series, i) - expected(result.time[i])).squaredNorm();
  return std::sqrt(sum / static_cast<double>(result.time.size()));
}

double energy_residual(const RunResult& result) {
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < result.time.size(); ++i) {
    const double work = result.work_external[i] + result.work_contact[i] + result.work_friction[i] +
                        result.work_damping[i] + result.work_numerical[i];
    worst = std::max(worst, std::abs(result.total[i] - result.total[0] - work));
    scale = std::max({scale, result.total[i], std::abs(work)});
  }
  return scale > 0 ? worst / scale : 0;
}

double observed_order(const std::vector<double>& h, const std::vector<double>& error) {
  const double n = static_cast<double>(h.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    const double a = std::log(h[i]), b = std::log(error[i]);
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

std::vector<Index> random_order(Index n, std::mt19937& random) {
  std::vector<Index> order = first_numbers(n);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

std::vector<Index> inverse(const std::vector<Index>& order) {
  std::vector<Index> result(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) result[order[i]] = static_cast<Index>(i);
  return result;
}

}  // namespace cbr::test

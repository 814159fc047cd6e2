// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/scene_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "reducer/command.hpp"

namespace cbr::test {
namespace {

Report quiet(const std::string& program) { return Report(program, Verbosity::quiet); }

template <class Named>
std::size_t index_of(const std::vector<Named>& list, const std::string& name) {
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].name == name) return i;
  throw std::out_of_range("the scene has no " + name);
}

}  // namespace

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

}  // namespace cbr::test

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/bars.hpp"

namespace cbr::test {

std::string yaml(const BarScene& scene) {
  std::string materials = "materials:\n", components = "components:\n", instances = "instances:\n",
              contact, history;
  for (std::size_t i = 0; i < scene.bars.size(); ++i) {
    const Bar& b = scene.bars[i];
    const std::string name = name_of(i);
    materials += "  m" + name + ": {youngs_modulus: " + text(b.youngs_modulus) +
                 ", poissons_ratio: 0, density: " + text(b.density) + "}\n";
    const Index nodes = (b.across + 1) * (b.across + 1), all = 3 * nodes * (b.n - 1);
    components += "  c" + name + ": {mesh: " + name + ".exo, material: m" + name;
    if (!b.mesh)
      components += ", reduction: {basis: " + b.basis + ", interface: [x_min, x_max], modes: " +
                    std::to_string(b.modes < 0 ? all : b.modes) + ", pick: participation}";
    components += "}\n";
    instances += "  " + name + ": {component: c" + name +
                 ", as: " + (b.mesh ? "mesh" : "superelement") +
                 ", position: " + text(Vector3(b.start, 0, 0)) +
                 ", velocity: " + text(Vector3(b.velocity, 0, 0)) + "}\n";
    history += (i > 0 ? ", " : "") + name + ".x_min, " + name + ".x_max";
    if (i > 0)
      contact += "  - {between: [" + name_of(i - 1) + ".x_max, " + name +
                 ".x_min], enforcement: " + scene.enforcement + scene.contact + "}\n";
  }
  if (!contact.empty()) contact = "contact:\n" + contact;
  return materials + components + instances + contact + "time: {end: " + text(scene.end) +
         ", step: " + scene.step + ", integrator: " + scene.integrator +
         "}\noutput: {every: " + text(scene.every) + ", history: [" + history + "]}\n" +
         scene.extra;
}

Ran run(const BarScene& scene, const RunOptions& options) {
  SceneFolder folder;
  for (std::size_t i = 0; i < scene.bars.size(); ++i) {
    const Bar& b = scene.bars[i];
    folder.add(name_of(i) + ".exo",
               block_mesh({{b.n, b.across, b.across}, Vector3(b.length, b.width, b.width)}));
  }
  return folder.run(yaml(scene), options);
}

Waves waves(const std::vector<Bar>& bars, double dt, double end) {
  const std::size_t n = bars.size(), steps = static_cast<std::size_t>(std::lround(end / dt));
  Waves w{dt, {}, {}, {}, std::vector<std::vector<double>>(n - 1, std::vector<double>(steps, 0.0))};
  w.lower = w.upper = w.centre =
      std::vector<std::vector<double>>(n, std::vector<double>(steps + 1, 0.0));
  // what left the lower and the upper end, by time, delay steps ahead
  std::vector<std::vector<double>> up(n), down(n);
  std::vector<std::size_t> delay(n);
  std::vector<double> speed(n);  // of the centre of mass
  for (std::size_t b = 0; b < n; ++b) {
    delay[b] = static_cast<std::size_t>(std::lround(0.5 * bars[b].transit() / dt));
    up[b].assign(delay[b], 0.5 * bars[b].velocity);
    down[b] = up[b];
    speed[b] = bars[b].velocity;
  }
  for (std::size_t i = 0; i < steps; ++i) {
    std::vector<double> F(n + 1, 0.0);  // below bar b: F[b]
    for (std::size_t j = 1; j < n; ++j) {
      const double Z1 = bars[j - 1].impedance(), Z2 = bars[j].impedance();
      const double gap = bars[j].start + w.lower[j][i] - bars[j - 1].start - bars[j - 1].length -
                         w.upper[j - 1][i];
      const double closing = 2 * up[j - 1][i] - 2 * down[j][i],
                   scale = dt * std::abs(bars[0].velocity);
      if (gap < 1e-9 * scale && closing > 0) F[j] = closing * Z1 * Z2 / (Z1 + Z2);
      w.force[j - 1][i] = F[j];
    }
    for (std::size_t b = 0; b < n; ++b) {
      // sent
      const double Z = bars[b].impedance(), low = down[b][i] + F[b] / Z,
                   high = up[b][i] - F[b + 1] / Z;
      w.lower[b][i + 1] = w.lower[b][i] + dt * (down[b][i] + low);
      w.upper[b][i + 1] = w.upper[b][i] + dt * (up[b][i] + high);
      const double change = dt * (F[b] - F[b + 1]) / bars[b].mass();
      w.centre[b][i + 1] = w.centre[b][i] + dt * (speed[b] + 0.5 * change);
      speed[b] += change;
      up[b].push_back(low);
      down[b].push_back(high);
    }
  }
  return w;
}

double error_of(const RunResult& result, const Series3& positions, const std::vector<double>& u,
                double dt, double scale) {
  double sum = 0;
  for (std::size_t k = 0; k < result.time.size(); ++k) {
    const double i = std::min(result.time[k] / dt, static_cast<double>(u.size()) - 1.0000001);
    const std::size_t from = static_cast<std::size_t>(i);
    const double exact = u[from] + (i - std::floor(i)) * (u[from + 1] - u[from]);
    sum += std::pow(at(positions, k)[0] - at(positions, 0)[0] - exact, 2);
  }
  return std::sqrt(sum / static_cast<double>(result.time.size())) / scale;
}

double speed_of(const Ran& ran, std::size_t bar) {
  return at(ran.body(name_of(bar)).momentum, ran.result.time.size() - 1)[0] /
         ran.mass(name_of(bar));
}

double contact_time(const RunResult& result, const Series3& force, double threshold) {
  double first = -1, last = 0;
  for (std::size_t i = 1; i < result.time.size(); ++i) {
    if (at(force, i).norm() < threshold) continue;
    if (first < 0) first = result.time[i - 1];
    last = result.time[i];
  }
  return first < 0 ? 0 : last - first;
}

}  // namespace cbr::test

// SPDX-License-Identifier: GPL-3.0-or-later
// What a step in contact costs, against the number of contact nodes: two plates of unlike meshes (n
// x n faces against 0.8 n x 0.8 n, four layers each), pressed together over all of their facing
// sides while the wave of their impact runs to the back and returns, frictionless impulse. CSV to
// stdout, one row per model (mesh, superelement), formulation (node-face, mortar) and n: seconds a
// step by phase, medians over the later half of the steps, and after each series the exponent of
// their growth. The smallest of each series is checked against the program's own time loop. Of a
// dense response also what a step must read at least (half of the block that the bodies share, or
// of each body's, once) over the rate of a triad in the same run, as a share of what the impulses
// took. Arguments: largest number of contact nodes (of the slave side; default 2100, 10000 takes
// minutes), the same for superelements (default 1100: their interface is dense).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/base/threads.hpp"
#include "common/linalg/blas_threads.hpp"
#include "dynamics/contact/enforce/enforcement.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "tests/support/scene_run.hpp"

namespace {

using namespace std::string_literals;
using cbr::Index;
using cbr::Vector;
using cbr::Vector3;

constexpr double modulus = 2.1e11, density = 7800, side = 0.1;
constexpr Index n_layers = 4, n_steps = 16;  // the wave is back after 2 n_layers / 0.4 = 20 steps

class Clock {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Seconds of one step.
struct Phases {
  double bodies = 0, search = 0, response = 0, contact = 0;
  double total() const { return bodies + search + response + contact; }
};

constexpr double Phases::*phases_of_a_step[] = {&Phases::bodies, &Phases::search, &Phases::response,
                                                &Phases::contact};

Phases medians(const std::vector<Phases>& steps) {
  Phases result;
  for (double Phases::*phase : phases_of_a_step) {
    std::vector<double> seconds;
    for (const Phases& of : steps) seconds.push_back(of.*phase);
    std::nth_element(seconds.begin(),
                     seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2),
                     seconds.end());
    result.*phase = seconds[seconds.size() / 2];
  }
  return result;
}

struct Measured {
  Index nodes = 0, active = 0;
  Phases median;
  Index timed = 0, formed = 0;  // steps that count; times that W was formed anew in them
  // of dense responses: read by products in a step, and what one step must read
  double bytes = 0, least_bytes = 0;
  double residual = 0;
};

// The program's own steps, with a clock between their phases: bodies here, the rest by
// contact_step().
class Stepper {
 public:
  explicit Stepper(cbr::Simulation& sim) : sim_(sim), state_(cbr::start_contact(sim)) {
    outcome_.start(sim);
  }

  Measured run() {
    Measured result;
    result.nodes = static_cast<Index>(sim_.pairs.at(0).slave->nodes.size());
    const Index steps = sim_.plan.n_steps();
    std::vector<Phases> timed;
    for (Index step = 0; step < steps; ++step) {
      const Phases phases = advance(step);
      const cbr::ImpulseMemory& memory = state_.islands[0];
      if (step < steps / 2) {
        result.formed = -memory.n_formed;
        result.bytes = -memory.moves.bytes();
        continue;
      }
      timed.push_back(phases);
      result.residual = std::max(result.residual, sim_.pairs[0].seen().recent_residual);
    }
    const cbr::ImpulseMemory& memory = state_.islands[0];
    result.timed = static_cast<Index>(timed.size());
    result.formed += memory.n_formed;
    result.bytes = (result.bytes + memory.moves.bytes()) / static_cast<double>(result.timed);
    result.least_bytes = least_bytes();
    result.median = medians(timed);
    result.active = outcome_.active[0];
    return result;
  }

 private:
  Phases advance(Index step) {
    const double h = sim_.plan.step_length(step);
    Phases phases;
    Clock clock;
    for (auto& body : sim_.bodies) body->predict(sim_.plan.time(step), h);
    for (std::size_t b = 0; b < state_.bodies.size(); ++b) {
      const auto& nodes = sim_.contact_nodes[b];
      if (step == 0) sim_.bodies[nodes.body]->positions(nodes.set, state_.bodies[b].start);
      if (step > 0) state_.bodies[b].start.swap(state_.bodies[b].end);
      sim_.bodies[nodes.body]->predicted_positions(nodes.set, state_.bodies[b].end);
      sweep(state_.bodies[b]);
    }
    phases.bodies += clock.lap();
    cbr::StepSeconds seconds;
    cbr::contact_step(sim_, {0}, h, step == 0, state_, outcome_, seconds);
    phases.search = seconds.search;
    phases.response = seconds.response;
    phases.contact = seconds.contact;
    clock.lap();
    for (auto& body : sim_.bodies) body->accept();
    phases.bodies += clock.lap();
    return phases;
  }

  // One triangle of each block, of one that is shared once.
  double least_bytes() const {
    double bytes = 0;
    for (std::size_t b = 0; b < state_.bodies.size(); ++b) {
      const auto& block = state_.bodies[b].response.block;
      const bool counted = b > 0 && block == state_.bodies[b - 1].response.block;
      if (block && !counted) bytes += 4.0 * static_cast<double>(block->size());
    }
    return bytes;
  }

  cbr::Simulation& sim_;
  cbr::ContactState state_;
  cbr::ContactOutcome outcome_;
};

// Bytes a second of a = b + s c over arrays that no cache holds (McCalpin 1995), both threads of
// the machine or as many as there are.
double triad() {
  const Index n = 1 << 23;
  const Vector b = Vector::Constant(n, 1), c = Vector::Constant(n, 2);
  Vector a = b;
  double best = 0;
  for (int run = 0; run < 4; ++run) {
    Clock clock;
    const int threads = cbr::n_threads();
    cbr::run_threads(threads, [&](int t) {
      const Index first = n * t / threads, rows = n * (t + 1) / threads - first;
      a.segment(first, rows) = b.segment(first, rows) + 0.5 * c.segment(first, rows);
    });
    best = std::max(best, 24.0 * static_cast<double>(n) / clock.lap());
  }
  return best;
}

cbr::Mesh plate(Index n, double thickness) {
  cbr::test::BlockShape shape;
  shape.n = {n_layers, n, n};
  shape.size = Vector3(thickness, side, side);
  return cbr::test::block_mesh(shape);
}

std::string scene(const std::string& as, const std::string& formulation, double thickness, double h,
                  double speed) {
  const std::string t = cbr::test::text(thickness), end = cbr::test::text(n_steps * h),
                    v = cbr::test::text(speed);
  const auto component = [&](const std::string& name, const std::string& face) {
    return "  " + name + ": {mesh: " + name + ".exo, material: steel, reduction: {interface: [" +
           face + "], modes: 10}}\n";
  };
  return "materials:\n  steel: {youngs_modulus: " + cbr::test::text(modulus) +
         ", poissons_ratio: 0.3, density: " + cbr::test::text(density) + "}\ncomponents:\n" +
         component("fine", "x_max") + component("coarse", "x_min") +
         "instances:\n  left: {component: fine, as: " + as + ", velocity: [" + v +
         ", 0, 0]}\n  right: {component: coarse, as: " + as + ", position: [" + t +
         ", 0, 0], velocity: [-" + v + ", 0, 0]}\n" +
         "contact:\n  - {between: [left.x_max, right.x_min], enforcement: impulse, formulation: " +
         formulation + "}\ntime: {end: " + end + ", step: " + cbr::test::text(h) +
         "}\noutput: {every: " + end + "}\n";
}

void print(const std::string& as, const std::string& formulation, const Measured& m,
           double bandwidth) {
  const double timed = static_cast<double>(m.timed);
  std::printf("%s,%s,%td,%td,%.3e,%.3e,%.3e,%.3e,%.3e,%.2f,%.3e,%.2f,%.1e\n", as.c_str(),
              formulation.c_str(), m.nodes, m.active, m.median.bodies, m.median.search,
              m.median.response, m.median.contact, m.median.total(),
              static_cast<double>(m.formed) / timed, m.bytes,
              m.least_bytes / bandwidth / m.median.contact, m.residual);
  std::fflush(stdout);
}

// Exponents of seconds ~ nodes^a, by least squares over a series from `first` on.
void print_growth(const std::string& as, const std::string& formulation,
                  const std::vector<Measured>& series, std::size_t first) {
  std::vector<double> n;
  std::vector<std::vector<double>> seconds(5);
  for (std::size_t i = first; i < series.size(); ++i) {
    const Phases& of = series[i].median;
    n.push_back(static_cast<double>(series[i].nodes));
    const double values[] = {of.bodies, of.search, of.response, of.contact, of.total()};
    for (std::size_t phase = 0; phase < 5; ++phase) seconds[phase].push_back(values[phase]);
  }
  if (n.size() < 2) return;
  std::printf("growth,%s %s from %.0f nodes", as.c_str(), formulation.c_str(), n.front());
  const char* names[] = {"bodies", "search", "response", "contact", "total"};
  for (std::size_t phase = 0; phase < 5; ++phase)
    std::printf(",%s %.2f", names[phase], cbr::test::observed_order(n, seconds[phase]));
  std::printf("\n");
}

// The same scene through the program's own loop has the same motion: what was timed is what runs.
bool same_motion(const cbr::Simulation& timed, const cbr::test::SceneFolder& folder,
                 const std::string& yaml) {
  const cbr::test::Ran ran = folder.run(yaml);
  double worst = 0;
  for (std::size_t b = 0; b < timed.bodies.size(); ++b) {
    const cbr::BodyState a = timed.bodies[b]->state(),
                         other = ran.built.simulation.bodies[b]->state();
    worst = std::max(worst, (a.momentum - other.momentum).norm() / other.momentum.norm());
    for (double cbr::BodyState::*energy :
         {&cbr::BodyState::kinetic_energy, &cbr::BodyState::strain_energy})
      worst = std::max(worst, std::abs(a.*energy - other.*energy) / other.*energy);
  }
  return worst <= 1e-9;
}

}  // namespace

int main(int argc, char** argv) {
  cbr::restart_with_better_kernels(argv);
  const Index largest = argc > 1 ? std::atol(argv[1]) : 2100,
              largest_reduced = argc > 2 ? std::atol(argv[2]) : 1100;
  const double wave = std::sqrt(modulus * 1.35 / density);  // longitudinal, nu = 0.3
  const double bandwidth = triad();
  bool same = true;
  std::printf(
      "model,formulation,slave nodes,active,bodies s,search s,response s,contact s,step s,W "
      "formed,bytes read,share of "
      "bandwidth,residual\n");
  for (const std::string as : {"mesh", "superelement"}) {
    for (const std::string formulation : {"node-face", "mortar"}) {
      std::vector<Measured> series;
      for (const Index n : {9, 16, 25, 31, 44, 70, 99}) {
        if ((n + 1) * (n + 1) > (as == "mesh" ? largest : largest_reduced)) break;
        const double edge = side / static_cast<double>(n), thickness = n_layers * edge,
                     h = 0.4 * edge / wave;
        cbr::test::SceneFolder folder;
        folder.add("fine.exo", plate(n, thickness));
        folder.add("coarse.exo", plate((4 * n) / 5, thickness));
        const std::string yaml = scene(as, formulation, thickness, h, 1e-3 * wave);
        cbr::test::Ran ran = folder.prepare(yaml);
        series.push_back(Stepper(ran.built.simulation).run());
        print(as, formulation, series.back(), bandwidth);
        if (n == 9 && !same_motion(ran.built.simulation, folder, yaml)) {
          std::printf("the program's own loop moves otherwise\n");
          same = false;
        }
      }
      print_growth(as, formulation, series, 0);
      print_growth(as, formulation, series, series.size() / 2);
    }
  }
  return same ? 0 : 1;
}

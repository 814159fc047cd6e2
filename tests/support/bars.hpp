// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of bars along x in contact at their ends, with nu = 0: one-dimensional elasticity with
// closed solutions.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/scene_run.hpp"

namespace cbr::test {

struct Bar {
  double length = 1, youngs_modulus = 100, density = 1;
  Index n = 16;         // elements along the axis
  double start = 0;     // of the lower end
  double velocity = 0;  // along x
  bool mesh = true;     // as: mesh; false: as: superelement with both end faces as interface
  Index modes = -1;     // -1: all
  std::string basis = "craig-bampton";
  double width = 0.1;
  Index across = 1;  // elements across
  double c() const { return std::sqrt(youngs_modulus / density); }
  double impedance() const { return density * c() * area(); }
  double transit() const { return 2 * length / c(); }  // forth and back
  double area() const { return width * width; }
  double mass() const { return density * area() * length; }
};

struct BarScene {
  std::vector<Bar> bars;  // named b0, b1, ... upwards; each touches the next
  double end = 1, every = 0.01;
  std::string integrator = "exact", enforcement = "impulse", step = "{cfl: 0.9}";
  std::string extra;    // further keys of the scene
  std::string contact;  // further options of each contact, ", key: value"
};

inline std::string name_of(std::size_t i) { return "b" + std::to_string(i); }

std::string yaml(const BarScene& scene);

Ran run(const BarScene& scene, const RunOptions& options = {});

// Wave solution of bars in contact at their ends, at the times i dt. Exact if the transit times of
// all bars and the excitations are multiples of dt. Waves travel unchanged and are reflected
// unchanged at free ends. With the incoming wave a and the outgoing wave b, an end moves at a + b
// under the force Z (a - b). At a closed joint under compression both ends move equally: Z1 (2 a1 -
// u) = Z2 (u - 2 a2) = F; else F = 0. Bars have uniform initial speeds, and gaps may be open.
struct Waves {
  double dt = 0;
  // [bar][i]: displacements of its ends and centre; [joint][i]
  std::vector<std::vector<double>> lower, upper, centre, force;
};
Waves waves(const std::vector<Bar>& bars, double dt, double end);

// Rms over time of the x of a series of positions against displacements at multiples of dt,
// relative to `scale`.
double error_of(const RunResult& result, const Series3& positions, const std::vector<double>& u,
                double dt, double scale);

double speed_of(const Ran& ran, std::size_t bar);

// From the first to the last output interval with a force above `threshold` on a surface.
double contact_time(const RunResult& result, const Series3& force, double threshold);

}  // namespace cbr::test

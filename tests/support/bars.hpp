// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes of bars along x that meet end to end, with nu = 0: one-dimensional elasticity, which has
// closed forms.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/scene_run.hpp"

namespace cbr::test {

struct Bar {
  double length = 1, youngs_modulus = 100, density = 1;
  Index n = 16;         // elements along it
  double start = 0;     // where its lower end is
  double velocity = 0;  // along x
  bool mesh = true;     // as: mesh, or as: superelement with the faces at both ends as interface
  Index modes = -1;     // -1: all
  std::string basis = "craig-bampton";
  double width = 0.1;
  Index across = 1;  // elements across
  double c() const { return std::sqrt(youngs_modulus / density); }
  double impedance() const { return density * c() * area(); }
  double transit() const { return 2 * length / c(); }  // there and back
  double area() const { return width * width; }
  double mass() const { return density * area() * length; }
};

struct BarScene {
  std::vector<Bar> bars;  // named b0, b1, ... from below; each touches the next
  double end = 1, every = 0.01;
  std::string integrator = "exact", enforcement = "impulse", step = "{cfl: 0.9}";
  std::string extra;    // further keys of the scene
  std::string contact;  // further options of each contact, ", key: value"
};

inline std::string name_of(std::size_t i) { return "b" + std::to_string(i); }

std::string yaml(const BarScene& scene);

Ran run(const BarScene& scene, const RunOptions& options = {});

// What wave theory says of bars that touch end to end, at the times i dt: exact when the transit
// times of all bars and what starts the waves fall on multiples of dt. A wave runs through a bar
// unchanged and comes back from a free end as it came. With a what arrives at an end and b what it
// sends, the end moves at a + b and is pressed by Z (a - b). At a joint that is closed and pressed
// both ends move alike: Z1 (2 a1 - u) = Z2 (u - 2 a2) = F; else F = 0. Bars are at uniform speed at
// first, and gaps may be open.
struct Waves {
  double dt = 0;
  // [bar][i]: displacements of its ends and centre; [joint][i]
  std::vector<std::vector<double>> lower, upper, centre, force;
};
Waves waves(const std::vector<Bar>& bars, double dt, double end);

// Rms over time of the x of a series of positions against displacements at multiples of dt, as a
// share of `scale`.
double error_of(const RunResult& result, const Series3& positions, const std::vector<double>& u,
                double dt, double scale);

double speed_of(const Ran& ran, std::size_t bar);

// From the first to the last output interval with a force above `threshold` on a surface.
double contact_time(const RunResult& result, const Series3& force, double threshold);

}  // namespace cbr::test

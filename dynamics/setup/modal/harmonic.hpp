// SPDX-License-Identifier: GPL-3.0-or-later
// Harmonic response of a linear scene (`sweep`, cbr-dyn --sweep).
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/scene/scene.hpp"

namespace cbr {

using ComplexMatrix = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic>;

struct HarmonicResponse {
  Vector frequency_hz;
  struct OfSet {
    std::string name;  // INSTANCE.SET, of output.history
    // frequencies x 3, scene axes: u(t) = Re(displacement e^(i omega t)), mean over the set's nodes
    ComplexMatrix displacement;
  };
  std::vector<OfSet> sets;
};

// Response to loads and prescribed motions as sines in phase, with their values as amplitudes.
// Histories and gravity act in load steps alone. InputError: no sweep, no output.history, contact
// that is not tied, no excitation, a resonance frequency of an undamped scene.
HarmonicResponse harmonic_response(const Scene& scene, Report& report);

}  // namespace cbr

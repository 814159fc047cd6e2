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

// Loads are sines in phase, with the amplitude of their value; so is the motion of supports.
// Histories and gravity are left out. InputError: no sweep, no output.history, contact that is not
// tied, nothing that excites, a frequency at which an undamped scene answers without bounds.
HarmonicResponse harmonic_response(const Scene& scene, Report& report);

}  // namespace cbr

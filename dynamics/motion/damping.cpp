// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/damping.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string_view>

namespace cbr {
namespace {

// Linear between the table's frequencies, constant beyond them.
double ratio_at(const ModalDamping& table, double hz) {
  if (table.empty()) return 0;
  if (table.ratio.size() == 1 || hz <= table.frequency_hz.front()) return table.ratio.front();
  if (hz >= table.frequency_hz.back()) return table.ratio.back();
  const auto next = std::upper_bound(table.frequency_hz.begin(), table.frequency_hz.end(), hz);
  const auto i = static_cast<std::size_t>(next - table.frequency_hz.begin());
  const double f0 = table.frequency_hz[i - 1], f1 = table.frequency_hz[i];
  return table.ratio[i - 1] + (table.ratio[i] - table.ratio[i - 1]) * (hz - f0) / (f1 - f0);
}

}  // namespace

ModalRates Damping::rates(const Vector& omega) const {
  ModalRates rates;
  rates.c.setZero(omega.size());
  if (none()) return rates;
  for (Index j = 0; j < omega.size(); ++j) {
    const double w = omega[j], ratio = ratio_at(modal, w / (2 * std::numbers::pi));
    rates.c[j] = material.alpha + material.beta * w * w + (2 * ratio + material.loss_factor) * w;
  }
  const auto bytes = static_cast<std::size_t>(rates.c.size()) * sizeof(double);
  rates.hash =
      std::hash<std::string_view>()({reinterpret_cast<const char*>(rates.c.data()), bytes}) | 1;
  return rates;
}

double critical_frequency(double omega, double beta) {
  const double zeta = 0.5 * beta * omega;
  return omega * (std::sqrt(1 + zeta * zeta) + zeta);
}

}  // namespace cbr

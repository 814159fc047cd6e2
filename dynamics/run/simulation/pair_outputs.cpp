// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/run/simulation/pair_outputs.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {
namespace {

using At = PairOutput::At;

Vector3 one_number(double value) { return {value, 0, 0}; }

// Sums of a force since the last output, over its time.
Vector3 mean_of(const Vector3& sum, double interval) {
  return interval > 0 ? Vector3(sum / interval) : Vector3::Zero();
}

Vector3 take_vector(double* kept) {
  const Vector3 sum(kept);
  std::fill_n(kept, 3, 0.0);
  return sum;
}

constexpr PairOutput pair_output_list[] = {
    {"active", "1", 1, 0, nullptr,
     [](const At& at, double*) { return one_number(static_cast<double>(at.active)); }},
    {"penetration", "length", 1, 0, nullptr,
     [](const At& at, double*) { return one_number(at.pair.seen().recent_penetration); }},
    {"residual", "1", 1, 0, nullptr,
     [](const At& at, double*) { return one_number(at.pair.seen().recent_residual); }},
    {"area", "area", 1, 0, nullptr,
     [](const At& at, double*) {
       return one_number(at.active > 0 ? at.pair.seen().step.area : 0);
     }},
    {"force", "force", 3, 3,
     [](const PairStep& step, double* kept) { Eigen::Map<Vector3>(kept) += step.impulse; },
     [](const At& at, double* kept) {
       return mean_of((at.pair.slave_is_first ? 1 : -1) * take_vector(kept), at.interval);
     }},
    {"center_of_pressure", "length", 3, 4,
     [](const PairStep& step, double* kept) {
       Eigen::Map<Vector3>(kept) += step.moment;
       kept[3] += step.normal_impulse;
     },
     [](const At&, double* kept) { return mean_of(take_vector(kept), std::exchange(kept[3], 0)); }},
    {"impacts", "1", 1, 1, [](const PairStep& step, double* kept) { *kept += step.begins; },
     [](const At&, double* kept) { return one_number(*kept); }},
    {"peak_force", "force", 1, 1,
     [](const PairStep& step, double* kept) {
       *kept = std::max(step.begins ? 0 : *kept, step.impulse.stableNorm() / step.h);
     },
     [](const At&, double* kept) { return one_number(*kept); }},
    {"impulse", "impulse", 1, 3,
     [](const PairStep& step, double* kept) {
       if (step.begins) std::fill_n(kept, 3, 0.0);
       Eigen::Map<Vector3>(kept) += step.impulse;
     },
     [](const At&, double* kept) { return one_number(Vector3(kept).stableNorm()); }},
};

constexpr std::size_t n_kept = [] {
  std::size_t n = 0;
  for (const PairOutput& output : pair_output_list) n += static_cast<std::size_t>(output.n_kept);
  return n;
}();

}  // namespace

std::span<const PairOutput> pair_outputs() { return pair_output_list; }

const Series3& RunResult::OfPair::operator[](std::string_view name) const {
  const auto* of = std::find_if(std::begin(pair_output_list), std::end(pair_output_list),
                                [&](const PairOutput& output) { return output.name == name; });
  return series.at(static_cast<std::size_t>(of - std::begin(pair_output_list)));
}

void add_step(const PairStep& step, std::vector<double>& kept) {
  kept.resize(n_kept, 0);
  double* at = kept.data();
  for (const PairOutput& output : pair_output_list) {
    if (output.add != nullptr) output.add(step, at);
    at += output.n_kept;
  }
}

void add_values(const At& output, std::size_t n_before, std::vector<double>& kept,
                RunResult::OfPair& of) {
  kept.resize(n_kept, 0);
  of.series.resize(std::size(pair_output_list));
  double* at = kept.data();
  for (std::size_t i = 0; i < std::size(pair_output_list); ++i) {
    const Vector3 value = pair_output_list[i].value(output, at);
    std::vector<double>& values = of.series[i].values;
    values.resize(n_before * static_cast<std::size_t>(pair_output_list[i].size), 0);
    values.insert(values.end(), value.data(), value.data() + pair_output_list[i].size);
    at += pair_output_list[i].n_kept;
  }
}

}  // namespace cbr

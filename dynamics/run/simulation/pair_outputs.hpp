// SPDX-License-Identifier: GPL-3.0-or-later
// Outputs of a contact pair: one entry each. The datasets of the results, what is kept from step to
// step and its restart follow from the list.
#pragma once

#include <span>
#include <vector>

#include "common/base/types.hpp"
#include "dynamics/run/simulation/run_result.hpp"

namespace cbr {

struct ContactPair;

// Contact of a pair in one step, or one load step of statics. On the slave, scene axes.
struct PairStep {
  double h = 1;               // length of the step; 1 in statics
  bool begins = false;        // none had one in the step before
  double area = 0;            // of the active points
  double normal_impulse = 0;  // sum of the magnitudes
  Vector3 impulse = Vector3::Zero();
  Vector3 moment = Vector3::Zero();  // first moment of the normal impulses
};

struct PairOutput {
  // What a value is made of, beside the numbers that the output keeps.
  struct At {
    const ContactPair& pair;
    Index active = 0;     // points with an impulse in the last step
    double interval = 0;  // since the last output; 0 at the start, 1 in statics
  };
  const char* name;       // /contact/FIRST - SECOND/NAME
  const char* dimension;  // "1", "length", "area", "force", "impulse"
  Index size;             // numbers of a value: 1 or 3
  Index n_kept;           // numbers that it keeps from step to step, 0 at the start of the run
  // After a step of contact; null: nothing. Statics begin anew with each load step.
  void (*add)(const PairStep& step, double* kept);
  Vector3 (*value)(const At& output, double* kept);  // the first `size`; sums may begin anew
};

std::span<const PairOutput> pair_outputs();

// After a step in which the pair was searched. kept: by all outputs, in the order of the list.
void add_step(const PairStep& step, std::vector<double>& kept);
// Adds the values of an output to the series, in the order of the list. Those of the outputs before
// that the series lack, of which there are n_before, are 0.
void add_values(const PairOutput::At& output, std::size_t n_before, std::vector<double>& kept,
                RunResult::OfPair& of);

}  // namespace cbr

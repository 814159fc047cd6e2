// SPDX-License-Identifier: GPL-3.0-or-later
// Least gap of surfaces that never touch. Contact does not have it, as its search has a limited
// reach.
#pragma once

#include <optional>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// Watches pairs that are not tied, if there are few. Until a pair has touched it evaluates only the
// mean motion of its surfaces, at outputs. Distances are computed on request.
class GapWatch {
 public:
  // Call when all pairs exist, before the first step and scale().
  void start(Simulation& simulation);
  // Call at each output, with all bodies at that time. A restarted run is watched from there on.
  void look(const Simulation& simulation);
  // Initial distance; none for a pair that is not watched.
  std::optional<double> initial(const Simulation& simulation, Index pair) const;
  // Least distance at an output, with surfaces moved by their mean displacement, without rotation.
  // Call after the run.
  std::optional<double> nearest(const Simulation& simulation, Index pair) const;

 private:
  struct Side {
    Index body = -1, mean_set = 0;
    Points sample;  // a subset of the undeformed nodes
    Vector3 start = Vector3::Zero(), shift = Vector3::Zero();
  };
  struct Watched {
    Index pair = 0;
    Side slave, master;  // a wall has no body
    double least = 0;    // least squared distance of the samples so far
    Vector3 slave_shift = Vector3::Zero(), master_shift = Vector3::Zero();  // at that time
  };
  Side side_of(Simulation& simulation, const ContactSurface& surface) const;
  const Watched* find(Index pair) const;
  static double sampled(const Simulation& simulation, const Watched& watched);
  static double distance(const Simulation& simulation, const Watched& watched,
                         const Vector3& slave_shift, const Vector3& master_shift);

  std::vector<Watched> watched_;
};

}  // namespace cbr

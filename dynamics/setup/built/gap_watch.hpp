// SPDX-License-Identifier: GPL-3.0-or-later
// How near surfaces come that never touch. Contact does not tell: it looks at what is near only.
#pragma once

#include <optional>
#include <vector>

#include "dynamics/run/simulation/simulation.hpp"

namespace cbr {

// Watches the pairs that are not tied, where there are few. Of each surface the mean motion is
// asked for at outputs, and nothing else, until the pair has touched; distances are computed when
// they are asked for.
class GapWatch {
 public:
  // Of pairs, once they are there and before the first step and scale().
  void start(Simulation& simulation);
  // At each output, all bodies being there. A restarted run is watched from there on.
  void look(const Simulation& simulation);
  // Least distance at the start. None of a pair that is not watched.
  std::optional<double> initial(const Simulation& simulation, Index pair) const;
  // At an output, of the surfaces moved with their mean displacement, without rotation. After the
  // run.
  std::optional<double> nearest(const Simulation& simulation, Index pair) const;

 private:
  struct Side {
    Index body = -1, mean_set = 0;
    Points sample;  // some of the undeformed nodes
    Vector3 start = Vector3::Zero(), shift = Vector3::Zero();
  };
  struct Watched {
    Index pair = 0;
    Side slave, master;  // of a wall: no body
    double least = 0;    // squared distance of the samples when they were nearest
    Vector3 slave_shift = Vector3::Zero(), master_shift = Vector3::Zero();  // then
  };
  Side side_of(Simulation& simulation, const ContactSurface& surface) const;
  const Watched* find(Index pair) const;
  static double sampled(const Simulation& simulation, const Watched& watched);
  static double distance(const Simulation& simulation, const Watched& watched,
                         const Vector3& slave_shift, const Vector3& master_shift);

  std::vector<Watched> watched_;
};

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build_steps.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/motion/body_points.hpp"
#include "dynamics/setup/contact/points.hpp"

namespace cbr {

void add_monitors(const SceneIndex& index, BuiltScene& built) {
  Simulation& sim = built.simulation;
  std::vector<Index> contact_of_body(sim.bodies.size(), -1);
  for (std::size_t c = 0; c < sim.contact_nodes.size(); ++c)
    contact_of_body[sim.contact_nodes[c].body] = static_cast<Index>(c);
  for (const SurfaceName& surface : index.scene().output.history) {
    Monitor monitor;
    monitor.name = surface.text();
    monitor.body = index.place(surface.instance);
    if (point_of(index.scene(), surface.instance, surface.surface) != nullptr) {
      monitor.has_point = true;
      monitor.point = point_place(index, surface.instance, surface.surface);
      sim.monitors.push_back(std::move(monitor));
      continue;
    }
    const BuiltScene::OfInstance& of = built.instances[monitor.body];
    if (is_inside(*of.geometry, surface.surface)) {
      watch_inside(index, surface, of, monitor);
      sim.monitors.push_back(std::move(monitor));
      continue;
    }
    const auto nodes = find_nodes(*of.geometry, surface.instance, surface.surface, surface.source);
    monitor.mean_set = sim.bodies[monitor.body]->track_mean(nodes);
    monitor.contact = contact_of_body[monitor.body];
    if (monitor.contact >= 0) {
      const auto& contact = sim.contact_nodes[monitor.contact].nodes;
      for (std::size_t slot = 0; slot < contact.size(); ++slot)
        if (std::binary_search(nodes.begin(), nodes.end(), contact[slot]))
          monitor.contact_slots.push_back(static_cast<Index>(slot));
    }
    sim.monitors.push_back(std::move(monitor));
  }
}

}  // namespace cbr

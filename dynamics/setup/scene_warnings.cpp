// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/build_steps.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <set>
#include <sstream>
#include <utility>

#include "common/base/format_text.hpp"
#include "dynamics/contact/surfaces/broad_phase.hpp"
#include "dynamics/motion/body_points.hpp"
#include "dynamics/setup/bodies/support_motion.hpp"
#include "dynamics/setup/built/instance_elements.hpp"

namespace cbr {
namespace {

// Largest number of nodes of a surface that are checked, and of its partner's faces.
constexpr std::size_t most_looked_at = 300;
// Cosine of 101 degrees: normals with a smaller one can touch.
constexpr double opposed = -0.2;

Points contact_points(const Simulation& sim, const ContactSurface& surface) {
  const ContactNodes& contact = sim.contact_nodes[surface.body];
  return sim.bodies[contact.body]->reference_positions()(contact.nodes, Eigen::all);
}

// Odd, as surfaces may list nodes of two sides in turns.
std::size_t stride_of(std::size_t n) { return n / most_looked_at | 1; }

struct Look {
  bool opposed = false;   // a node's normal opposes a face's
  bool in_front = false;  // and it is in front of the face, or behind it by at most its size
};

// Checks nodes of the slave against faces of the master.
Look look_at_faces(const ContactPair& pair, const Simulation& sim) {
  const Points x = contact_points(sim, *pair.slave), y = contact_points(sim, *pair.master);
  Look look;
  const auto n_faces = static_cast<std::size_t>(pair.master->faces.rows());
  for (std::size_t f = 0; f < n_faces && !look.in_front; f += stride_of(n_faces)) {
    const auto corner = [&](Index k) {
      return Vector3(y.row(pair.master->faces(static_cast<Index>(f), k)));
    };
    const Vector3 normal = (corner(2) - corner(0)).cross(corner(3) - corner(1));
    for (std::size_t i = 0; i < pair.slave->nodes.size();
         i += stride_of(pair.slave->nodes.size())) {
      const Vector3 outward = pair.slave->area_vectors.row(static_cast<Index>(i));
      if (outward.dot(normal) > opposed * outward.norm() * normal.norm()) continue;
      look.opposed = true;
      const double height = (Vector3(x.row(pair.slave->nodes[i])) - corner(0)).dot(normal);
      look.in_front =
          look.in_front || height > -pair.master->sizes[static_cast<Index>(f)] * normal.norm();
    }
  }
  return look;
}

Look look_at_wall(const ContactPair& pair, const Simulation& sim) {
  const Points x = contact_points(sim, *pair.slave);
  Look look;
  for (std::size_t i = 0; i < pair.slave->nodes.size(); ++i) {
    const Vector3 outward = pair.slave->area_vectors.row(static_cast<Index>(i));
    const Vector3 normal = pair.wall->normal(x.row(pair.slave->nodes[i]).transpose());
    if (outward.dot(normal) <= opposed * outward.norm()) look.opposed = look.in_front = true;
  }
  return look;
}

void warn_of_backs(const ContactPair& pair, const Simulation& sim, const std::vector<Box>& boxes,
                   Report& report) {
  if (pair.law.law == ContactLaw::tied || pair.slave->area_vectors.rows() == 0) return;
  const Look look = pair.wall ? look_at_wall(pair, sim) : look_at_faces(pair, sim);
  if (look.in_front) return;
  if (look.opposed) {  // look_for_overlaps() reports overlapping bodies
    const auto box = [&](const ContactSurface& surface) {
      return boxes[sim.contact_nodes[surface.body].body];
    };
    if (box(*pair.slave).meets(box(*pair.master))) return;
  }
  report.warning(
      pair.source->text() + ": contact " + pair.name +
      ": the surfaces face away from each other at the start" +
      (look.opposed ? " (each is behind the other)" : "") +
      " and cannot touch: are they the right ones, or is an instance turned or mirrored?");
}

double size_of(const Box& box) { return (box.upper - box.lower).maxCoeff(); }

// Distance of two boxes.
double gap_between(const Box& a, const Box& b) {
  const Vector3 apart = (a.lower - b.upper).cwiseMax(b.lower - a.upper).cwiseMax(0);
  return apart.norm();
}

// Whether the overlap exceeds half of each edge of both.
bool share_most(const Box& a, const Box& b) {
  const Vector3 shared = a.upper.cwiseMin(b.upper) - a.lower.cwiseMax(b.lower);
  return (shared.array() > 0.5 * (a.upper - a.lower).cwiseMax(b.upper - b.lower).array()).all();
}

// Bound of the approach of two instances by initial velocities and gravity.
double way_of(const Scene& scene, const Instance& a, const Instance& b) {
  double way = (a.velocity - b.velocity).norm() * scene.time->end;
  for (const Load& load : scene.loads)
    if (load.kind == Load::Kind::gravity)
      way += 0.5 * load.value.norm() * scene.time->end * scene.time->end;
  return way;
}

bool has_other_loads(const Scene& scene) {
  return std::any_of(scene.loads.begin(), scene.loads.end(),
                     [](const Load& load) { return load.kind != Load::Kind::gravity; });
}

void warn_of_unit(const Scene& scene, const std::vector<Box>& boxes, std::size_t i, std::size_t j,
                  Report& report) {
  constexpr double far = 100, near = 0.05;
  const Instance &a = scene.instances[i], &b = scene.instances[j];
  const double size = std::max(size_of(boxes[i]), size_of(boxes[j])),
               gap = gap_between(boxes[i], boxes[j]);
  const double offset =
      (boxes[i].lower + boxes[i].upper - boxes[j].lower - boxes[j].upper).norm() / 2;
  const bool is_far =
      gap > far * size && way_of(scene, a, b) < 0.1 * gap && !has_other_loads(scene);
  const bool is_inside =
      a.component == b.component && offset < near * size && share_most(boxes[i], boxes[j]);
  if (!is_far && !is_inside) return;
  std::ostringstream text;
  text.precision(3);
  text << b.source.text() << ": instances '" << a.name << "' and '" << b.name << "', " << size
       << " across, ";
  if (is_far) text << "start " << gap << " apart, and their speed does not bring them together";
  if (is_inside) text << "start inside each other, " << offset << " from one to the other";
  text << ": are their positions in the unit of the meshes' coordinates?";
  report.warning(text.str());
}

// Shells whose rotations are interior are hinged where their mesh is clamped.
void warn_of_hinge(const Scene& scene, const BoundaryCondition& condition, const BuiltScene& built,
                   Report& report) {
  const auto found = std::find_if(scene.instances.begin(), scene.instances.end(),
                                  [&](const Instance& i) { return i.name == condition.instance; });
  if (found == scene.instances.end()) return;
  const std::string hinged = why_hinged(scene, *found);
  if (hinged.empty()) return;
  const auto place = found - scene.instances.begin();
  const Geometry& geometry = *built.instances[place].geometry;
  AveragePoint held;
  held.nodes = find_nodes(geometry, found->name, condition.nodes, condition.source);
  held.weights = Vector::Ones(static_cast<Index>(held.nodes.size()));
  if (!lie_on_a_line(held, geometry.coordinates)) return;
  report.warning(condition.source.text() + ": boundary: '" + condition.nodes + "' of instance '" +
                 found->name + "' is a hinge, " + hinged);
}

// Shortest time in which a history leaves a value and returns.
double shortest_pulse(const History& history) {
  double shortest = std::numeric_limits<double>::infinity(), start = 0;
  int before = 0;
  for (std::size_t k = 1; k < history.time.size(); ++k) {
    const double change = history.value[k] - history.value[k - 1];
    const int sign = change > 0 ? 1 : change < 0 ? -1 : 0;
    if (sign == 0) continue;
    if (before == -sign) shortest = std::min(shortest, history.time[k] - start);
    if (before != sign) start = history.time[k - 1];
    before = sign;
  }
  return shortest;
}

}  // namespace

void warn_of_odd_scenes(const Scene& scene, const BuiltScene& built, Report& report) {
  for (const BoundaryCondition& condition : scene.boundary)
    warn_of_hinge(scene, condition, built, report);
  constexpr std::size_t most_pairs = 1000;
  const Simulation& sim = built.simulation;
  std::vector<Box> boxes;
  for (std::size_t b = 0; b < built.instances.size(); ++b)
    boxes.push_back(extents(*sim.bodies[b], built.instances[b]));
  std::set<std::pair<Index, Index>> looked_at;
  for (std::size_t p = 0; p < std::min(sim.pairs.size(), most_pairs); ++p) {
    const ContactPair& pair = sim.pairs[p];
    // Of many instances most may be distant from some and near to others
    const bool is_alone = !pair.of_all || built.instances.size() == 2;
    if (is_alone && !(pair.of_all && pair.wall)) warn_of_backs(pair, sim, boxes, report);
    if (pair.wall) continue;
    const std::pair<Index, Index> two = std::minmax(sim.contact_nodes[pair.slave->body].body,
                                                    sim.contact_nodes[pair.master->body].body);
    if (is_alone && two.first != two.second && two.second < static_cast<Index>(boxes.size()) &&
        looked_at.insert(two).second)
      warn_of_unit(scene, boxes, static_cast<std::size_t>(two.first),
                   static_cast<std::size_t>(two.second), report);
  }
}

void warn_of_missed_loads(const SceneIndex& index, const BuiltScene& built, Report& report) {
  const auto& bodies = built.simulation.bodies;
  const double h = built.simulation.plan.h;
  const bool any_sampled =
      std::any_of(bodies.begin(), bodies.end(), [](const auto& body) { return !body->is_exact(); });
  for (std::size_t i = 0; any_sampled && i < index.scene().loads.size(); ++i) {
    const Load& load = index.scene().loads[i];
    const bool sampled =
        load.kind == Load::Kind::gravity || !bodies[index.place(load.instance)]->is_exact();
    const double pulse = shortest_pulse(load.history);
    if (!sampled || pulse >= 2 * h * (1 - 1e-9)) continue;
    report.warning(
        load.source.text() +
        format_text(": loads[%zu].history rises and falls within %.4g s, less than two steps of "
                    "%.4g s, and is seen at the ends of steps only: take a smaller step",
                    i, pulse, h));
  }
}

}  // namespace cbr

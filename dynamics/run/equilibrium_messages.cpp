// SPDX-License-Identifier: GPL-3.0-or-later
// Errors of a load step without equilibrium.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>
#include <utility>

#include "common/base/error.hpp"
#include "dynamics/run/equilibrium.hpp"

namespace cbr {
namespace {

// Relative to the largest motion of a body's points: those at the axis about which it turns.
constexpr double at_axis = 0.1;
// Number of points in a message, of those that open and close endlessly.
constexpr std::size_t told_points = 3;

// Largest displacement u of the body's own nodes beside the best small rigid motion.
double deformation(const Points& nodes, Points u) {
  const Points own = nodes.topRows(u.rows()), x = own.rowwise() - own.colwise().mean();
  u.rowwise() -= u.colwise().mean().eval();
  const Matrix3 inertia = x.squaredNorm() * Matrix3::Identity() - x.transpose() * x;
  Vector3 moment = Vector3::Zero();
  for (Index i = 0; i < x.rows(); ++i) moment += Vector3(x.row(i)).cross(Vector3(u.row(i)));
  const Vector3 rotation = inertia.inverse() * moment;
  for (Index i = 0; i < x.rows(); ++i) u.row(i) -= rotation.cross(Vector3(x.row(i)));
  return u.rowwise().norm().maxCoeff();
}

}  // namespace

std::string Equilibrium::load_step() const {
  std::ostringstream text;
  text.precision(4);
  if (preload_ > 0) {
    text << "load step " << preload_ << " of " << n_preload_ << " before the time 0";
  } else {
    text << "load step to t = " << last_t_;
  }
  return text.str();
}

// A body without balance slides if all of its points do so where it begins, before it leaves them.
void Equilibrium::note_slide(Index b, const Vector& left) {
  Slide& slide = slides_[b];
  if (left.isZero(0)) {
    slide = {};
    return;
  }
  if (++slide.n > first_slides) return;
  const std::string pairs = sliding_pairs(b, left);
  if (slide.n == 1 || pairs.empty()) slide.pairs = pairs;
  if (slide.n == 1 || left.norm() < slide.left.norm()) slide.left = left;
}

// The pairs of a body's closed points, if friction is at its limit at every one that `left` moves.
std::string Equilibrium::sliding_pairs(Index b, const Vector& left) const {
  std::set<std::string> names;
  bool any = false;
  double most = 0, held = 0;  // motion along the faces: of all points, of those that do not slide
  at_pushing_points([&](const Solved& solved, std::size_t p, std::size_t i) {
    const ContactPair& pair = sim_.pairs[p];
    const PointLaw& law = solved.group.laws[i];
    const auto is_of = [&](Index contact) {
      return contact >= 0 && contact < static_cast<Index>(forces_.size()) &&
             sim_.contact_nodes[contact].body == b;
    };
    if (law.law == ContactLaw::frictionless) return;
    if (!is_of(pair.slave->body) && !is_of(pair.master->body)) return;
    const ContactPoint& point = solved.group.list.points[i];
    Vector3 way = Vector3::Zero();
    for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t)
      if (const ContactTerm& term = solved.group.list.terms[t]; is_of(term.body))
        way += term.coefficient * (floating_[term.body].R.middleRows(3 * term.node, 3) * left);
    const double moved = (point.frame.bottomRows<2>() * way).norm();
    const bool is_sliding = law.law == ContactLaw::coulomb &&
                            slides(solved.result.p.row(static_cast<Index>(i)), law.friction);
    any |= is_sliding;
    most = std::max(most, moved);
    if (!is_sliding) held = std::max(held, law.law == ContactLaw::tied ? HUGE_VAL : moved);
    names.insert(pair.name);
  });
  return any && held <= at_axis * most ? join({names.begin(), names.end()}) : "";
}

// Error with the body that changes most, and the pair whose points open and close most.
void Equilibrium::refuse_endless(const Change& change) const {
  std::size_t worst = 0;
  std::vector<Closed> most;
  for (std::size_t p = 0; p < closed_.size(); ++p) {
    std::vector<Closed> changed;
    std::set_symmetric_difference(closed_[p].begin(), closed_[p].end(), closed_before_[p].begin(),
                                  closed_before_[p].end(), std::back_inserter(changed));
    if (sim_.pairs[p].law.law == ContactLaw::tied || changed.size() < most.size()) continue;
    most = std::move(changed);
    worst = p;
  }
  std::ostringstream text;
  text.precision(3);
  text << "statics: " << load_step() << ": no equilibrium in " << most_iterations
       << " iterations: the last one changed the displacements by "
       << std::sqrt(change.change / std::max(change.energy, 1e-300))
       << " of themselves (energy norm), most in instance '" << sim_.bodies[change.body]->name()
       << "'";
  if (!closed_.empty()) {
    const std::size_t both =
        (closed_[worst].size() + closed_before_[worst].size() + most.size()) / 2;
    text << "; in contact " << sim_.pairs[worst].name << " " << most.size() << " of " << both
         << " points still open or close";
    most.erase(std::unique(most.begin(), most.end(),
                           [](const Closed& x, const Closed& y) {
                             return x.contact_body == y.contact_body && x.node == y.node;
                           }),
               most.end());
    for (std::size_t i = 0; i < std::min(most.size(), told_points); ++i) {
      const auto x = here_[most[i].contact_body].row(most[i].node);
      text << (i == 0 ? ", at [" : ", [") << x[0] << ", " << x[1] << ", " << x[2] << "]";
    }
    if (most.size() > told_points) text << " and others";
  }
  // The same points stay closed, and move from face to face without a force that stops them
  const bool goes_round = !closed_.empty() && most.empty() && !sim_.pairs[worst].wall &&
                          sim_.pairs[worst].formulation != Formulation::mortar;
  text << (goes_round
               ? sim_.pairs[worst].law.law == ContactLaw::coulomb
                     ? ": give this contact formulation: mortar"
                     : ": give this contact formulation: mortar, or friction"
               : ": take smaller load steps (time.step, time.preload), or a finer mesh there");
  throw RunError(text.str());
}

void Equilibrium::refuse_unheld(Index b, Vector left) const {
  Body& body = *sim_.bodies[b];
  const std::string& pairs = slides_[b].pairs;
  if (!pairs.empty()) left = slides_[b].left;
  body.settle();
  Points u, v, before;
  body.displacements(before, v);
  body.float_by(left / left.lpNorm<Eigen::Infinity>() * extent_of(body));
  body.settle();
  body.displacements(u, v);
  u -= before;
  const Vector3 mean = u.colwise().mean().transpose();
  std::ostringstream text;
  text.precision(3);
  text << "statics: " << load_step() << ": instance '" << body.name()
       << "' is not held: under its loads it ";
  const bool turns = !(mean.norm() > 0.2 * u.rowwise().norm().mean());
  if (!turns) {
    const Vector3 way = mean.normalized();
    text << "moves along [" << way[0] << ", " << way[1] << ", " << way[2] << "]";
  } else {
    text << "turns";
  }
  text << " without end: ";
  const double deformed = deformation(body.reference_positions(), before) / extent_of(body);
  if (deformed > 1) {
    text << "it also deforms by " << deformed << " times its size: look at the units of its loads "
         << "and its material";
  } else if (pairs.empty()) {
    text << "hold it by boundary, tied surfaces, contact that it is pressed into, or friction";
  } else {
    const double load = left.dot(loads_.segment(first_[b], left.size())) / left.squaredNorm();
    text << "it slides in contact " << pairs << ", where friction is at its limit at every point";
    if (turns) text << " off the axis";
    if (load > 1) text << " and holds " << 1 - 1 / load << " of the load that way";
    text << ": press it more, raise contact[].friction, or hold it by boundary or tied surfaces";
  }
  throw InputError(text.str());
}

}  // namespace cbr

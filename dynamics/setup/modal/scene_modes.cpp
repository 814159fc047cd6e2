// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/modal/scene_modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"

namespace cbr {
namespace {

// Meshes that are tied: so many modes of each for one that is asked for, and no fewer than some; statics of the others come on top.
constexpr Index modes_for_one = 10, fewest_modes = 100;
// Compliance of ties below this share of the softest mode's counts as none: the tie holds the modes themselves.
constexpr double no_compliance = 1e-9;
// Squared frequencies up to this share of the lowest elastic one of the parts are rigid motions.
constexpr double rigid_share = 1e-8;

// Bodies that ties join, by the first of each group.
std::vector<std::vector<Index>> groups_of(const ModalScene& scene) {
  std::vector<Index> first(scene.bodies.size());
  std::iota(first.begin(), first.end(), Index{0});
  const auto root = [&](Index b) {
    while (first[static_cast<std::size_t>(b)] != b) b = first[static_cast<std::size_t>(b)];
    return b;
  };
  for (const TieRow& tie : scene.ties)
    for (const auto& [body, sum] : tie.of_bodies) {
      const Index a = root(body), b = root(tie.of_bodies.front().first);
      first[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  std::vector<std::vector<Index>> groups;
  std::vector<Index> place(scene.bodies.size(), -1);
  for (Index b = 0; b < static_cast<Index>(scene.bodies.size()); ++b) {
    Index& of = place[static_cast<std::size_t>(root(b))];
    if (of < 0) {
      of = static_cast<Index>(groups.size());
      groups.emplace_back();
    }
    groups[static_cast<std::size_t>(of)].push_back(b);
  }
  return groups;
}

// Coordinates of several bodies one after the other, and the rows that ties keep at zero: A eta + S p = 0, p what the ties carry.
struct Joined {
  Vector lambda, c;  // n, of the bodies' own modes
  Matrix A, S;       // m x n, m x m
  std::vector<Index> first;
};

Joined join(const ModalScene& scene, const std::vector<Index>& bodies) {
  Joined joined;
  Index n = 0;
  for (const Index b : bodies) {
    joined.first.push_back(n);
    n += scene.bodies[static_cast<std::size_t>(b)].omega().size();
  }
  joined.lambda.resize(n), joined.c.resize(n);
  const auto is_of = [&](const TieRow& tie) {
    return std::find(bodies.begin(), bodies.end(), tie.of_bodies.front().first) != bodies.end();
  };
  std::vector<const TieRow*> ties;
  for (const TieRow& tie : scene.ties)
    if (is_of(tie)) ties.push_back(&tie);
  const auto m = static_cast<Index>(ties.size());
  joined.A = Matrix::Zero(m, n), joined.S = Matrix::Zero(m, m);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const ModalBody& body = scene.bodies[static_cast<std::size_t>(bodies[i])];
    const Index size = body.omega().size();
    joined.lambda.segment(joined.first[i], size) = body.omega().cwiseAbs2();
    joined.c.segment(joined.first[i], size) = body.damping_rates();
    std::vector<NodalSum> sums;
    std::vector<Index> rows;
    for (Index t = 0; t < m; ++t)
      for (const auto& [of, sum] : ties[static_cast<std::size_t>(t)]->of_bodies)
        if (of == bodies[i]) sums.push_back(sum), rows.push_back(t);
    if (sums.empty()) continue;
    const ModalAnswer answer = body.answer(sums);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      joined.A.row(rows[r]).segment(joined.first[i], size) = answer.A.row(static_cast<Index>(r));
      if (answer.S_0.size() == 0) continue;
      for (std::size_t q = 0; q < rows.size(); ++q)
        joined.S(rows[r], rows[q]) += answer.S_0(static_cast<Index>(r), static_cast<Index>(q));
    }
  }
  return joined;
}

double lowest_elastic(const Vector& lambda) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const double l : lambda)
    if (l > 0) lowest = std::min(lowest, l);
  return lowest;
}

struct Modes {
  Vector lambda;
  Matrix shapes;  // n x modes
};

// Where ties have compliance of their own they are springs, p = -S^-1 A eta; where they have none they hold: A eta = 0.
Modes modes_of(const Joined& joined, Index count) {
  const Index n = joined.lambda.size();
  const double lowest = lowest_elastic(joined.lambda);
  const SymmetricEigen compliance = symmetric_eigen(joined.S);
  const Matrix A = compliance.vectors.transpose() * joined.A;
  const double softest = A.squaredNorm() / (std::isfinite(lowest) ? lowest : 1);
  std::vector<Index> held, springs;
  for (Index i = 0; i < A.rows(); ++i) (compliance.values[i] > no_compliance * softest ? springs : held).push_back(i);
  Matrix K = joined.lambda.asDiagonal();
  const Vector stiffness = Vector(compliance.values(springs)).cwiseInverse();
  const Matrix B = A(springs, Eigen::all);
  if (!springs.empty()) K += B.transpose() * stiffness.asDiagonal() * B;
  Matrix Z = Matrix::Identity(n, n);
  if (!held.empty()) Z = null_space(A(held, Eigen::all), 1e-10);
  const SymmetricEigen pairs = generalized_eigen(Z.transpose() * K * Z, Z.transpose() * Z);
  if (!pairs.converged) throw RunError("the frequencies of the tied instances did not converge");
  Modes modes;
  count = std::min(count, static_cast<Index>(pairs.values.size()));
  modes.shapes = Z * pairs.vectors.leftCols(count);
  modes.lambda.resize(count);
  for (Index j = 0; j < count; ++j) {
    // Not of K's round-off, which is that of its highest frequency
    const Vector eta = modes.shapes.col(j);
    double lambda = joined.lambda.dot(eta.cwiseAbs2());
    if (!springs.empty()) lambda += stiffness.dot((B * eta).cwiseAbs2());
    modes.lambda[j] = lambda > rigid_share * (std::isfinite(lowest) ? lowest : 0) ? lambda : 0;
  }
  return modes;
}

Modes modes_of_one(const ModalBody& body, Index count) {
  const Vector lambda = body.omega().cwiseAbs2();
  std::vector<Index> order(static_cast<std::size_t>(lambda.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return lambda[a] < lambda[b]; });
  order.resize(static_cast<std::size_t>(std::min(count, static_cast<Index>(lambda.size()))));
  Modes modes{lambda(order), Matrix::Zero(lambda.size(), static_cast<Index>(order.size()))};
  for (std::size_t j = 0; j < order.size(); ++j) modes.shapes(order[j], static_cast<Index>(j)) = 1;
  return modes;
}

InstanceModes of_group(const ModalScene& scene, const std::vector<Index>& bodies, Index count) {
  InstanceModes of;
  of.bodies = bodies;
  std::vector<std::string> names;
  for (const Index b : bodies) names.push_back(scene.built.instances[static_cast<std::size_t>(b)].name);
  of.instance = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) of.instance += "+" + names[i];
  const Joined joined = join(scene, bodies);
  const Modes modes =
      bodies.size() == 1 ? modes_of_one(scene.bodies[static_cast<std::size_t>(bodies.front())], count) : modes_of(joined, count);
  const Vector omega = modes.lambda.cwiseSqrt();
  of.frequency_hz = omega / (2 * std::numbers::pi);
  of.damping_ratio = Vector::Zero(omega.size());
  for (Index j = 0; j < omega.size(); ++j)
    if (omega[j] > 0) of.damping_ratio[j] = joined.c.dot(modes.shapes.col(j).cwiseAbs2()) / (2 * omega[j]);
  for (std::size_t i = 0; i < bodies.size(); ++i)
    of.shapes.push_back(modes.shapes.middleRows(joined.first[i], scene.bodies[static_cast<std::size_t>(bodies[i])].omega().size()));
  return of;
}

}  // namespace

SceneModes scene_modes(const Scene& scene_of_run, Index n, Report& report) {
  Scene scene = with_options_of_files(scene_of_run);
  std::erase_if(scene.contact, [](const ContactOptions& contact) { return !contact.tied; });
  const bool is_tied = !scene.contact.empty();
  SceneModes modes;
  modes.scene = modal_scene(scene, {is_tied ? std::max(modes_for_one * n, fewest_modes) : n, 0}, false, report);
  for (const std::vector<Index>& bodies : groups_of(*modes.scene)) modes.instances.push_back(of_group(*modes.scene, bodies, n));
  return modes;
}

}  // namespace cbr

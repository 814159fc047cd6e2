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
#include "dynamics/setup/modal/assembled_modes.hpp"

namespace cbr {
namespace {

// Least number of modes of joined meshes, so that one is elastic: it determines the shift.
constexpr Index fewest_modes = 7;
// Compliance of ties below this fraction of the softest mode's is neglected: the tie then
// constrains the modes.
constexpr double no_compliance = 1e-9;
// If all parts are rigid and have no elastic frequency: relative to the softest tie, and of an
// eigenvalue to the highest one.
constexpr double round_off = 1e-14;

// Groups of bodies joined by ties, ordered by their first.
std::vector<std::vector<Index>> groups_of(const ModalScene& scene) {
  std::vector<Index> first(scene.bodies.size());
  std::iota(first.begin(), first.end(), Index{0});
  const auto root = [&](Index b) {
    while (first[b] != b) b = first[b];
    return b;
  };
  for (const TieRow& tie : scene.ties)
    for (const auto& [body, sum] : tie.of_bodies) {
      const Index a = root(body), b = root(tie.of_bodies.front().first);
      first[std::max(a, b)] = std::min(a, b);
    }
  std::vector<std::vector<Index>> groups;
  std::vector<Index> place(scene.bodies.size(), -1);
  for (Index b = 0; b < static_cast<Index>(scene.bodies.size()); ++b) {
    Index& of = place[root(b)];
    if (of < 0) {
      of = static_cast<Index>(groups.size());
      groups.emplace_back();
    }
    groups[of].push_back(b);
  }
  return groups;
}

// Concatenated coordinates of several bodies, and the rows of ties: A eta + S p = 0, p the tie
// forces. Without joints a row is A eta + S_bodies p.
struct Joined {
  Vector lambda, c;       // n, of the bodies' own modes
  Matrix A, S, S_bodies;  // m x n, m x m
  std::vector<Index> first;
  // rows with a force: all but those of dashpots without springs
  std::vector<Index> stiff;
  std::vector<Dashpots> dashpots;
};

void join_body(const BodyModes& body, const std::vector<NodalSum>& sums,
               const std::vector<Index>& rows, Index first, Joined& joined) {
  const ModalAnswer answer = body.answer(sums);
  joined.A(rows, Eigen::seqN(first, answer.A.cols())) += answer.A;
  if (!answer.S.empty()) joined.S(rows, rows) += answer.S.front();
  if (!answer.S.empty() && !body.is_joint()) joined.S_bodies(rows, rows) += answer.S.front();
  if (answer.B.size() > 0 && !answer.C.isZero(0))
    joined.dashpots.push_back({rows, answer.B, answer.C});
}

Joined join(const ModalScene& scene, const std::vector<Index>& bodies) {
  Joined joined;
  Index n = 0;
  for (const Index b : bodies) {
    joined.first.push_back(n);
    n += scene.bodies[b].omega().size();
  }
  joined.lambda.resize(n);
  joined.c.resize(n);
  std::vector<const TieRow*> ties;
  for (const TieRow& tie : scene.ties) {
    if (std::find(bodies.begin(), bodies.end(), tie.of_bodies.front().first) == bodies.end())
      continue;
    if (!tie.is_dashpot) joined.stiff.push_back(static_cast<Index>(ties.size()));
    ties.push_back(&tie);
  }
  const auto m = static_cast<Index>(ties.size());
  joined.A = Matrix::Zero(m, n);
  joined.S = joined.S_bodies = Matrix::Zero(m, m);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BodyModes& body = scene.bodies[bodies[i]];
    const Index size = body.omega().size();
    joined.lambda.segment(joined.first[i], size) = body.omega().cwiseAbs2();
    joined.c.segment(joined.first[i], size) = body.damping_rates();
    std::vector<NodalSum> sums;
    std::vector<Index> rows;
    for (Index t = 0; t < m; ++t)
      for (const auto& [of, sum] : ties[t]->of_bodies)
        if (of == bodies[i]) {
          sums.push_back(sum);
          rows.push_back(t);
        }
    if (!sums.empty()) join_body(body, sums, rows, joined.first[i], joined);
  }
  return joined;
}

double lowest_above(const Vector& lambda, double limit) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const double l : lambda)
    if (l > limit) lowest = std::min(lowest, l);
  return lowest;
}

struct Modes {
  Vector lambda;
  Matrix shapes;  // n x modes
  Matrix forces;  // m x modes, of ties with compliance
};

// Ties with compliance are springs, p = -S^-1 A eta; others are constraints, A eta = 0.
Modes modes_of(const Joined& joined, Index count) {
  const Index n = joined.lambda.size();
  const double lowest = lowest_above(joined.lambda, 0);
  const bool is_elastic = std::isfinite(lowest);
  const SymmetricEigen compliance = symmetric_eigen(joined.S(joined.stiff, joined.stiff));
  const Matrix A = compliance.vectors.transpose() * joined.A(joined.stiff, Eigen::all);
  const double soft = is_elastic     ? no_compliance * A.squaredNorm() / lowest
                      : A.rows() > 0 ? round_off * compliance.values.maxCoeff()
                                     : 0;
  std::vector<Index> held, springs;
  for (Index i = 0; i < A.rows(); ++i) (compliance.values[i] > soft ? springs : held).push_back(i);
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
  // By the parts: K has the round-off of its highest frequency
  const auto energies = [&](const Matrix& X) {
    const Matrix stretch = B * X;
    return Matrix(X.transpose() * joined.lambda.asDiagonal() * X +
                  stretch.transpose() * stiffness.asDiagonal() * stretch);
  };
  // So the shapes up to the lowest elastic frequency of the parts are found again among themselves
  const double highest = pairs.values.size() > 0 ? pairs.values.maxCoeff() : 0,
               next = is_elastic ? lowest : lowest_above(pairs.values, round_off * highest);
  const Index n_low = (pairs.values.array() <= next).count();
  Matrix shapes = Z * pairs.vectors;
  shapes.leftCols(n_low) *= symmetric_eigen(energies(shapes.leftCols(n_low))).vectors;
  modes.shapes = shapes.leftCols(count);
  modes.lambda = energies(modes.shapes).diagonal();
  // Round-off among these, and of what the others leave in them
  const double left = energy_round_off * highest,
               least = energy_round_off * next + left * left / next;
  modes.lambda = (modes.lambda.array() > least).select(modes.lambda, 0);
  modes.forces = Matrix::Zero(joined.A.rows(), count);
  if (!springs.empty())
    modes.forces(joined.stiff, Eigen::all) =
        -compliance.vectors(Eigen::all, springs) * (stiffness.asDiagonal() * (B * modes.shapes));
  return modes;
}

Modes modes_of_one(const BodyModes& body, Index count) {
  const Vector lambda = body.omega().cwiseAbs2();
  std::vector<Index> order(static_cast<std::size_t>(lambda.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return lambda[a] < lambda[b]; });
  order.resize(static_cast<std::size_t>(std::min(count, static_cast<Index>(lambda.size()))));
  Modes modes{lambda(order), Matrix::Zero(lambda.size(), static_cast<Index>(order.size())),
              Matrix()};
  for (std::size_t j = 0; j < order.size(); ++j) modes.shapes(order[j], static_cast<Index>(j)) = 1;
  return modes;
}

// phi . C phi of each mode: its own damping and dashpots.
Vector damping_of(const Joined& joined, const Modes& modes) {
  Vector c = (joined.c.transpose() * modes.shapes.cwiseAbs2()).transpose();
  if (joined.dashpots.empty()) return c;
  const Matrix y = joined.A * modes.shapes + joined.S_bodies * modes.forces;
  for (const Dashpots& of : joined.dashpots) {
    const Matrix r = of.B.transpose() * y(of.rows, Eigen::all);
    c += r.cwiseProduct(of.C * r).colwise().sum().transpose();
  }
  return c;
}

struct GroupModes {
  Vector lambda, c;
  std::vector<Matrix> shapes;  // of each body, its coordinates
};

GroupModes modes_of_joined(const ModalScene& scene, const std::vector<Index>& bodies, Index count) {
  const Joined joined = join(scene, bodies);
  const Modes modes = bodies.size() == 1 && joined.A.rows() == 0
                          ? modes_of_one(scene.bodies[bodies.front()], count)
                          : modes_of(joined, count);
  GroupModes of{modes.lambda, damping_of(joined, modes), {}};
  for (std::size_t i = 0; i < bodies.size(); ++i)
    of.shapes.push_back(
        modes.shapes.middleRows(joined.first[i], scene.bodies[bodies[i]].omega().size()));
  return of;
}

// Meshes use their mode shapes as coordinates.
GroupModes modes_of_assembled(ModalScene& scene, const std::vector<Index>& bodies, Index count) {
  AssembledModes modes = assembled_modes(scene, bodies, count);
  GroupModes of{modes.lambda, modes.c, std::move(modes.shapes)};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    BodyModes& body = scene.bodies[bodies[i]];
    if (body.mesh() == nullptr || body.mesh()->is_complete()) continue;
    body.take_shapes(of.shapes[i]);
    of.shapes[i] = Matrix::Identity(of.lambda.size(), of.lambda.size());
  }
  return of;
}

InstanceModes of_group(ModalScene& scene, const std::vector<Index>& bodies, Index count) {
  InstanceModes of;
  std::vector<std::string> names;
  for (const Index b : bodies) {
    if (scene.bodies[b].is_joint()) continue;
    of.bodies.push_back(b);
    names.push_back(scene.built.instances[b].name);
  }
  of.instance = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) of.instance += "+" + names[i];
  GroupModes modes = needs_assembly(scene, bodies) ? modes_of_assembled(scene, bodies, count)
                                                   : modes_of_joined(scene, bodies, count);
  const Vector omega = modes.lambda.cwiseSqrt();
  of.frequency_hz = omega / (2 * std::numbers::pi);
  of.damping_ratio = Vector::Zero(omega.size());
  for (Index j = 0; j < omega.size(); ++j)
    if (omega[j] > 0) of.damping_ratio[j] = modes.c[j] / (2 * omega[j]);
  modes.shapes.resize(of.bodies.size());  // joints come last
  of.shapes = std::move(modes.shapes);
  return of;
}

}  // namespace

SceneModes scene_modes(const Scene& scene_of_run, Index n, Report& report) {
  const Scene scene = with_options_of_files(scene_of_run);
  const bool is_joined = has_ties(scene);
  const MeshModesWanted wanted{is_joined ? std::max(n, fewest_modes) : n, 0, is_joined};
  SceneModes modes;
  modes.scene = modal_scene(scene, wanted, false, report);
  for (const std::vector<Index>& bodies : groups_of(*modes.scene))
    modes.instances.push_back(of_group(*modes.scene, bodies, n));
  return modes;
}

}  // namespace cbr

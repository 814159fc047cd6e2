// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/bases/characteristic/compliance_probes.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/linalg/eigen/eigenpairs.hpp"

namespace cbr {
namespace {

// cos 20 degrees: forces along other directions have no common places.
constexpr double same_direction = 0.94;
constexpr double first_places = 160;  // for one force at a node
// In spacings of a level, within which each force has a place:
constexpr double support = 1.9;      // of the shares of a place
constexpr double near_places = 5.5;  // entries of S
constexpr double apart = 10.5;       // places that one load has
constexpr double enough = 0.5;       // of all forces are places: the next level has all

bool alike(const Points& direction, Index i, Index j) {
  return direction.row(i).dot(direction.row(j)) > same_direction;
}

// Forces, each as far as can be from those before it that are alike, and its distance from these;
// up to `enough` of them.
std::pair<std::vector<Index>, std::vector<double>> farthest_first(const Points& x,
                                                                  const Points& direction) {
  const Index s = x.rows();
  std::vector<Index> order;
  std::vector<double> distance;
  Vector nearest = Vector::Constant(s, std::numeric_limits<double>::infinity());
  while (static_cast<double>(order.size()) < enough * static_cast<double>(s) || order.empty()) {
    Index next = 0;
    nearest.maxCoeff(&next);
    order.push_back(next);
    distance.push_back(std::sqrt(nearest[next]));
    for (Index i = 0; i < s; ++i)
      if (alike(direction, i, next))
        nearest[i] = std::min(nearest[i], (x.row(i) - x.row(next)).squaredNorm());
  }
  return {std::move(order), std::move(distance)};
}

double wendland(double r) { return std::pow(1 - r, 4) * (4 * r + 1); }

// Shares of a force at x among places (rows of c) within `radius`: moving least squares, which
// leave linear functions as they are where places tell their slopes (Lancaster, Salkauskas 1981,
// doi 10.1090/S0025-5718-1981-0616367-1), with the weights of Wendland 1995.
Vector shares(const Vector3& x, const Points& c, double radius) {
  constexpr double least_slope = 1e-3;
  const Index n = c.rows();
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, Eigen::Dynamic> p(4, n);
  Vector weight(n);
  for (Index a = 0; a < n; ++a) {
    const Vector3 away = (c.row(a).transpose() - x) / radius;
    weight[a] = wendland(std::min(1.0, away.norm()));
    p.col(a) << 1, away;
    moments += weight[a] * p.col(a) * p.col(a).transpose();
  }
  moments.diagonal().tail<3>().array() += least_slope * moments(0, 0);
  const Eigen::Vector4d y = moments.inverse().col(0);
  return weight.cwiseProduct(p.transpose() * y);
}

// Of each place the first colour that none within `distance` before it has.
std::vector<Index> colours(const Points& c, double distance) {
  std::vector<Index> colour;
  std::vector<char> taken;
  for (Index a = 0; a < c.rows(); ++a) {
    taken.assign(taken.size(), 0);
    for (Index b = 0; b < a; ++b)
      if ((c.row(a) - c.row(b)).squaredNorm() < distance * distance) taken[colour[b]] = 1;
    const auto free = std::find(taken.begin(), taken.end(), 0) - taken.begin();
    if (free == static_cast<std::ptrdiff_t>(taken.size())) taken.push_back(0);
    colour.push_back(free);
  }
  return colour;
}

// To 16 bits: half the file, and far below the error of a level.
double rounded(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(std::round(std::ldexp(mantissa, 16)), exponent - 16);
}

double highest(Index n, const LinearMap& multiply) {
  return largest_eigenvalue(n, multiply, [](const Vector& x, Vector& y) { y = x; });
}

// Minus what is negative in the levels: sum of |lambda| v v^T over their negative eigenvalues, by
// Lanczos with full orthogonalisation. These few eigenvalues are 0 in F, of forces that the
// coordinates answer, and far from the others.
ComplianceLevel negative_part(const std::vector<ComplianceLevel>& levels) {
  constexpr Index most_steps = 200;
  const Index s = levels.back().P.cols(), m = std::min(most_steps, s);
  Matrix Q(s, m), T = Matrix::Zero(m, m);
  Vector next =
      Vector::LinSpaced(s, 1, 2).array().sin() + Vector::LinSpaced(s, 0, 77).array().cos();
  Index n = 0;
  for (double beta = next.norm(); n < m && beta > 0; ++n) {
    Q.col(n) = next / beta;
    next = compliance_product(levels, Q.col(n));
    for (int pass = 0; pass < 2; ++pass) {
      const Vector along = Q.leftCols(n + 1).transpose() * next;
      next.noalias() -= Q.leftCols(n + 1) * along;
      if (pass == 0) T(n, n) = along[n];
    }
    beta = next.norm();
    if (n + 1 < m) T(n + 1, n) = T(n, n + 1) = beta;
  }
  const Eigenpairs pairs = dense_eigenpairs(Matrix(T.topLeftCorner(n, n)), n);
  const Index negative = (pairs.lambda.array() < 0).count();
  const Matrix v = Q.leftCols(n) * pairs.Phi.leftCols(negative);
  ComplianceLevel level;
  level.P = Matrix(v.transpose().unaryExpr(&rounded)).sparseView(1, 0);
  level.S = Matrix((-pairs.lambda.head(negative)).asDiagonal()).sparseView(1, 0);
  return level;
}

// By how much the lowest eigenvalue of the levels is below 0, or a bound on it.
double lacks(const std::vector<ComplianceLevel>& levels) {
  const Index s = levels.back().P.cols();
  const double top =
      highest(s, [&](const Vector& x, Vector& y) { y = compliance_product(levels, x).col(0); });
  return highest(s, [&](const Vector& x,
                        Vector& y) { y = top * x - compliance_product(levels, x).col(0); }) -
         top;
}

}  // namespace

ComplianceProbes::ComplianceProbes(const Points& x, const Points& direction, double of_node)
    : x_(x), direction_(direction) {
  const Index s = x.rows();
  std::vector<double> distance;
  std::tie(order_, distance) = farthest_first(x, direction);
  const auto most = static_cast<Index>(order_.size());
  // Of each direction there is a first one, which is far from nothing
  const Index n_first = std::count(distance.begin(), distance.end(), HUGE_VAL);
  const auto k = std::min(most, std::max<Index>(n_first + 1, std::lround(first_places * of_node)));
  double spacing = distance[k - 1];
  loads_.resize(s, 0);
  // The first level has all entries, so each of its places has a load
  add_loads(level_of(k, spacing, std::numeric_limits<double>::infinity()));
  for (spacing /= 2;; spacing /= 2) {
    const auto places =
        std::find_if(distance.begin(), distance.end(), [&](double d) { return d <= spacing; }) -
        distance.begin();
    if (places >= most) break;
    add_loads(level_of(places, spacing, near_places * spacing));
  }
  order_ = first_numbers(s);
  add_loads(level_of(s, spacing, near_places * spacing));
}

ComplianceProbes::Level ComplianceProbes::level_of(Index n_places, double spacing,
                                                   double reach) const {
  const Index s = x_.rows();
  Level level;
  level.places.assign(order_.begin(), order_.begin() + n_places);
  const Points c = x_(level.places, Eigen::all);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index i = 0; i < s; ++i) {
    if (n_places == s) {
      entries.emplace_back(i, i, 1);
      continue;
    }
    std::vector<Index> near;
    for (Index a = 0; a < n_places; ++a)
      if ((c.row(a) - x_.row(i)).squaredNorm() < std::pow(support * spacing, 2) &&
          alike(direction_, i, level.places[a]))
        near.push_back(a);
    const Vector share = shares(x_.row(i).transpose(), c(near, Eigen::all), support * spacing);
    for (std::size_t a = 0; a < near.size(); ++a)
      entries.emplace_back(near[a], i, rounded(share[static_cast<Index>(a)]));
  }
  level.P.resize(n_places, s);
  level.P.setFromTriplets(entries.begin(), entries.end());
  if (std::isinf(reach)) {
    level.load_of = colours(c, reach);
    return level;
  }
  level.load_of = colours(c, apart * spacing);
  entries.clear();
  for (Index a = 0; a < n_places; ++a)
    for (Index b = 0; b < n_places; ++b)
      if ((c.row(a) - c.row(b)).squaredNorm() < reach * reach) entries.emplace_back(b, a, 1);
  level.near.resize(n_places, n_places);
  level.near.setFromTriplets(entries.begin(), entries.end());
  return level;
}

// Values at the places whose shares come nearest to Y in the mean: (P P^T)^-1 P Y   (k x q)
Matrix ComplianceProbes::at_places(const Level& level, const Matrix& Y) const {
  if (level.P.rows() == level.P.cols()) return Y;
  return SparseCholesky(level.P * SparseMatrix(level.P.transpose())).solve(level.P * Y);
}

// Loads that give a place 1 and the others of its level 0.
void ComplianceProbes::add_loads(Level level) {
  const auto k = static_cast<Index>(level.places.size());
  const Index n = 1 + *std::max_element(level.load_of.begin(), level.load_of.end());
  Matrix at = Matrix::Zero(k, n);
  for (Index a = 0; a < k; ++a) at(a, level.load_of[a]) = 1;
  if (k < x_.rows()) {
    const SparseMatrix of_forces = level.P.transpose();
    at = of_forces * SparseCholesky(level.P * of_forces).solve(at);
  }
  level.first = loads_.cols();
  level.last = level.first + n;
  for (Index& load : level.load_of) load += level.first;
  loads_.conservativeResize(Eigen::NoChange, level.last);
  loads_.rightCols(n) = at;
  levels_.push_back(std::move(level));
}

std::vector<ComplianceLevel> ComplianceProbes::levels(const Matrix& answers) const {
  std::vector<ComplianceLevel> levels;
  // What the levels so far leave of the answers to this one's loads, at its places
  const auto left = [&](const Level& level) {
    const Index n = level.last - level.first;
    return at_places(level, answers.middleCols(level.first, n) -
                                compliance_product(levels, loads_.middleCols(level.first, n)));
  };
  for (const Level& level : levels_) {
    const Matrix Z = left(level);
    SparseMatrix S = level.near;
    if (S.rows() == 0) {
      S = Matrix(0.5 * (Z + Z.transpose())).sparseView(1, 0);
    } else {
      const auto entry = [&](Index b, Index a) { return Z(b, level.load_of[a] - level.first); };
      for (Index a = 0; a < S.cols(); ++a)
        for (SparseMatrix::InnerIterator it(S, a); it; ++it)
          it.valueRef() = 0.5 * (entry(it.row(), a) + entry(a, it.row()));
    }
    levels.push_back({level.P, std::move(S)});
  }
  // The first level is right in the end: near entries that were left out are in its answers
  const Matrix Z = left(levels_.front());
  levels.front().S += SparseMatrix(Matrix(0.5 * (Z + Z.transpose())).sparseView(1, 0));
  levels.insert(levels.begin(), negative_part(levels));
  const double left_negative = std::max(0.0, lacks(levels));
  for (Index i = 0; i < levels.back().S.rows(); ++i)
    levels.back().S.coeffRef(i, i) += left_negative;
  for (ComplianceLevel& level : levels)
    for (Index a = 0; a < level.S.cols(); ++a)
      for (SparseMatrix::InnerIterator it(level.S, a); it; ++it)
        it.valueRef() = rounded(it.value());
  return levels;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/enforce/contact_unknowns.hpp"

#include <algorithm>
#include <cmath>

#include "common/files/state_archive.hpp"
#include "dynamics/contact/enforce/closing_cells.hpp"
#include "dynamics/contact/laws/keep_state.hpp"

namespace cbr {

std::vector<Index> first_columns(const std::vector<PointLaw>& laws,
                                 const std::vector<FunctionsOfSearch>& searches) {
  std::vector<Index> first{0};
  for (const FunctionsOfSearch& search : searches) {
    const bool has = search.functions != nullptr && search.last > search.first;
    first.push_back(first.back() +
                    (has ? search.functions->size() * n_rows(laws[search.first].law) : 0));
  }
  return first;
}

void keep_state(StateArchive& archive, UnknownKey& key) {
  archive(key.search, key.function, key.slot, key.ordinal);
}

std::vector<Index> ContactUnknowns::of_searches() const {
  std::vector<Index> n(pairs.size(), 0);
  for (const UnknownKey& key : keys) ++n[key.search];
  return n;
}

void ContactUnknowns::keep_state(StateArchive& archive) {
  archive(reduced, A, laws, keys, pairs, column, share, values, areas, is_held, depths,
          friction_factors);
}

Vector ContactUnknowns::guess(const std::vector<PointLaw>& of_points, const Vector& p) const {
  const std::vector<Index> first = first_rows(laws), first_of_points = first_rows(of_points);
  // Of the functions at each row of a point, whose force they share; points keep theirs
  Vector all = Vector::Zero(p.size());
  std::vector<char> is_own(static_cast<std::size_t>(p.size()), 0);
  for (Index row = 0; row < A.cols(); ++row)
    for (SparseMatrix::InnerIterator it(A, row); it; ++it) {
      if (share[row] > 0)
        all[it.row()] += std::abs(it.value()) / share[row];
      else
        is_own[it.row()] = 1;
    }
  Vector x = Vector::Zero(A.cols());
  for (std::size_t u = 0; u < laws.size(); ++u)
    for (Index row = first[u]; row < first[u + 1]; ++row) {
      if (areas[static_cast<Index>(u)] > 0) {
        for (SparseMatrix::InnerIterator it(values, static_cast<Index>(u)); it; ++it)
          x[row] += it.value() * p[first_of_points[it.row()] + row - first[u]];
        continue;
      }
      for (SparseMatrix::InnerIterator it(A, row); it; ++it) {
        if (share[row] == 0)
          x[row] += it.value() * p[it.row()];
        else if (is_own[it.row()] == 0)
          x[row] += it.value() / share[row] / all[it.row()] * p[it.row()];
      }
    }
  return x;
}

void ContactUnknowns::remember_cells(const std::vector<FunctionsOfSearch>& searches) const {
  for (std::size_t s = 0; s < searches.size(); ++s) {
    if (searches[s].memory != nullptr)
      searches[s].memory->cells = reduced ? cells[s] : ChosenCells();
  }
}

bool same_matrix(const SparseMatrix& a, const SparseMatrix& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols() || a.nonZeros() != b.nonZeros()) return false;
  return std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.cols() + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
         std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

SparseMatrix function_matrix(const ContactList& list, const std::vector<PointLaw>& laws,
                             const std::vector<FunctionsOfSearch>& searches) {
  const std::vector<Index> rows = first_rows(laws), columns = first_columns(laws, searches);
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t s = 0; s < searches.size(); ++s) {
    if (columns[s + 1] == columns[s]) continue;
    const Cells cells(list, searches[s]);
    const Index n = n_rows(laws[searches[s].first].law);
    const SparseMatrix& N = searches[s].functions->N;
    for (Index a = 0; a < N.cols(); ++a) {
      const ContactPoint* reference = cells.reference(*searches[s].functions, a);
      for (SparseMatrix::InnerIterator it(N, a); it; ++it) {
        if (cells.point_of(it.row()) < 0) continue;
        const auto at = static_cast<std::size_t>(cells.point_of(it.row()));
        const Turn turn = turn_between(list.points[at], *reference, laws[at]);
        for (Index d = 0; d < n; ++d)
          rows_of_turn(turn, rows[at], d, [&](Index row, double factor) {
            entries.emplace_back(row, columns[s] + n * a + d, factor * it.value());
          });
      }
    }
  }
  SparseMatrix matrix(rows.back(), columns.back());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

HeldPoints held_points(const ContactUnknowns& unknowns, const Vector& x) {
  HeldPoints of;
  if (unknowns.areas.size() == 0 || !(unknowns.areas.maxCoeff() > 0)) return of;
  const std::vector<Index> first = first_rows(unknowns.laws);
  of.pressure.setZero(unknowns.values.rows());
  of.area.setZero(of.pressure.size());
  for (std::size_t i = 0; i < unknowns.is_held.size(); ++i)
    if (unknowns.is_held[i] == 0) of.pressure[static_cast<Index>(i)] = -1;
  for (Index u = 0; u < unknowns.areas.size(); ++u) {
    const double area = unknowns.areas[u], impulse = x[first[u]];
    if (!(area > 0 && impulse > 0)) continue;
    const double all = unknowns.values.col(u).sum();
    for (SparseMatrix::InnerIterator it(unknowns.values, u); it; ++it) {
      of.pressure[it.row()] += it.value() * impulse / area;
      of.area[it.row()] += it.value() * area / all;
    }
  }
  return of;
}

}  // namespace cbr

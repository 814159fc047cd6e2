// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact/surfaces/pair_projection.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/linalg/kernels/clones.hpp"

namespace cbr {
namespace {

// Number of pairs that are projected together. Loops over them are plain, so that the compiler
// vectorises them (options of this file in CMakeLists.txt).
constexpr int lanes = 16;
// More iterations than meshes' faces need; unfinished pairs are projected one by one.
constexpr int most_steps = 8;
// Limit of a face's coordinates, which are -1 to 1 on it: as in projection.cpp.
constexpr double farthest = 3;

using Lanes = std::array<double, lanes>;
using Three = std::array<Lanes, 3>;

// Nodes x and faces p(xi, eta) = c + xi a + eta b + xi eta w at one time, see projection.cpp.
struct Block {
  Three x, c, a, b, w;
  Lanes xi, eta, value;
  Lanes unfinished, failed;  // 1 or 0; failed ones are projected one by one
  // Members of Projection
  std::array<Lanes, 4> weights;
  Three normal;
  Lanes distance, outside;
};

CBR_INLINE double dot(const Three& a, const Three& b, int i) {
  return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
}
// Loops with one selection each, which the compiler vectorises.
CBR_INLINE void limit(Lanes& x, double most) {
  for (int i = 0; i < lanes; ++i) x[i] = x[i] < most ? x[i] : most;
  for (int i = 0; i < lanes; ++i) x[i] = x[i] > -most ? x[i] : -most;
}
CBR_INLINE void take_where(const Lanes& moves, const Lanes& from, Lanes& to) {
  for (int i = 0; i < lanes; ++i) {
    const double yes = from[i], no = to[i];
    to[i] = moves[i] > 0 ? yes : no;
  }
}

// Minimum for nearly parallelogram faces: first order in w. Faces without area fail later.
CBR_INLINE void guess(Block& p) {
  Lanes h11, h22, h12, da, db, twist;
  for (int i = 0; i < lanes; ++i) {
    h11[i] = dot(p.a, p.a, i);
    h22[i] = dot(p.b, p.b, i);
    h12[i] = dot(p.a, p.b, i);
    const double inverse = 1 / (h11[i] * h22[i] - h12[i] * h12[i]);
    h11[i] *= inverse;
    h22[i] *= inverse;
    h12[i] *= inverse;
    da[i] = db[i] = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = p.x[k][i] - p.c[k][i];
      da[i] += d * p.a[k][i];
      db[i] += d * p.b[k][i];
    }
    p.xi[i] = h22[i] * da[i] - h12[i] * db[i];
    p.eta[i] = h11[i] * db[i] - h12[i] * da[i];
  }
  limit(p.xi, farthest);
  limit(p.eta, farthest);
  for (int i = 0; i < lanes; ++i) {
    twist[i] = p.xi[i] * p.eta[i];
    da[i] -= twist[i] * dot(p.w, p.a, i);
    db[i] -= twist[i] * dot(p.w, p.b, i);
    p.xi[i] = h22[i] * da[i] - h12[i] * db[i];
    p.eta[i] = h11[i] * db[i] - h12[i] * da[i];
  }
  limit(p.xi, farthest);
  limit(p.eta, farthest);
  p.value.fill(HUGE_VAL);
  p.unfinished.fill(1);
}

// A Newton step from the current point, and the regularity of the minimum.
struct NewtonStep {
  Lanes xi, eta, value, round_off, twist, regular, length, change;
};

CBR_INLINE void find_step(const Block& p, NewtonStep& to) {
  for (int i = 0; i < lanes; ++i) {
    const double xi = p.xi[i], eta = p.eta[i];
    double value = 0, g1 = 0, g2 = 0, h11 = 0, h22 = 0, h12 = 0;
    for (int k = 0; k < 3; ++k) {
      const double a = p.a[k][i], b = p.b[k][i], w = p.w[k][i];
      const double u = a + eta * w, v = b + xi * w;
      const double r = p.x[k][i] - p.c[k][i] - xi * a - eta * v;
      value += r * r;
      g1 += r * u;
      g2 += r * v;
      h11 += u * u;
      h22 += v * v;
      h12 += u * v - r * w;
    }
    const double determinant = h11 * h22 - h12 * h12, inverse = 1 / determinant;
    const double s1 = (h22 * g1 - h12 * g2) * inverse, s2 = (h11 * g2 - h12 * g1) * inverse;
    to.value[i] = value;
    to.round_off[i] = 1e-20 * (h11 + h22);
    to.twist[i] = dot(p.w, p.w, i) - 1e-3 * (h11 + h22);
    to.regular[i] = determinant - 1e-10 * h11 * h22;
    to.length[i] = std::abs(s1) + std::abs(s2);
    to.xi[i] = xi + s1;
    to.eta[i] = eta + s2;
  }
  limit(to.xi, farthest);
  limit(to.eta, farthest);
  for (int i = 0; i < lanes; ++i)
    to.change[i] = std::abs(to.xi[i] - p.xi[i]) + std::abs(to.eta[i] - p.eta[i]);
}

// One step of closest_point() in projection.cpp, for full Newton steps. Neighbours of a node's face
// often have their minimum at the limit of the coordinates, if nearly parallelograms.
CBR_INLINE void step(Block& p) {
  NewtonStep to;
  find_step(p, to);
  Lanes bad{}, goes_on, beside;
  for (int i = 0; i < lanes; ++i) beside[i] = std::abs(to.xi[i]);
  for (int i = 0; i < lanes; ++i)
    beside[i] = beside[i] > std::abs(to.eta[i]) ? beside[i] : std::abs(to.eta[i]);
  // For a node on the face the value is round-off, which may grow
  for (int i = 0; i < lanes; ++i) bad[i] = to.value[i] <= p.value[i] + to.round_off[i] ? bad[i] : 1;
  for (int i = 0; i < lanes; ++i) goes_on[i] = bad[i] > 0 ? 0 : 1;
  for (int i = 0; i < lanes; ++i) beside[i] = to.twist[i] < 0 ? beside[i] : 0;
  for (int i = 0; i < lanes; ++i) bad[i] = beside[i] < farthest ? bad[i] : 0;
  for (int i = 0; i < lanes; ++i) bad[i] = to.regular[i] > 0 ? bad[i] : 1;
  for (int i = 0; i < lanes; ++i) goes_on[i] = bad[i] > 0 ? 0 : goes_on[i];
  take_where(p.unfinished, to.xi, p.xi);
  take_where(p.unfinished, to.eta, p.eta);
  for (int i = 0; i < lanes; ++i) p.failed[i] += p.unfinished[i] * bad[i];
  for (int i = 0; i < lanes; ++i) goes_on[i] = to.length[i] < 1e-8 ? 0 : goes_on[i];
  for (int i = 0; i < lanes; ++i) goes_on[i] = to.change[i] < 1e-14 ? 0 : goes_on[i];
  for (int i = 0; i < lanes; ++i) p.unfinished[i] *= goes_on[i];
  p.value = to.value;
}

CBR_INLINE bool any(const Lanes& of) {
  double sum = 0;
  for (int i = 0; i < lanes; ++i) sum += of[i];
  return sum > 0;
}

CBR_INLINE void finish(Block& p) {
  Lanes s = p.xi, t = p.eta, length;
  limit(s, 1);
  limit(t, 1);
  for (int i = 0; i < lanes; ++i) {
    const double s_less = 0.5 * (1 - s[i]), s_more = 0.5 * (1 + s[i]);
    const double t_less = 0.5 * (1 - t[i]), t_more = 0.5 * (1 + t[i]);
    p.weights[0][i] = s_less * t_less;
    p.weights[1][i] = s_more * t_less;
    p.weights[2][i] = s_more * t_more;
    p.weights[3][i] = s_less * t_more;
    double u[3], v[3], r[3];
    for (int k = 0; k < 3; ++k) {
      u[k] = p.a[k][i] + t[i] * p.w[k][i];
      v[k] = p.b[k][i] + s[i] * p.w[k][i];
      r[k] = p.x[k][i] - p.c[k][i] - s[i] * p.a[k][i] - t[i] * v[k];
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    length[i] = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double inverse = 1 / length[i];
    p.distance[i] = (n[0] * r[0] + n[1] * r[1] + n[2] * r[2]) * inverse;
    for (int k = 0; k < 3; ++k) p.normal[k][i] = n[k] * inverse;
  }
  for (int i = 0; i < lanes; ++i) p.failed[i] += p.unfinished[i];
  for (int i = 0; i < lanes; ++i) p.failed[i] = length[i] > 0 ? p.failed[i] : 1;
  for (int i = 0; i < lanes; ++i) s[i] = std::abs(p.xi[i]);
  for (int i = 0; i < lanes; ++i) t[i] = std::abs(p.eta[i]);
  for (int i = 0; i < lanes; ++i) p.outside[i] = s[i] > t[i] ? s[i] : t[i];
  for (int i = 0; i < lanes; ++i) p.outside[i] = 0.5 * (p.outside[i] - 1);
}

// On entry c, a, b, w hold the corners.
CBR_CLONES void project_block(Block& p) {
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < lanes; ++i) {
      const double x0 = p.c[k][i], x1 = p.a[k][i], x2 = p.b[k][i], x3 = p.w[k][i];
      p.c[k][i] = 0.25 * ((x0 + x2) + (x1 + x3));
      p.a[k][i] = 0.25 * ((x2 - x0) - (x3 - x1));
      p.b[k][i] = 0.25 * ((x2 - x0) + (x3 - x1));
      p.w[k][i] = 0.25 * ((x0 + x2) - (x1 + x3));
    }
  }
  guess(p);
  for (int k = 0; k < most_steps && any(p.unfinished); ++k) step(p);
  finish(p);
}

void take_lane(const Block& of, int lane, AtTime& to) {
  for (std::size_t a = 0; a < 4; ++a) to.weights[a] = of.weights[a][lane];
  to.normal = Vector3(of.normal[0][lane], of.normal[1][lane], of.normal[2][lane]);
  to.distance = of.distance[lane];
  to.outside = of.outside[lane];
  to.place = {of.xi[lane], of.eta[lane]};
}

void put_row(const Points& x, Index row, int lane, Three& to) {
  const double* from = x.data() + 3 * row;
  for (std::size_t k = 0; k < 3; ++k) to[k][lane] = from[k];
}

// Projects up to `lanes` pairs.
class Projector {
 public:
  Projector(const ContactSurface& master, std::span<const NodeAndFace> pairs)
      : master_(master), pairs_(pairs), n_(static_cast<int>(pairs.size())) {
    for (int i = 0; i < n_; ++i) {
      is_triangle_[i] = is_triangle(master, pairs[i].face) ? 1 : 0;
      any_quad_ |= is_triangle_[i] == 0;
    }
  }

  void project(const Points& faces, const Points& nodes, AtTime PairProjection::*to,
               PairProjection* results) {
    thread_local Block block;
    block.failed = is_triangle_;
    if (any_quad_) {
      for (int i = 0; i < lanes; ++i) {
        const NodeAndFace& pair = pairs_[std::min(i, n_ - 1)];
        const Index* corner = master_.faces.data() + 4 * pair.face;
        put_row(faces, corner[0], i, block.c);
        put_row(faces, corner[1], i, block.a);
        put_row(faces, corner[2], i, block.b);
        put_row(faces, corner[3], i, block.w);
        put_row(nodes, pair.node, i, block.x);
      }
      project_block(block);
    }
    for (int i = 0; i < n_; ++i) {
      AtTime& of = results[i].*to;
      if (block.failed[i] == 0) {
        take_lane(block, i, of);
      } else {
        const Vector3 x = nodes.row(pairs_[i].node).transpose();
        of = {cbr::project(corners(master_, pairs_[i].face, faces), is_triangle_[i] != 0, x), {}};
      }
    }
  }

 private:
  const ContactSurface& master_;
  std::span<const NodeAndFace> pairs_;
  int n_;
  bool any_quad_ = false;
  Lanes is_triangle_{};
};

}  // namespace

void project_pairs(const ContactSurface& master, const ContactBody& master_body,
                   const ContactBody& slave_body, std::span<const NodeAndFace> pairs, double reach,
                   std::vector<PairProjection>& results) {
  results.resize(pairs.size());
  for (std::size_t first = 0; first < pairs.size(); first += lanes) {
    const std::size_t n = std::min<std::size_t>(lanes, pairs.size() - first);
    Projector of_some(master, pairs.subspan(first, n));
    PairProjection* to = results.data() + first;
    of_some.project(master_body.end, slave_body.end, &PairProjection::end, to);
    const auto is_far = [&](const PairProjection& of) { return of.end.distance > reach; };
    if (std::all_of(to, to + n, is_far)) continue;
    of_some.project(master_body.start, slave_body.start, &PairProjection::before, to);
  }
}

}  // namespace cbr

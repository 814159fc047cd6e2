// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/motion/nodal/mesh_kernels.hpp"

#include <algorithm>

#include "common/linalg/kernels/clones.hpp"

namespace cbr {
namespace {

// GCC's and Clang's vectors: wide enough for the widest set, split by the compiler where registers
// are narrower.
using Lanes = double __attribute__((vector_size(64)));
// Packed: of a vector type that is only said to be unaligned Clang forgets it on the way.
struct __attribute__((packed, aligned(8), may_alias)) StoredLanes {
  Lanes v;
};
static_assert(sizeof(Lanes) == SharedElements::lanes * sizeof(double));

#define CBR_IN_LAMBDA __attribute__((always_inline))

// x = H x over the eight corners
CBR_INLINE void walsh(Lanes (&x)[8]) {
  for (int bit = 1; bit < 8; bit <<= 1) {
    for (int b = 0; b < 8; ++b) {
      if (b & bit) continue;
      const Lanes sum = x[b] + x[b | bit], difference = x[b] - x[b | bit];
      x[b] = sum;
      x[b | bit] = difference;
    }
  }
}

CBR_INLINE void add_boxes(const SharedElements& shared, std::size_t first, std::size_t last,
                          const double* u, Index u_stride, double* f, Index f_stride,
                          Index f_begin) {
  for (std::size_t k = first; k < last; ++k) {
    const SharedElements::Batch& batch = shared.batches[k];
    const SharedElements::Pattern& pattern = shared.patterns[batch.pattern];
    const double* S = shared.stiffness[pattern.stiffness][0].data();
    Lanes x[3][8];
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      const double* from = u + c * u_stride + batch.base;
#pragma GCC unroll 8
      for (int b = 0; b < 8; ++b)
        x[c][b] = reinterpret_cast<const StoredLanes*>(from + pattern.offset[b])->v;
      walsh(x[c]);
    }
#pragma GCC unroll 8
    for (int s = 0; s < 8; ++s) {
      Lanes &x0 = x[0][s ^ 1], &x1 = x[1][s ^ 2], &x2 = x[2][s ^ 4];
      const double* A = S + 9 * s;
      const Lanes y0 = A[0] * x0 + A[1] * x1 + A[2] * x2;
      const Lanes y1 = A[3] * x0 + A[4] * x1 + A[5] * x2;
      const Lanes y2 = A[6] * x0 + A[7] * x1 + A[8] * x2;
      x0 = y0;
      x1 = y1;
      x2 = y2;
    }
    if (batch.used != 0xff) {
      Lanes is_used{};
      for (int lane = 0; lane < SharedElements::lanes; ++lane)
        is_used[lane] = batch.used >> lane & 1u;
      for (auto& of_component : x)
        for (Lanes& value : of_component) value *= is_used;
    }
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      walsh(x[c]);
      double* to = f + c * f_stride + (batch.base - f_begin);
#pragma GCC unroll 8
      for (int b = 0; b < 8; ++b) {
        StoredLanes* at = reinterpret_cast<StoredLanes*>(to + pattern.offset[b]);
        at->v = at->v + x[c][b];
      }
    }
  }
}

CBR_INLINE void strain(const double* u, const double* Y, Index stride, const double* A,
                       const double* B, const double* shift, double* __restrict d, Index n) {
  for (Index i = 0; i < n; ++i) {
    const double u0 = u[i], u1 = u[stride + i], u2 = u[2 * stride + i];
    const double Y0 = Y[i], Y1 = Y[stride + i], Y2 = Y[2 * stride + i];
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c)
      d[c * stride + i] = ((A[3 * c] * u0 + A[3 * c + 1] * u1 + A[3 * c + 2] * u2) - shift[c]) +
                          (B[3 * c] * Y0 + B[3 * c + 1] * Y1 + B[3 * c + 2] * Y2);
  }
}

// Of eight nodes at a time, or of one. By reference: what returns a vector has another ABI in each
// set of instructions.
CBR_INLINE void take(const double* from, Lanes& x) {
  x = reinterpret_cast<const StoredLanes*>(from)->v;
}
CBR_INLINE void take(const double* from, double& x) { x = *from; }
CBR_INLINE void put(double* to, const Lanes& x) { reinterpret_cast<StoredLanes*>(to)->v = x; }
CBR_INLINE void put(double* to, const double& x) { *to = x; }
// Three planes.
template <typename T>
CBR_INLINE void take(const double* from, Index stride, T (&x)[3]) {
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c) take(from + c * stride, x[c]);
}

CBR_INLINE double sum_of(const Lanes& x) {
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}

// sums[k] = sum over nodes i of what add(i, sum) adds to sum[k], eight at a time and then the rest
// one by one.
template <int N, typename Add>
CBR_INLINE void sum_nodes(Index n, double* sums, const Add& add) {
  Lanes sum[N]{};
  Index i = 0;
  for (; i + 8 <= n; i += 8) add(i, sum);
#pragma GCC unroll 12
  for (int k = 0; k < N; ++k) sums[k] = sum_of(sum[k]);
  double rest[N]{};
  for (; i < n; ++i) add(i, rest);
  for (int k = 0; k < N; ++k) sums[k] += rest[k];
}

template <typename T>
CBR_INLINE void add_fit(const T (&x)[3], const T (&arm)[3], const T& mass, T (&sum)[12]) {
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c) {
    sum[c] += mass * x[c];
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r) sum[3 + 3 * c + r] += x[r] * arm[c];
  }
}

CBR_INLINE void moments(const double* Y, const double* d, const double* f, Index stride, Index n,
                        double* sums) {
  sum_nodes<3>(n, sums, [&]<typename T>(Index i, T(&sum)[3]) CBR_IN_LAMBDA {
    T arm[3], z[3], g[3];
    take(Y + i, stride, arm);
    take(d + i, stride, z);
    take(f + i, stride, g);
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) z[c] += arm[c];
    sum[0] += z[1] * g[2] - z[2] * g[1];
    sum[1] += z[2] * g[0] - z[0] * g[2];
    sum[2] += z[0] * g[1] - z[1] * g[0];
  });
}

CBR_INLINE void fits(const double* u, const double* arms, const double* mass, Index stride, Index n,
                     double* sums) {
  sum_nodes<12>(n, sums, [&]<typename T>(Index i, T(&sum)[12]) CBR_IN_LAMBDA {
    T x[3], arm[3], m;
    take(u + i, stride, x);
    take(arms + i, stride, arm);
    take(mass + i, m);
    add_fit(x, arm, m, sum);
  });
}

template <bool has_load>
CBR_INLINE void leap_turned(const TurnedSpan& span, Index stride, Index n, const double* R,
                            const double* W, double s, double h, double* sums) {
  sum_nodes<12>(n, sums, [&]<typename T>(Index i, T(&sum)[12]) CBR_IN_LAMBDA {
    T f[3], Y[3], v[3], u[3], load[3], mass, s_m;
    take(span.f + i, stride, f);
    take(span.Y + i, stride, Y);
    take(span.v + i, stride, v);
    take(span.u + i, stride, u);
    if constexpr (has_load) take(span.load + i, stride, load);
    take(span.mass + i, mass);
    take(span.inverse_mass + i, s_m);
    s_m *= s;
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      T force = -(R[c] * f[0] + R[3 + c] * f[1] + R[6 + c] * f[2]);
      if constexpr (has_load) force += load[c];
      v[c] += s_m * force + s * (W[c] * Y[0] + W[3 + c] * Y[1] + W[6 + c] * Y[2]);
      u[c] += h * v[c];
      put(span.v + c * stride + i, v[c]);
      put(span.u_end + c * stride + i, u[c]);
    }
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) Y[c] *= mass;
    add_fit(u, Y, mass, sum);
  });
}

CBR_INLINE void leap_any_turned(const TurnedSpan& span, Index stride, Index n, const double* R,
                                const double* W, double s, double h, double* sums) {
  span.load != nullptr ? leap_turned<true>(span, stride, n, R, W, s, h, sums)
                       : leap_turned<false>(span, stride, n, R, W, s, h, sums);
}

CBR_INLINE void leap(const LeapfrogSpan& span, Index n, double s, double h) {
  const double* __restrict f = span.f;
  const double* __restrict m = span.inverse_mass;
  const double* __restrict u = span.u;
  double* __restrict v = span.v;
  double* __restrict u_end = span.u_end;
  if (const double* __restrict load = span.load) {
    for (Index i = 0; i < n; ++i) {
      v[i] += s * m[i] * (load[i] - f[i]);
      u_end[i] = u[i] + h * v[i];
    }
    return;
  }
  for (Index i = 0; i < n; ++i) {
    v[i] -= s * m[i] * f[i];
    u_end[i] = u[i] + h * v[i];
  }
}

using Four = double __attribute__((vector_size(32)));
struct __attribute__((packed, aligned(8), may_alias)) StoredFour {
  Four v;
};

CBR_INLINE const StoredFour* four(const double* at) {
  return reinterpret_cast<const StoredFour*>(at);
}

CBR_INLINE void block_rows(const BlockMatrix& A, const double* x, Index begin, Index end,
                           double* y) {
  const double* values = A.values.data();
  const std::int32_t* column = A.column.data();
  for (Index i = begin; i < end; ++i, y += 3) {
    // of the three columns of the blocks; the fourth entry is the next column's
    Four y0{}, y1{}, y2{};
    for (std::int64_t b = A.first[i]; b < A.first[i + 1]; ++b) {
      const double* block = values + 9 * b;
      const double* u = x + 3 * static_cast<Index>(column[b]);
      y0 += four(block)->v * u[0];
      y1 += four(block + 3)->v * u[1];
      y2 += four(block + 6)->v * u[2];
    }
    y0 += y1 + y2;
    y[0] = y0[0];
    y[1] = y0[1];
    y[2] = y0[2];
  }
}

// y += B^T u: the fourth number of y gets what nobody reads.
CBR_INLINE void add_transposed(const double* block, const double* u, double* y) {
  StoredFour& to = *reinterpret_cast<StoredFour*>(y);
  to.v = to.v + (four(block)->v * u[0] + four(block + 3)->v * u[1] + four(block + 6)->v * u[2]);
}

CBR_INLINE void symmetric_rows(const SymmetricBlockMatrix& A, const double* x, Index begin,
                               Index end, double* y, Index y_begin, double* f, Index stride) {
  const double* values = A.values.data();
  const std::int32_t* column = A.column.data();
  for (Index i = begin; i < end; ++i) {
    std::int64_t b = A.first[i];
    const double own[3] = {x[4 * i], x[4 * i + 1], x[4 * i + 2]};
    // Sums over the three rows of the blocks, of four columns each; the fourth is the next row's,
    // times zero
    Four u = four(x + 4 * i)->v;
    Four s0 = four(values + 9 * b)->v * u, s1 = four(values + 9 * b + 3)->v * u,
         s2 = four(values + 9 * b + 6)->v * u;
    for (++b; b < A.first[i + 1]; ++b) {
      const double* block = values + 9 * b;
      const Index j = column[b];
      u = four(x + 4 * j)->v;
      s0 += four(block)->v * u;
      s1 += four(block + 3)->v * u;
      s2 += four(block + 6)->v * u;
      add_transposed(block, own, y + 4 * (j - y_begin));
    }
    double* row = y + 4 * (i - y_begin);
    double* to = f + (i - begin);
    to[0] = row[0] + ((s0[0] + s0[1]) + s0[2]);
    to[stride] = row[1] + ((s1[0] + s1[1]) + s1[2]);
    to[2 * stride] = row[2] + ((s2[0] + s2[1]) + s2[2]);
    reinterpret_cast<StoredFour*>(row)->v = Four{};
  }
}

CBR_INLINE void carry(const SymmetricBlockMatrix& A, const double* x, Index begin, Index end,
                      double* y) {
  const auto column = A.column.begin();
  for (Index i = begin; i < end; ++i) {
    const double own[3] = {x[4 * i], x[4 * i + 1], x[4 * i + 2]};
    const auto from = std::lower_bound(column + A.first[i], column + A.first[i + 1],
                                       static_cast<std::int32_t>(end));
    for (auto at = from; at < column + A.first[i + 1]; ++at)
      add_transposed(A.values.data() + 9 * (at - column), own, y + 4 * (*at - end));
  }
}

// The levels x86-64-v3 and v4 by their parts: clang knows the levels' names from version 18 on.
#ifdef __x86_64__
#define CBR_V3 "avx2,fma,bmi,bmi2,f16c,lzcnt,movbe"
#define CBR_V4 CBR_V3 ",avx512f,avx512bw,avx512cd,avx512dq,avx512vl"

int level_of_machine() {
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi2");
  const bool v4 = v3 && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return v4 ? 4 : v3 ? 3 : 1;
}

const int level = level_of_machine();
#endif

}  // namespace

// A function of mesh_kernels.hpp: LOOP is compiled for all levels, and that of the machine runs.
#ifdef __x86_64__
#define CBR_KERNEL(NAME, LOOP, PARAMETERS, ARGUMENTS)                                  \
  static __attribute__((target(CBR_V3))) void NAME##_v3 PARAMETERS { LOOP ARGUMENTS; } \
  static __attribute__((target(CBR_V4))) void NAME##_v4 PARAMETERS { LOOP ARGUMENTS; } \
  void NAME PARAMETERS {                                                               \
    if (level == 4) return NAME##_v4 ARGUMENTS;                                        \
    if (level == 3) return NAME##_v3 ARGUMENTS;                                        \
    LOOP ARGUMENTS;                                                                    \
  }
#else
#define CBR_KERNEL(NAME, LOOP, PARAMETERS, ARGUMENTS) \
  void NAME PARAMETERS { LOOP ARGUMENTS; }
#endif

CBR_KERNEL(add_box_forces, add_boxes,
           (const SharedElements& shared, std::size_t first, std::size_t last, const double* u,
            Index u_stride, double* f, Index f_stride, Index f_begin),
           (shared, first, last, u, u_stride, f, f_stride, f_begin))
CBR_KERNEL(block_products, block_rows,
           (const BlockMatrix& A, const double* x, Index begin, Index end, double* y),
           (A, x, begin, end, y))
CBR_KERNEL(symmetric_block_products, symmetric_rows,
           (const SymmetricBlockMatrix& A, const double* x, Index begin, Index end, double* y,
            Index y_begin, double* f, Index stride),
           (A, x, begin, end, y, y_begin, f, stride))
CBR_KERNEL(symmetric_block_carry, carry,
           (const SymmetricBlockMatrix& A, const double* x, Index begin, Index end, double* y),
           (A, x, begin, end, y))
CBR_KERNEL(leapfrog, leap, (const LeapfrogSpan& span, Index n, double s, double h), (span, n, s, h))
CBR_KERNEL(turned_strain, strain,
           (const double* u, const double* Y, Index stride, const double* A, const double* B,
            const double* shift, double* d, Index n),
           (u, Y, stride, A, B, shift, d, n))
CBR_KERNEL(moment_sums, moments,
           (const double* Y, const double* d, const double* f, Index stride, Index n, double* sums),
           (Y, d, f, stride, n, sums))
CBR_KERNEL(fit_sums, fits,
           (const double* u, const double* arms, const double* mass, Index stride, Index n,
            double* sums),
           (u, arms, mass, stride, n, sums))
CBR_KERNEL(turned_leapfrog, leap_any_turned,
           (const TurnedSpan& span, Index stride, Index n, const double* R, const double* W,
            double s, double h, double* sums),
           (span, stride, n, R, W, s, h, sums))

}  // namespace cbr

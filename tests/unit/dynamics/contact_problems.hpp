// SPDX-License-Identifier: GPL-3.0-or-later
// Problems of contact impulses for tests and benchmarks, and a check of their solutions that shares
// no code with the solver.
#pragma once

#include <random>
#include <vector>

#include "dynamics/contact/solve/contact_solver.hpp"

namespace cbr::test {

Matrix random_matrix(std::mt19937& random, Index rows, Index columns);

GapResponse dense(Matrix W);

GapResponse sparse(SparseMatrix W);

std::vector<PointLaw> all(Index n, ContactLaw law, double friction = 0);

struct Verdict {
  // largest violation, lengths relative to |g|, impulses relative to the largest
  double law = 0;
  double gap = 0;  // |gap - (g + W p)| relative to |g|
  Index open = 0, stick = 0, slide = 0;
};

// Checks each law by its definition. A point slides if its tangential impulse is within 1e-9 of the
// cone's edge.
Verdict judge(const GapResponse& W, const std::vector<PointLaw>& laws, const Vector& g,
              const ContactSolution& s);

// n x n points, spacing 1, of one law: W, and the gaps of a ball with a uniform and a rotational
// slip.
struct Press {
  GapResponse W;
  std::vector<PointLaw> laws;
  Vector g;
};

// Blocks T_i T_j^T k(distance), T_i = I + a small smooth part: positive definite, normal and
// tangential rows coupled.
Matrix3 mixing(double x, double y);

// Gaps of a ball; `radius`: of its penetrating circle, relative to the side.
Vector ball_gaps(Index n, ContactLaw law, double radius);

// A dense W. `soft`: half-space under a static load (condition of the order of n), else under a
// short step, exp(-distance).
Press dense_press(Index n, ContactLaw law, double friction, bool soft, double radius = 0.6);

// Lumped meshes: each point lies in a face of a master grid of n + 1 x n + 1 nodes. W = 1/m_s I + N
// M^-1 N^T, N bilinear, three directions mixed by T_i.
Press sparse_press(Index n, ContactLaw law, double friction, double radius = 0.6);

}  // namespace cbr::test

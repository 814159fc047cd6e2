// SPDX-License-Identifier: GPL-3.0-or-later
// Milliseconds of one explicit step of the two blocks of T1 as full meshes (20 r x 10 r x 15 r
// hexes each, one model for both), for each way to form K u and each number of threads, beside what
// the machine allows: bytes that have to be read and written over the rate of a triad, or
// operations over the rate of dgemm, whichever is more. `tets`: each hex cut into six. `distorted`:
// no two hexes alike. of_turning: a step of the blocks where they turn by any angle over one of
// theirs as linear bodies, the median of runs in turns. Arguments: values of r (default 1 2);
// --threads N (default 2); --short: a few steps only. CSV to stdout.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "common/linalg/blas_threads.hpp"
#include "tests/benchmarks/seconds.hpp"
#include "tests/unit/dynamics/bricks.hpp"

namespace {

using cbr::Index;
using cbr::MeshForces;

struct Rates {
  double bytes, operations;  // per second
};

// `bytes` of three arrays together: as large as what a step reads, so that both are in the same
// level of the memory.
Rates machine(int n_threads, double bytes, double operations) {
  const Index n = static_cast<Index>(bytes / 24);
  std::vector<double> a(n, 1), b(n, 2), c(n, 3);
  cbr::RowThreads threads(n_threads);
  const double t = seconds(20, [&] {
    threads.for_rows(n, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i) a[i] = b[i] + 1.5 * c[i];
    });
  });
  return {24 * static_cast<double>(n) / t, operations};
}

double dgemm_rate() {
  const cbr::SingleThreadedBlas single;
  const Index n = 768;
  const cbr::Matrix A = cbr::Matrix::Random(n, n), B = cbr::Matrix::Random(n, n);
  cbr::Matrix C(n, n);
  const double t = seconds(5, [&] { C.noalias() = A * B; });
  return 2 * static_cast<double>(n * n * n) / t;
}

cbr::Mesh cut_into_tets(const cbr::Mesh& hexes) {
  constexpr int tets[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                              {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
  cbr::Mesh mesh = hexes;
  cbr::Block& block = mesh.blocks[0];
  const cbr::IndexTable of_hexes = block.connectivity;
  block.type = cbr::ElementType::tet4;
  block.connectivity.resize(6 * of_hexes.rows(), 4);
  block.element_ids.clear();
  for (Index e = 0; e < block.connectivity.rows(); ++e) {
    for (int k = 0; k < 4; ++k) block.connectivity(e, k) = of_hexes(e / 6, tets[e % 6][k]);
    block.element_ids.push_back(e + 1);
  }
  mesh.sidesets.clear();
  return mesh;
}

struct Options {
  int threads = 2;
  bool is_short = false;
};

// The two blocks. They fly with a wave inside: as in T1, and without subnormal numbers, which are
// slow.
struct Blocks {
  Blocks(const std::shared_ptr<const cbr::MeshModel>& model,
         const std::shared_ptr<cbr::RowThreads>& threads, double step, bool turn)
      : t(step), h(step) {
    cbr::Placement flying;
    flying.velocity = cbr::Vector3(3810, 0, 0);
    for (const char* name : {"a", "b"}) {
      cbr::MeshOptions options;
      if (turn) options.angular_velocity = cbr::Vector3(300, 200, 100);
      bodies.push_back(std::make_unique<cbr::MeshBody>(
          name, model, flying, std::vector<cbr::HeldDirection>{}, threads, std::move(options)));
      cbr::MeshBody& body = *bodies.back();
      const Index set = body.track({0});
      body.predict(0, h);
      body.add_impulses(set, cbr::Points::Constant(1, 3, 1e-3));
      body.accept();
    }
  }
  void step(int n) {
    for (int k = 0; k < n; ++k, t += h)
      for (const auto& body : bodies) {
        body->predict(t, h);
        body->accept();
      }
  }

  std::vector<std::unique_ptr<cbr::MeshBody>> bodies;
  double t, h;
};

void row(int r, const char* mesh_name, const char* name, MeshForces::Variant variant,
         const cbr::Mesh& mesh, const cbr::FiniteElementModel& fe,
         const std::vector<cbr::BlockProperties>& properties, int n_threads, double dgemm,
         const Options& options) {
  const cbr::Points X = mesh.coordinates(fe.nodes, Eigen::all);
  MeshForces forces;
  std::shared_ptr<const cbr::MeshModel> model;
  const double forces_time = seconds([&] { forces = MeshForces(fe, mesh, properties, variant); });
  const double bytes = forces.bytes(), operations = forces.operations();
  const double model_time = seconds([&] {
    model = std::make_shared<cbr::MeshModel>(cbr::mesh_model(fe, X, true, std::move(forces)));
  });
  const auto threads = std::make_shared<cbr::RowThreads>(n_threads);
  const double h = 1.8 / model->largest_frequency;
  Blocks still(model, threads, h, false), turning(model, threads, h, true);
  const double n = static_cast<double>(X.rows());
  const int steps = options.is_short ? 2 : std::max(10, static_cast<int>(2e6 / n));
  double time = HUGE_VAL;
  std::vector<double> ratios;
  for (int i = 0; i < (options.is_short ? 1 : 15); ++i) {
    const double of_still = seconds([&] { still.step(steps); }),
                 of_turning = seconds([&] { turning.step(steps); });
    time = std::min(time, of_still / steps);
    ratios.push_back(of_turning / of_still);
  }
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2),
                   ratios.end());
  const double of_turning = ratios[ratios.size() / 2];
  // Fields of a step: u, v and 1 / m are read, v and u_end written (each line is read before it is
  // written)
  const double all_bytes = 2 * (bytes + n * 8 * (3 + 3 + 1 + 3 + 6)),
               all_operations = 2 * (operations + 24 * n);
  const Rates rates = machine(n_threads, all_bytes, dgemm * n_threads);
  const double limit = std::max(all_bytes / rates.bytes, all_operations / rates.operations);
  std::printf("%d,%s,%s,%d,%lld,%.4f,%.3f,%.3f,%.2f,%.2f,%.1f,%.1f,%.3f,%.3f,%.4f,%.4f,%.6g\n", r,
              mesh_name, name, n_threads, static_cast<long long>(X.rows()), 1e3 * time,
              1e-6 * all_bytes, 1e-6 * all_operations, 1e-9 * all_bytes / time,
              1e-9 * all_operations / time, 1e-9 * rates.bytes, 1e-9 * rates.operations,
              limit / time, of_turning, forces_time, model_time, 2 / model->largest_frequency);
  std::fflush(stdout);
}

void rows(int r, const Options& options, double dgemm) {
  const cbr::Material steel{5.17e12, 0.3, 7836};
  const std::vector<cbr::BlockProperties> properties{{steel, cbr::HexFormulation::incompatible}};
  const cbr::Mesh hexes =
      cbr::test::brick({20 * r, 10 * r, 15 * r}, cbr::Vector3(0.0508, 0.0254, 0.0381));
  cbr::Mesh distorted = hexes;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-1e-4 / r, 1e-4 / r);
  for (Index i = 0; i < distorted.coordinates.size(); ++i)
    distorted.coordinates.data()[i] += shift(random);
  const auto variants = [&](const char* name, const cbr::Mesh& mesh, bool shared) {
    const cbr::FiniteElementModel fe = assemble(mesh, properties, cbr::MassKind::lumped);
    for (int n_threads = 1; n_threads <= options.threads; n_threads *= 2) {
      row(r, name, "assembled", MeshForces::Variant::assembled, mesh, fe, properties, n_threads,
          dgemm, options);
      if (shared)
        row(r, name, "shared", MeshForces::Variant::shared, mesh, fe, properties, n_threads, dgemm,
            options);
    }
  };
  variants("hexes", hexes, true);
  if (r > 2) return;  // what is assembled goes with the number of nodes: nothing new
  variants("distorted", distorted, false);
  variants("tets", cut_into_tets(hexes), false);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--short")) {
      options.is_short = true;
    } else if (!std::strcmp(argv[i], "--threads") && i + 1 < argc) {
      options.threads = std::atoi(argv[++i]);
    } else {
      sizes.push_back(std::atoi(argv[i]));
    }
  }
  if (sizes.empty()) sizes = {1, 2};
  std::printf(
      "r,mesh,variant,threads,nodes,ms_per_step,mbytes,mflop,gbytes_per_s,gflop_per_s,triad_gbytes_"
      "per_s,dgemm_gflop_per_s,"
      "share_of_limit,of_turning,forces_setup_s,model_setup_s,critical_step_s\n");
  const double dgemm = dgemm_rate();
  for (const int r : sizes) rows(r, options, dgemm);
}

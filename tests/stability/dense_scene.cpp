// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/stability/dense_scene.hpp"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "common/fem/elements/shell.hpp"
#include "common/linalg/dense.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/setup/components/geometry.hpp"

namespace cbr::test {
namespace {

std::vector<BlockProperties> properties(const RandomBody& b) {
  std::vector<BlockProperties> list;
  for (const Block& block : b.mesh.blocks)
    list.push_back(
        {block.name.rfind("low", 0) == 0 ? b.low : b.high, *value_of(hex_words, b.element)});
  return list;
}

std::string before_dot(const std::string& name) { return name.substr(0, name.find('.')); }
std::string after_dot(const std::string& name) { return name.substr(name.find('.') + 1); }

// "friction: 0.3"
double number(const std::string& options, const std::string& key) {
  const auto at = options.find(key + ": ");
  return at == std::string::npos ? 0 : std::atof(options.c_str() + at + key.size() + 2);
}
bool has(const std::string& options, const std::string& words) {
  return options.find(words) != std::string::npos;
}

std::vector<Index> free_coordinates(const RandomScene& scene, const Geometry& geometry,
                                    std::size_t i, const Matrix& B) {
  std::vector<char> held(B.cols(), 0);
  for (const std::string& name : scene.held) {
    if (before_dot(name) != scene.bodies[i].name) continue;
    for (const Index node : geometry.nodesets.at(after_dot(name)))
      for (Index j = 0; j < B.cols(); ++j)
        if (!B.block(3 * node, j, 3, 1).isZero(0)) held[j] = 1;
  }
  std::vector<Index> free;
  for (Index j = 0; j < B.cols(); ++j)
    if (!held[j]) free.push_back(j);
  return free;
}

// Matrices over all coordinates, component axes. B: to displacements of the visible nodes; `rigid`:
// coordinates x 3, translations.
struct Coordinates {
  Matrix K, M, B, rigid;
};

// Rows and columns of zeros: coordinates that nothing sees yet.
Matrix grown(const Matrix& A, Index rows, Index columns) {
  Matrix B = Matrix::Zero(A.rows() + rows, A.cols() + columns);
  B.topLeftCorner(A.rows(), A.cols()) = A;
  return B;
}

// Shells share the nodes' displacements; their rotations are coordinates of their own.
void add_shells(const RandomScene& scene, const Geometry& geometry, const RandomBody& b,
                Coordinates& all) {
  if (!scene.skin || before_dot(*scene.skin) != b.name) return;
  const DenseSurface surface =
      dense_surface(0, geometry.surfaces.at(after_dot(*scene.skin)).faces, geometry.coordinates);
  const Index first = all.K.rows(), n = 3 * static_cast<Index>(surface.nodes.size());
  all.K = grown(all.K, n, n);
  all.M = grown(all.M, n, n);
  all.B = grown(all.B, 0, n);
  all.rigid = grown(all.rigid, n, 0);
  for (const auto& face : surface.faces) {
    const bool triangle = face[2] == face[3];
    std::vector<Index> nodes(face.begin(), face.end());
    if (triangle) nodes.pop_back();
    std::vector<Index> at;
    for (const Index node : nodes) {
      for (Index c = 0; c < 3; ++c) {
        Index column = 0;
        all.B.row(3 * node + c).cwiseAbs().maxCoeff(&column);
        at.push_back(column);
      }
      const Index place = std::lower_bound(surface.nodes.begin(), surface.nodes.end(), node) -
                          surface.nodes.begin();
      for (Index c = 0; c < 3; ++c) at.push_back(first + 3 * place + c);
    }
    const ElementType type = triangle ? ElementType::tri3 : ElementType::quad4;
    const Points X = geometry.coordinates(nodes, Eigen::all);
    all.K(at, at) += shell_stiffness(type, X, random_skin);
    const ShellMass mass = shell_lumped_mass(type, X, random_skin);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t c = 0; c < 3; ++c) {
        all.M(at[6 * a + c], at[6 * a + c]) += mass.mass[static_cast<Index>(a)];
        all.M(at[6 * a + 3 + c], at[6 * a + 3 + c]) += mass.rotary[static_cast<Index>(a)];
      }
  }
}

DenseBody placed(const RandomScene& scene, const Ran& ran, std::size_t i, Coordinates all) {
  const RandomBody& b = scene.bodies[i];
  add_shells(scene, *ran.built.instances[i].geometry, b, all);
  const auto& [K, M, B, rigid] = all;
  const Geometry& geometry = *ran.built.instances[i].geometry;
  const Matrix3& T = b.rotation;
  DenseBody body;
  const Index n = geometry.coordinates.rows();
  body.X = (geometry.coordinates * T.transpose()).rowwise() + b.position.transpose();
  Matrix TB(B.rows(), B.cols());
  for (Index node = 0; node < n; ++node) TB.middleRows(3 * node, 3) = T * B.middleRows(3 * node, 3);
  const std::vector<Index> free = free_coordinates(scene, geometry, i, B);
  body.K = K(free, free);
  body.M = M(free, free);
  body.B = TB(Eigen::all, free);
  // What supports that take hold at once leave
  body.velocity = Cholesky(body.M).solve(Vector(M * (rigid * (T.transpose() * b.velocity)))(free));
  for (const auto& load : scene.loads) {
    Vector f;
    if (load.kind == "gravity") {
      f = Vector(M * (rigid * (T.transpose() * load.value)))(free);
    } else if (load.instance == b.name) {
      const Vector weights = face_weights(geometry.surfaces.at(load.surface), geometry.coordinates);
      const RowMatrix forces =
          weights *
          (load.kind == "force" ? Vector3(load.value / weights.sum()) : load.value).transpose();
      f = body.B.transpose() * forces.reshaped<Eigen::RowMajor>();
    } else {
      continue;
    }
    body.load.push_back(f);
    body.history.push_back({load.time, load.factor});
  }
  return body;
}

DenseSurface surface_of(const RandomScene& scene, const Ran& ran, const std::string& name) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const RandomBody& b = scene.bodies[i];
    if (b.name != before_dot(name)) continue;
    const Geometry& geometry = *ran.built.instances[i].geometry;
    const Points X =
        (geometry.coordinates * b.rotation.transpose()).rowwise() + b.position.transpose();
    return dense_surface(static_cast<Index>(i), geometry.surfaces.at(after_dot(name)).faces, X);
  }
  throw std::runtime_error("no body of " + name);
}

DenseWall wall_of(const RandomWall& w) {
  using Kind = DenseWall::Kind;
  return {w.kind == "plane"    ? Kind::plane
          : w.kind == "sphere" ? Kind::sphere
                               : Kind::cylinder,
          w.point, w.direction, w.radius};
}

}  // namespace

DenseModel dense_model(const RandomBody& body) {
  return dense_model(body.mesh, properties(body),
                     body.mass == "lumped" ? MassKind::lumped : MassKind::consistent);
}

DenseReduction dense_reduction(const RandomBody& body, const DenseModel& model,
                               const Superelement& s) {
  std::vector<Index> dofs;
  for (std::size_t i = 0; i < s.dof_node.size(); ++i) {
    const Index id = s.node_ids[s.dof_node[i]];
    const auto node = std::find(body.mesh.node_ids.begin(), body.mesh.node_ids.end(), id) -
                      body.mesh.node_ids.begin();
    const auto place =
        std::lower_bound(model.nodes.begin(), model.nodes.end(), node) - model.nodes.begin();
    dofs.push_back(3 * place + s.dof_component[i]);
  }
  return dense_reduction(model, dofs, body.modes, body.pick);
}

bool is_of(const RandomPair& pair, const RandomBody& body) {
  return before_dot(pair.first) == body.name || before_dot(pair.second) == body.name;
}

DenseBody dense_body(const RandomScene& scene, const Ran& ran, std::size_t i,
                     const DenseModel& model) {
  const Index n = model.K.rows();
  DenseBody body =
      placed(scene, ran, i,
             {model.K, model.M, Matrix::Identity(n, n), Matrix3::Identity().replicate(n / 3, 1)});
  body.scheme =
      scene.integrator == "newmark" ? DenseBody::Scheme::newmark : DenseBody::Scheme::central;
  return body;
}

DenseBody dense_body(const RandomScene& scene, const Ran& ran, std::size_t i, const Superelement& s,
                     const DenseReduction& reduced) {
  const Index n_nodes = s.node_ids.size();
  Matrix B = Matrix::Zero(3 * n_nodes, s.n()), rigid = Matrix::Zero(s.n(), 3);
  for (Index j = 0; j < s.c(); ++j) {
    B(3 * s.dof_node[j] + s.dof_component[j], s.k() + j) = 1;
    rigid(s.k() + j, s.dof_component[j]) = 1;
  }
  DenseBody body = placed(scene, ran, i, {reduced.K(), reduced.M(), B, rigid});
  body.scheme = scene.integrator == "exact"     ? DenseBody::Scheme::exact
                : scene.integrator == "newmark" ? DenseBody::Scheme::newmark
                                                : DenseBody::Scheme::central;
  // Those that only impulses meet
  const auto its = [&](const RandomPair& pair) { return is_of(pair, scene.bodies[i]); };
  body.lasting = body.scheme == DenseBody::Scheme::exact &&
                 std::any_of(scene.pairs.begin(), scene.pairs.end(), its) &&
                 std::none_of(scene.pairs.begin(), scene.pairs.end(), [&](const RandomPair& pair) {
                   return its(pair) && has(pair.options, "penalty");
                 });
  return body;
}

std::vector<DensePair> dense_pairs(const RandomScene& scene, const Ran& ran) {
  std::vector<DensePair> list;
  for (const RandomPair& of : scene.pairs) {
    DensePair pair;
    pair.slave = surface_of(scene, ran, of.first);
    if (of.second == "wall") {
      pair.wall = wall_of(scene.walls.front());
    } else {
      pair.master = surface_of(scene, ran, of.second);
      // The finer surface's nodes; of equal ones the first's
      if (pair.master->size < pair.slave.size * (1 - 1e-6)) std::swap(pair.slave, *pair.master);
    }
    pair.penalty = has(of.options, "penalty");
    pair.two_way = has(of.options, "two-way");
    pair.friction = number(of.options, "friction");
    pair.damping = number(of.options, "damping");
    list.push_back(pair);
  }
  return list;
}

}  // namespace cbr::test

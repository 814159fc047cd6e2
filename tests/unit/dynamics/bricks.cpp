// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/dynamics/bricks.hpp"

#include <Eigen/LU>

#include <algorithm>

#include "tests/support/block_mesh.hpp"

namespace cbr::test {

Mesh brick(std::array<Index, 3> n, const Vector3& size) {
  Mesh mesh = block_mesh({n, size});
  const Sideset surface = surface_of(mesh, 3);
  mesh.sidesets.resize(2);
  mesh.sidesets.push_back(surface);
  return mesh;
}

Brick make_brick(std::array<Index, 3> n, const Vector3& size, const Material& material,
                 MassKind mass) {
  Brick b;
  b.mesh = brick(n, size);
  b.fe = assemble(b.mesh, {{material, HexFormulation::incompatible}}, mass);
  b.geometry = geometry_of(b.mesh, b.fe);
  return b;
}

Lattice as_lattice(const Brick& b, std::array<Index, 3> n) {
  Lattice body;
  body.points = b.geometry.coordinates;
  body.K = Matrix(b.fe.K);
  body.mass.resize(body.points.rows());
  for (Index i = 0; i < body.mass.size(); ++i) body.mass[i] = b.fe.M.coeff(3 * i, 3 * i);
  body.n = {n[0] + 1, n[1] + 1, n[2] + 1};
  return body;
}

std::unique_ptr<Body> make_body(const std::string& name, const Part& part, Geometry& geometry) {
  const Brick b = make_brick(part.n, part.size, part.material, part.mass);
  if (part.mesh) {
    geometry = b.geometry;
    return std::make_unique<MeshBody>(
        name,
        std::make_shared<MeshModel>(
            mesh_model(b.fe, b.geometry.coordinates, part.mass == MassKind::lumped)),
        part.placement, std::vector<HeldDirection>{}, std::make_shared<RowThreads>(1));
  }
  const Lattice full = as_lattice(b, part.n);
  const auto nodes = x_nodes(full, part.both_faces || part.face == "x_min",
                             part.both_faces || part.face == "x_max");
  const Index interior = 3 * (full.mass.size() - static_cast<Index>(nodes.size()));
  const Model m = model(reduce(full, nodes, std::min(part.modes, interior)));
  geometry = geometry_of(*m.superelement);
  return std::make_unique<ModalBody>(name, m.superelement, m.form, part.placement, part.scheme);
}

Simulation two_bodies(const Part& a, const Part& b, Enforcement enforcement, double end,
                      double every, double share) {
  Simulation sim;
  sim.pairs.resize(1);
  sim.pairs[0].name = "a - b";
  sim.pairs[0].enforcement = enforcement;
  double h = 1e300;
  const Part* parts[] = {&a, &b};
  for (Index i = 0; i < 2; ++i) {
    Geometry geometry;
    sim.bodies.push_back(make_body(i == 0 ? "a" : "b", *parts[i], geometry));
    const Surface& face = geometry.surfaces.at(parts[i]->face);
    ContactNodes contact;
    contact.body = i;
    contact.nodes = surface_nodes(face);
    contact.set = sim.bodies[i]->track(contact.nodes);
    ContactSurface surface;
    surface.name = i == 0 ? "a" : "b";
    surface.body = i;
    surface.faces = linear_faces(face).faces;
    for (Index k = 0; k < surface.faces.size(); ++k) {
      Index& node = surface.faces.data()[k];
      node = std::lower_bound(contact.nodes.begin(), contact.nodes.end(), node) -
             contact.nodes.begin();
    }
    if (parts[i]->placement.T.determinant() < 0)
      for (Index f = 0; f < surface.faces.rows(); ++f)
        std::swap(surface.faces(f, 1), surface.faces(f, 3));
    for (std::size_t k = 0; k < contact.nodes.size(); ++k)
      surface.nodes.push_back(static_cast<Index>(k));
    fill_sizes(surface, sim.bodies[i]->reference_positions()(contact.nodes, Eigen::all));
    Monitor monitor;
    monitor.name = surface.name;
    monitor.body = monitor.contact = i;
    monitor.mean_set = sim.bodies[i]->track_mean(contact.nodes);
    monitor.contact_slots = surface.nodes;
    sim.monitors.push_back(monitor);
    sim.contact_nodes.push_back(contact);
    (i == 0 ? sim.pairs[0].slave : sim.pairs[0].master) =
        std::make_shared<const ContactSurface>(std::move(surface));
    h = std::min(h, share * critical_step(*sim.bodies[i], true));
  }
  sim.plan = fit_steps(h, every, end);
  return sim;
}

}  // namespace cbr::test

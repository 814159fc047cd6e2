// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/contact/contact_setup.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <vector>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"

namespace cbr {
namespace {

// Directions with a smaller fraction of the largest count as dependent.
constexpr double weakest_shape = 1e-6;

struct Shapes {
  Index found = 0, wanted = 0;
};

// Rank and number of the interface rows of a face; empty for other bases.
Shapes shapes_of(const ReducedPart& part, const std::vector<char>& on_face) {
  const Superelement& s = *part.superelement;
  std::vector<Index> rows;
  for (Index i = 0; i < s.c(); ++i)
    if (on_face[part.node[s.dof_node[i]]] != 0) rows.push_back(i);
  if (s.characteristic.V.rows() != s.c() || rows.empty()) return {};
  const PivotedQr qr(s.characteristic.V(rows, Eigen::all), weakest_shape);
  return {qr.rank(), static_cast<Index>(rows.size())};
}

// Residual compliance of a face. None: at no node; normal: at some node in fewer than three
// directions; all: complete. Retained nodes have none, as they have no residual.
enum class Statics : char { none, normal, all };

Statics statics_of(const ReducedPart& part, const std::vector<char>& on_face) {
  const StaticShare& statics = part.superelement->characteristic.statics;
  std::vector<Matrix3> spanned(on_face.size(), Matrix3::Zero());
  bool any = false;
  for (Index i = 0; i < static_cast<Index>(statics.node.size()); ++i) {
    const auto node = static_cast<std::size_t>(part.node[statics.node[i]]);
    if (on_face[node] == 0) continue;
    any = true;
    spanned[node] += statics.direction.row(i).transpose() * statics.direction.row(i);
  }
  if (!any) return Statics::none;
  const auto is_part = [](const Matrix3& of) {
    return !of.isZero(0) && !(of.determinant() > weakest_shape);
  };
  return std::any_of(spanned.begin(), spanned.end(), is_part) ? Statics::normal : Statics::all;
}

[[noreturn]] void refuse_normals_alone(const ContactPair& pair, const ContactSurface& surface,
                                       const Component& component, const Scene& scene) {
  const std::string cure =
      !component.has_mesh
          ? "make " + component.reduction->superelement.filename().string() +
                " of its mesh again, with cbr-reduce --shear"
          : "run cbr-reduce " + (scene.file == "-" ? "SCENE" : scene.file.string()) + " --force";
  throw InputError(pair.source->text() + ": contact " + pair.name + ": friction on " +
                   surface.name +
                   " needs its statics in all directions, and its superelement (basis: "
                   "characteristic) has them along the normals alone: " +
                   cure);
}

}  // namespace

void look_for_friction_shapes(const ContactPair& pair, const BuiltScene& built, const Scene& scene,
                              Report& report) {
  if (pair.law.law != ContactLaw::coulomb) return;
  for (const ContactSurface* surface : {pair.slave.get(), pair.master.get()}) {
    if (surface->nodes.empty()) continue;  // a wall
    const ContactNodes& contact = built.simulation.contact_nodes[surface->body];
    const BuiltScene::OfInstance& instance = built.instances[contact.body];
    if (instance.parts.size() != 1 || !instance.parts[0].superelement->is_characteristic())
      continue;
    const ReducedPart& part = instance.parts[0];
    const Index n_nodes = built.simulation.bodies[contact.body]->n_nodes();
    std::vector<char> on_face(static_cast<std::size_t>(n_nodes), 0);
    for (const Index node : surface->nodes) on_face[contact.nodes[node]] = 1;
    const Statics statics = statics_of(part, on_face);
    if (statics == Statics::normal)
      refuse_normals_alone(pair, *surface, component_of(scene, scene.instances[contact.body]),
                           scene);
    if (statics == Statics::all) continue;
    const Shapes shapes = shapes_of(part, on_face);
    if (shapes.found == shapes.wanted) continue;
    report.warning(
        pair.source->text() + ": contact " + pair.name + ": friction on " + surface->name +
        ", whose " + std::to_string(shapes.wanted) + " directions move in " +
        std::to_string(shapes.found) +
        " shapes only (basis: characteristic), takes up to several times the energy that it "
        "should: keep the face's statics (characteristic.statics), or take it without friction");
  }
}

}  // namespace cbr

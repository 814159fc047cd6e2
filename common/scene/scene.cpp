// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/base/error.hpp"
#include "common/scene/component_blocks.hpp"

namespace cbr {

Index preload_steps(const Scene& scene) {
  constexpr Index usual = 5;
  if (!scene.time) return 0;
  if (scene.time->preload) return *scene.time->preload;
  const auto needs = [](const ContactOptions& c) {
    return c.pretension_force || c.shortening || c.resolves_overlap || c.interference > 0;
  };
  return std::any_of(scene.contact.begin(), scene.contact.end(), needs) ? usual : 0;
}

namespace {

// Cosine and sine of an angle in degrees, exact at multiples of 90: an instance turned by a right
// angle lies on the axes.
std::pair<double, double> cosine_sine(double degrees) {
  const double turned = std::remainder(degrees, 360.0);  // [-180, 180], exact
  const double quarter = std::round(turned / 90.0);
  const double rest = (turned - 90.0 * quarter) * std::numbers::pi / 180.0;
  const double c = std::cos(rest), s = std::sin(rest);
  switch (static_cast<int>(quarter)) {
    case 0:
      return {c, s};
    case 1:
      return {-s, c};
    case -1:
      return {s, -c};
    default:
      return {-c, -s};
  }
}

// About coordinate axis a, by the right-hand rule.
Matrix3 axis_rotation(int a, double degrees) {
  const auto [c, s] = cosine_sine(degrees);
  const int b = (a + 1) % 3, d = (a + 2) % 3;
  Matrix3 R = Matrix3::Identity();
  R(b, b) = R(d, d) = c;
  R(d, b) = s;
  R(b, d) = -s;
  return R;
}

// Orthotropy::axes
std::optional<Matrix3> axes_of(const FileMaterial& m) {
  if (!m.center) return material_axes(m.axis, m.in_plane);
  // Any two directions across the cylinder's axis
  Index least = 0;
  m.axis.cwiseAbs().minCoeff(&least);
  const std::optional<Matrix3> axes = material_axes(m.axis, Vector3::Unit(least));
  if (!axes) return {};
  Matrix3 turned;
  turned << axes->row(1), axes->row(2), axes->row(0);
  return turned;
}

// Why the material cannot be used; empty: it can.
std::string problem_of(const FileMaterial& m, const std::optional<Orthotropy>& orthotropy) {
  if (!m.problem.empty()) return m.problem;
  if (const std::size_t n = m.engineering_constants.size(); n > 0 && n < 9)
    return "has " + std::to_string(n) + " of nine engineering constants";
  if (orthotropy && !is_definite(*orthotropy))
    return "has engineering constants with which strains exist that give energy";
  if (orthotropy && !axes_of(m)) return "has an *ORIENTATION whose points are zero or on one line";
  if (!orthotropy && !(m.youngs_modulus > 0)) return "has no positive Young's modulus";
  if (!(m.poissons_ratio > -1 && m.poissons_ratio < 0.5))
    return "has a Poisson's ratio that is not between -1 and 0.5";
  return m.density > 0 ? "" : "has no positive density";
}

std::optional<Orthotropy> orthotropy_of(const FileMaterial& m) {
  const std::vector<double>& c = m.engineering_constants;
  if (c.size() < 9) return {};
  return Orthotropy{{c[0], c[1], c[2]},
                    {c[3], c[5], c[4]},
                    {c[6], c[8], c[7]},
                    axes_of(m).value_or(Matrix3::Identity()),
                    m.center};
}

Material material_of_file(const FileMaterial& m, const Component& component, const Block& block) {
  const std::optional<Orthotropy> orthotropy = orthotropy_of(m);
  if (const std::string problem = problem_of(m, orthotropy); !problem.empty())
    throw InputError(component.mesh.string() + ": material '" + m.name + "' of block '" +
                     block.name + "' " + problem + ": give component '" + component.name +
                     "' a material in the scene");
  return {orthotropy ? orthotropy->youngs_moduli.mean() : m.youngs_modulus, m.poissons_ratio,
          m.density, orthotropy};
}

}  // namespace

std::optional<Matrix3> material_axes(const Vector3& axis, const Vector3& in_plane) {
  // Axes that are orthonormal to round-off stay as they are: a scene that is passed on means the
  // same material to the last bit.
  constexpr double round_off = 1e-14, parallel = 1e-6;
  const auto unit = [](const Vector3& v) {
    return std::abs(v.norm() - 1) < round_off ? v : Vector3(v / v.norm());
  };
  const Vector3 first = unit(axis), given = unit(in_plane);
  const double along = first.dot(given);
  if (!(std::abs(along) < 1 - parallel)) return {};
  const Vector3 second = std::abs(along) < round_off ? given : unit(given - along * first);
  Matrix3 axes;
  axes << first.transpose(), second.transpose(), first.cross(second).transpose();
  return axes;
}

std::optional<HexFormulation> element_of(const Component& component,
                                         const Component::BlockOptions* block) {
  return block != nullptr && block->element ? block->element : component.element;
}

std::string SourceLine::text() const { return line > 0 ? file + ":" + std::to_string(line) : file; }

Matrix3 Instance::transformation() const {
  Matrix3 mirroring = Matrix3::Identity();
  if (!mirror.empty()) {
    const int axis = mirror[0] - 'x';
    mirroring(axis, axis) = -1;
  }
  // T = R_z R_y R_x mirror
  return axis_rotation(2, rotation_degrees(2)) * axis_rotation(1, rotation_degrees(1)) *
         axis_rotation(0, rotation_degrees(0)) * mirroring;
}

const Component& component_of(const Scene& scene, const Instance& instance) {
  const auto found = scene.components.find(instance.component);
  if (found != scene.components.end()) return found->second;
  throw InputError(instance.source.text() + ": instances." + instance.name +
                   ": unknown component '" + instance.component + "'");
}

const Component::Point* point_of(const Scene& scene, const std::string& instance,
                                 const std::string& name) {
  for (const Instance& of : scene.instances) {
    if (of.name != instance) continue;
    const auto& points = component_of(scene, of).points;
    const auto found = points.find(name);
    return found == points.end() ? nullptr : &found->second;
  }
  return nullptr;
}

std::vector<std::string> load_sets(const Scene& scene, const Component& component) {
  std::set<std::string> names;
  if (component.reduction)
    names.insert(component.reduction->loads.begin(), component.reduction->loads.end());
  std::set<std::string> reduced;
  for (const Instance& instance : scene.instances)
    if (instance.as == InstanceKind::superelement && instance.component == component.name)
      reduced.insert(instance.name);
  for (const Load& load : scene.loads)
    if (load.kind != Load::Kind::gravity && load.kind != Load::Kind::moment && !load.on_point &&
        reduced.count(load.instance) > 0)
      names.insert(load.surface);
  return {names.begin(), names.end()};
}

bool reads_diagonal_form(const Scene& scene, const Component& component) {
  if (!scene.time) return true;
  std::set<std::string> held;
  for (const BoundaryCondition& condition : scene.boundary) held.insert(condition.instance);
  return std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& instance) {
    return instance.as == InstanceKind::superelement && instance.component == component.name &&
           held.count(instance.name) == 0;
  });
}

namespace {

void add_load(const Load& load, InterfaceNeeds& needs) {
  LoadKinds& kinds = needs.loaded[load.surface];
  switch (load.kind) {
    case Load::Kind::traction:
    case Load::Kind::force:
      kinds.forces = true;
      break;
    case Load::Kind::pressure:
      kinds.pressure = true;
      break;
    case Load::Kind::moment:
      kinds.moments = true;
      break;
    case Load::Kind::gravity:
      break;
  }
}

// Loads, links, masses and springs act on a point by forces and moments on its set.
void add_points(const Component& component, InterfaceNeeds& needs, std::set<std::string>& held) {
  for (const auto& [name, point] : component.points) {
    if (point.rigid) {
      held.insert(point.nodes);
    } else {
      needs.loaded[point.nodes] = {true, needs.loaded[point.nodes].pressure, true};
    }
  }
}

}  // namespace

InterfaceNeeds interface_needs(const Scene& scene, const Component& component) {
  InterfaceNeeds needs;
  if (scene.file.empty() && component.reduction) {
    for (const std::string& name : component.reduction->interface_sets)
      needs.touching[name] = false;
    return needs;
  }
  std::set<std::string> reduced, held;
  for (const Instance& instance : scene.instances)
    if (instance.as == InstanceKind::superelement && instance.component == component.name)
      reduced.insert(instance.name);
  for (const ContactOptions& contact : scene.contact) {
    const bool slides = contact.friction.at_rest > 0;
    if (contact.all && !reduced.empty())
      needs.all_touch = needs.all_touch.value_or(false) || slides;
    if (contact.all) continue;
    for (const SurfaceName* surface : {&contact.first, &contact.second}) {
      if (reduced.count(surface->instance) == 0) continue;
      if (contact.tied) {
        held.insert(surface->surface);
      } else {
        needs.touching[surface->surface] |= slides;
      }
    }
  }
  for (const BoundaryCondition& condition : scene.boundary)
    if (reduced.count(condition.instance) > 0) held.insert(condition.nodes);
  if (!reduced.empty()) add_points(component, needs, held);
  for (const Load& load : scene.loads)
    if (reduced.count(load.instance) > 0 && !load.on_point) add_load(load, needs);
  for (const SurfaceName& of : scene.output.history)
    if (reduced.contains(of.instance) && !held.contains(of.surface) && !needs.all_touch &&
        !needs.touching.contains(of.surface) && !component.points.contains(of.surface))
      needs.loaded[of.surface].means = true;
  needs.held.assign(held.begin(), held.end());
  return needs;
}

namespace {

// Faces of shells as sidesets: of a block by its name, and turned over as NAME.back. Names that the
// mesh has stay what they are.
void add_faces_of_shells(Mesh& mesh) {
  Index id = 0;
  for (const Sideset& sideset : mesh.sidesets) id = std::max(id, sideset.id);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    if (!(block.thickness > 0)) continue;
    for (const int side : {1, 2}) {
      Sideset faces{block.name + (side == 1 ? "" : ".back"), ++id, {}};
      if (find_sideset(mesh, faces.name) >= 0 || find_nodeset(mesh, faces.name) >= 0) continue;
      for (Index e = 0; e < block.connectivity.rows(); ++e)
        faces.sides.push_back({static_cast<Index>(b), e, side});
      mesh.sidesets.push_back(std::move(faces));
    }
  }
}

// Sidesets of edges of shells have no faces: their nodes are a nodeset.
void make_nodesets_of_edges(Mesh& mesh) {
  const auto is_edge = [&](const Side& side) {
    return mesh.blocks[side.block].thickness > 0 && side.side > 2;
  };
  Index id = 0;
  for (const Nodeset& nodeset : mesh.nodesets) id = std::max(id, nodeset.id);
  std::vector<Sideset> sidesets;
  for (Sideset& sideset : mesh.sidesets) {
    const bool is_of_edges =
        !sideset.sides.empty() && std::all_of(sideset.sides.begin(), sideset.sides.end(), is_edge);
    if (is_of_edges && find_nodeset(mesh, sideset.name) < 0)
      mesh.nodesets.push_back({sideset.name, ++id, set_nodes(mesh, sideset.name)});
    if (!is_of_edges) sidesets.push_back(std::move(sideset));
  }
  mesh.sidesets = std::move(sidesets);
}

}  // namespace

void mark_shells(const Component& component, Mesh& mesh) {
  for (const auto& [named, options] : component.blocks) {
    const Index found = find_block(mesh, named);
    if (!options.thickness || found < 0) continue;
    Block& block = mesh.blocks[found];
    if (block.type != ElementType::tri3 && block.type != ElementType::quad4)
      throw InputError(options.source.text() + ": components." + component.name + ".blocks." +
                       named + ".thickness: the block is of " + std::string(name(block.type)) +
                       "; only tri3 and quad4 are shells: " +
                       (dimension(block.type) == 3
                            ? "take thickness out"
                            : "mesh it with linear elements, or take the block out of the scene"));
    block.thickness = *options.thickness;
  }
}

Mesh read_mesh(const Component& component) {
  Mesh mesh = read_mesh(component.mesh);
  mark_shells(component, mesh);
  make_nodesets_of_edges(mesh);
  add_faces_of_shells(mesh);
  return mesh;
}

std::vector<BlockProperties> block_properties(const Scene& scene, const Component& component,
                                              const Mesh& mesh) {
  refuse_left_out_blocks(component, mesh);
  std::vector<std::string> names;
  for (const auto& block : mesh.blocks) names.push_back(block.name);
  std::vector<const Component::BlockOptions*> options_of(mesh.blocks.size(), nullptr);
  for (const auto& [block, options] : component.blocks) {
    const Index found = find_block(mesh, block);
    if (found >= 0) {
      auto& its_options = options_of[found];
      if (its_options != nullptr)
        throw InputError(options.source.text() + ": components." + component.name + ".blocks." +
                         block + ": block '" + names[found] +
                         "' is listed twice under blocks, by name and by number: keep one");
      its_options = &options;
      continue;
    }
    const std::string hint = nearest_name(block, names);
    const bool is_face = options.thickness && find_sideset(mesh, block) >= 0;
    throw InputError(options.source.text() + ": components." + component.name + ".blocks." + block +
                     ": " + component.mesh.string() + " has no block '" + block + "'" + hint +
                     (hint.empty() ? ", " : " ") + "it has: " + join(names) +
                     (is_face ? "; '" + block +
                                    "' lies on solids and is a sideset: a physical surface of "
                                    "gmsh whose name begins with skin. is a block of shells"
                              : ""));
  }
  std::vector<BlockProperties> properties;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    const Block& block = mesh.blocks[b];
    const Component::BlockOptions* options = options_of[b];
    const std::string& material =
        options != nullptr && !options->material.empty() ? options->material : component.material;
    BlockProperties block_property;
    const std::optional<HexFormulation> element = element_of(component, options);
    block_property.hex =
        element.value_or(block.reduced ? HexFormulation::reduced : HexFormulation::incompatible);
    const auto known = scene.materials.find(material);
    if (known != scene.materials.end()) {
      block_property.material = known->second;
    } else if (block.material && is_structure(block)) {
      block_property.material = material_of_file(*block.material, component, block);
    } else if (is_structure(block)) {  // others have no mass and need no material
      throw InputError(component.source.text() + ": components." + component.name + ": block '" +
                       block.name + "' of " + component.mesh.string() +
                       " has no material: add 'material', or name the block under 'blocks'");
    }
    if (block.thickness > 0 && block_property.material.orthotropy)
      throw InputError(options->source.text() + ": components." + component.name + ".blocks." +
                       block.name + ": material '" + material +
                       "' is orthotropic, and shells are isotropic: give the block an isotropic "
                       "material");
    properties.push_back(block_property);
  }
  return properties;
}

}  // namespace cbr

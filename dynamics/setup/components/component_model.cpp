// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/components/component_model.hpp"

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/format_text.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/fem/shell_model.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement_check.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"

namespace cbr {
namespace {

std::string scene_argument(const Scene& scene) {
  return scene.file == "-" ? "SCENE" : scene.file.string();
}

// Whether the file was made for a scene with the same interface and more: friction where this one
// has none, or loads on other sets. Histories may be new.
bool is_made_for_more(const Scene& scene, const Component& component, const std::string& hash) {
  if (!component.reduction->is_characteristic()) return false;
  const InterfaceNeeds of_file =
      needs_in(Hdf5Reader(component.reduction->superelement).texts("/provenance"));
  InterfaceNeeds now = interface_needs(scene, component);
  for (auto& [set, kinds] : now.loaded) kinds.means = false;
  return missing_needs(of_file, now).empty() && hash == content_hash(scene, component, of_file);
}

void require_current(const Scene& scene, const Component& component) {
  const std::filesystem::path& file = component.reduction->superelement;
  const std::string cure = ": run cbr-reduce " + scene_argument(scene);
  if (!std::filesystem::exists(file)) refuse_file(component, "does not exist" + cure);
  const std::string hash = read_content_hash(file);
  // reports the defect of a damaged or foreign file
  if (hash.empty()) read_superelement(file);
  const bool is_made_for_scene =
      hash == content_hash(scene, component) || is_made_for_more(scene, component, hash);
  if (!is_made_for_scene || is_of_other_mass(component))
    refuse_file(component, "was not made from the present mesh, materials and reduction options (" +
                               stale_text(scene, component) + ")" + cure);
  require_face_centres(component, cure);
}

void require_usable(const Scene& scene, const Component& component) {
  if (component.has_mesh) return require_current(scene, component);
  require_superelement(component);
}

// Changes the text of errors of an action.
template <typename Action, typename Renamed>
auto renaming(const Action& action, const Renamed& renamed) {
  try {
    return action();
  } catch (const InputError& error) {
    throw InputError(renamed(error.what()));
  } catch (const RunError& error) {
    throw RunError(renamed(error.what()));
  }
}

// Adds the scene's line and the component to errors in a mesh or superelement, which lack them.
template <typename Action>
auto naming(const Component& component, const Action& action) {
  return renaming(action, [&](const std::string& what) {
    if (what.starts_with(component.source.file + ":")) return what;  // it has the line already
    const std::string name = "component '" + component.name + "': ";
    return component.source.text() + ": " + (what.starts_with(name) ? "" : name) + what;
  });
}

// Adds the file to errors of an action on elements.
template <typename Action>
auto naming(const std::filesystem::path& file, const Action& action) {
  return renaming(action, [&](const std::string& what) { return file.string() + ": " + what; });
}

// Parts of a file that the instances need.
struct Needs {
  bool modal = false;     // an instance moves in the diagonal form
  bool matrices = false;  // K_cc, M_cc, M_kc
  bool diagonal = false;  // the form as it is stored
};

Needs needs_of(const std::vector<InstancePlan*>& plans) {
  Needs needs;
  for (const InstancePlan* plan : plans) {
    needs.modal |= plan->body != BodyKind::coupled;
    needs.diagonal |= plan->as_stored;
    needs.matrices |= !plan->as_stored || plan->features.contains(feature::nodal);
  }
  return needs;
}

SuperelementParts parts_to_read(const Needs& needs, bool recovery) {
  return {needs.matrices, needs.diagonal, recovery};
}

constexpr SuperelementParts light = {false, false, false};  // enough to find the needs

Geometry geometry_of(const JoinedNodes& nodes, const SuperelementGroup& group) {
  Geometry geometry;
  geometry.node_ids = nodes.node_ids;
  geometry.coordinates = nodes.coordinates;
  geometry.nodesets = nodes.nodesets;
  for (const Surface& surface : nodes.surfaces) geometry.surfaces[surface.name] = surface;
  geometry.reduced = true;
  for (const Superelement& domain : group.domains)
    for (const auto& [name, of_set] : domain.recovered_sets) geometry.recovered.insert(name);
  return geometry;
}

Geometry geometry_of_group(const SuperelementGroup& group) {
  return geometry_of(join_nodes(group), group);
}

// For fields, stress, and histories of interior sets.
bool needs_recovery(const Scene& scene, const std::vector<InstancePlan*>& plans,
                    const Geometry& geometry) {
  if (!scene.output.fields.empty()) return true;
  for (const InstancePlan* plan : plans) {
    if (plan->features.contains(feature::stress)) return true;
    for (const SurfaceName& name : scene.output.history)
      if (name.instance == plan->instance->name && is_inside(geometry, name.surface)) return true;
  }
  return false;
}

Geometry geometry_in(const std::filesystem::path& file) {
  return is_superelement_group(file) ? geometry_of_group(read_superelement_group(file, light))
                                     : geometry_of(read_superelement(file, light));
}

std::shared_ptr<const Geometry> geometry_in(const Component& component, Geometry geometry) {
  geometry.has_mesh = component.has_mesh;
  return std::make_shared<const Geometry>(std::move(geometry));
}

void add_part(std::shared_ptr<const Superelement> superelement, std::vector<Index> node,
              ReducedComponent& reduced) {
  const Index k = superelement->k();
  reduced.parts.push_back({std::move(superelement), std::move(node), reduced.n_modal});
  reduced.n_modal += k;
  reduced.n_dofs = reduced.n_modal + 3 * reduced.geometry->coordinates.rows();
}

ReducedComponent of_one(SceneIndex& index, const Component& component,
                        const BuildOptions& options) {
  const std::filesystem::path& file = component.reduction->superelement;
  auto superelement = std::make_shared<Superelement>(read_superelement(file, light));
  const std::map<Index, Index> rotations = separate_rotations(*superelement);
  ReducedComponent reduced;
  Geometry geometry = geometry_of(*superelement);
  geometry.rotations = rotations;
  reduced.geometry = geometry_in(component, std::move(geometry));
  reduced.rigid_body = superelement->rigid_body;
  reduced.provenance = superelement->provenance;
  std::vector<Index> node;
  for (Index i = 0; i < superelement->coordinates.rows(); ++i) node.push_back(i);
  add_part(superelement, std::move(node), reduced);
  reduced.n_dofs = superelement->n_coordinates();
  const bool stored = stores_diagonal_form(file);
  const std::vector<InstancePlan*> plans = index.plans(component, InstanceKind::superelement);
  const bool recovery = needs_recovery(index.scene(), plans, *reduced.geometry);
  SuperelementParts parts{true, false, superelement->is_characteristic() && recovery};
  const bool has_only_modes = !superelement->has_interface_matrices();
  plan_bodies(index.scene(), plans,
              {*reduced.geometry, reduced.n_dofs, stored, has_only_modes, options.diagonal_limit});
  if (!has_only_modes) parts = parts_to_read(needs_of(plans), recovery);
  *superelement = read_superelement(file, parts);
  check_rigid_motions(*superelement, file.string());
  separate_rotations(*superelement);
  // They belong to the modes of the stored form
  if (!superelement->has_diagonal_form()) superelement->spin_couplings.resize(0, 0);
  reduced.superelement = superelement;
  return reduced;
}

ReducedComponent of_group(SceneIndex& index, const Component& component,
                          const BuildOptions& options) {
  const std::filesystem::path& file = component.reduction->superelement;
  SuperelementGroup group = read_superelement_group(file, light);
  const JoinedNodes nodes = join_nodes(group);
  ReducedComponent reduced;
  reduced.geometry = geometry_in(component, geometry_of(nodes, group));
  reduced.rigid_body = group.rigid_body;
  reduced.conditioning = group.conditioning;
  reduced.provenance = group.provenance;
  for (const Superelement& domain : group.domains) reduced.n_modal += domain.k();
  reduced.n_dofs = reduced.n_modal + 3 * nodes.coordinates.rows();
  const bool stored = stores_diagonal_form(file);
  const std::vector<InstancePlan*> plans = index.plans(component, InstanceKind::superelement);
  plan_bodies(index.scene(), plans,
              {*reduced.geometry, reduced.n_dofs, stored, false, options.diagonal_limit});
  const Needs needs = needs_of(plans);
  group = read_superelement_group(
      file, parts_to_read(needs, needs_recovery(index.scene(), plans, *reduced.geometry)));
  for (std::size_t d = 0; d < group.domains.size(); ++d)
    check_rigid_motions(group.domains[d], file.string() + ": /domains/" + std::to_string(d + 1));
  if (needs.modal) {
    Vector omega = std::move(group.omega);
    RowMatrix V = std::move(group.V);
    reduced.superelement = std::make_shared<Superelement>(join(group));
    reduced.superelement->omega = std::move(omega);
    reduced.superelement->V = std::move(V);
  }
  reduced.n_modal = 0;
  // stored once, for the group
  for (Superelement& domain : group.domains) domain.provenance = group.provenance;
  for (std::size_t d = 0; d < group.domains.size(); ++d)
    add_part(std::make_shared<Superelement>(std::move(group.domains[d])), nodes.place[d], reduced);
  return reduced;
}

void tell_accuracy(const Superelement& s, Report& report) {
  const Superelement::Accuracy& a = *s.accuracy;
  const bool fixed = s.massless.modes == "fixed", exact = s.is_massless() && !fixed;
  std::string text = exact ? "rho_res 0, the interface has no mass"
                           : format_text("rho_res x %.4f  y %.4f  z %.4f", a.rho_res(0),
                                         a.rho_res(1), a.rho_res(2));
  if (fixed) text += ", given to the modes";
  if (a.covered_hz > 0)
    text += format_text("; free modes up to %.6g Hz are ", a.covered_hz) +
            (exact ? "exact" : "right to 1 % (estimated)");
  report.detail(text);
}

// Reports the conditioning and errors that cbr-reduce found, which hold for every run.
void tell_conditioning(const Component& component, const ReducedComponent& reduced,
                       Report& report) {
  const std::string before = report.about(),
                    about = before + "component '" + component.name + "': ";
  const std::size_t n = reduced.parts.size();
  const auto tell = [&](const std::optional<Conditioning>& conditioning, const std::string& of,
                        bool is_domain) {
    if (!conditioning) return;
    report.about(about + of);
    report_conditioning(*conditioning, report, is_domain);
    warn_of_conditioning(*conditioning, report);
  };
  for (std::size_t d = 0; d < n; ++d) {
    const Superelement& s = *reduced.parts[d].superelement;
    tell(s.conditioning,
         n > 1 ? "domain " + std::to_string(d + 1) + " of " + std::to_string(n) + ": " : "", n > 1);
    report.about(about);
    if (n == 1 && s.accuracy) tell_accuracy(s, report);
  }
  tell(reduced.conditioning, "the domains together: ", false);
  report.about(before);
}

void check_reduced(const Scene& scene, const Component& component, Report& report) {
  if (!component.reduction) {
    throw InputError(component.source.text() + ": component '" + component.name +
                     "' is used as: superelement but has no 'reduction': add one and run "
                     "cbr-reduce, or use as: mesh");
  }
  const auto phase = report.phase("read");
  require_usable(scene, component);
  const std::vector<SetUse> uses = set_uses(scene, component, InstanceKind::superelement);
  if (uses.empty()) return;
  const std::filesystem::path& file = component.reduction->superelement;
  check_uses(uses, *geometry_in(component, geometry_in(file)));
}

struct Plane {
  Vector3 point, normal;
};

class Placer {
 public:
  Placer(Scene& scene, Report& report) : scene_(scene), report_(report) {}

  void place(Instance& instance) {
    const Plane plane = plane_of(instance);
    const Points x = positions(instance, geometry(instance));
    const double nearest = ((x.rowwise() - plane.point.transpose()) * plane.normal).minCoeff();
    instance.position += (instance.place.gap - nearest) * plane.normal;
    const Vector3& at = instance.position;
    report_.line(format_text("placed '%s' at [%.10g, %.10g, %.10g], %.4g from '%s'",
                             instance.name.c_str(), at[0], at[1], at[2], instance.place.gap,
                             instance.place.on.c_str()));
    instance.place.on.clear();
  }

 private:
  static constexpr double flat = 1e-6;  // of the surface's size

  [[noreturn]] static void fail(const Instance& instance, const std::string& what) {
    throw InputError(instance.source.text() + ": instances." + instance.name + ".place.on: '" +
                     instance.place.on + "' " + what);
  }

  static Points positions(const Instance& instance, const Geometry& of) {
    return (of.coordinates * instance.transformation().transpose()).rowwise() +
           instance.position.transpose();
  }

  // Of the file, as the instance moves: of a superelement the nodes that it keeps.
  const Geometry& geometry(const Instance& instance) {
    const Component& component = component_of(scene_, instance);
    const bool is_reduced = instance.as == InstanceKind::superelement;
    const auto [at, is_new] = known_.try_emplace({component.name, is_reduced});
    Geometry& known = at->second;
    if (is_new) {
      naming(component, [&] {
        if (is_reduced) {
          require_usable(scene_, component);
          known = geometry_in(component.reduction->superelement);
        } else {
          const Mesh mesh = read_mesh(component);
          FiniteElementModel model;
          number_nodes(mesh, model);
          known = geometry_of(mesh, model);
        }
      });
    }
    return known;
  }

  Plane plane_of(const Instance& instance) {
    const std::string& on = instance.place.on;
    for (const WallOptions& wall : scene_.walls) {
      if (wall.name != on) continue;
      if (wall.kind != WallOptions::Kind::plane)
        fail(instance, "is no plane: give the instance a position");
      return {wall.point, wall.direction};
    }
    const auto dot = std::min(on.find('.'), on.size());
    const auto other = std::find_if(scene_.instances.begin(), scene_.instances.end(),
                                    [&](const Instance& i) { return i.name == on.substr(0, dot); });
    if (dot == on.size() || other == scene_.instances.end() || other->name == instance.name)
      fail(instance, "found, expected a plane of 'walls', or INSTANCE.SURFACE of another instance");
    if (!other->place.on.empty())
      fail(instance, "is placed later: list instance '" + other->name + "' before this one");
    const Geometry& of = geometry(*other);
    const Surface& surface = find_surface(of, other->name, on.substr(dot + 1), instance.source);
    const Points x = positions(*other, of)(surface_nodes(surface), Eigen::all);
    const Vector3 middle = x.colwise().mean().transpose(),
                  normal = other->transformation() *
                           face_normals(surface, of.coordinates).colwise().sum().transpose();
    const Points from_middle = x.rowwise() - middle.transpose();
    const Plane plane{middle, normal.normalized()};
    if (!((from_middle * plane.normal).cwiseAbs().maxCoeff() <=
          flat * from_middle.rowwise().norm().maxCoeff()))
      fail(instance, "is not flat: give the instance a position");
    return plane;
  }

  Scene& scene_;
  Report& report_;
  std::map<std::pair<std::string, bool>, Geometry> known_;
};

// For a superelement file alone, whose scene cannot be compared, and for new histories.
void warn_of_missing_statics(const Scene& scene, const Component& component,
                             const ReducedComponent& reduced, Report& report) {
  if (!reduced.superelement || !reduced.superelement->is_characteristic()) return;
  const std::string missing =
      missing_needs(needs_in(reduced.provenance), interface_needs(scene, component));
  const std::filesystem::path& file = component.reduction->superelement;
  if (missing.empty()) return;
  // Residual compliance of friction serves loads on its nodes, too
  if (component.has_mesh && read_content_hash(file) == content_hash(scene, component)) return;
  report.warning("component '" + component.name + "': " + file.string() + " was not made for " +
                 missing + ", where it moves too little: " +
                 (component.has_mesh
                      ? "run cbr-reduce " + scene_argument(scene)
                      : "have cbr-reduce reduce its mesh with a scene that has this, "
                        "or use basis: craig-bampton"));
}

// Whether a body of basis massless meets one that takes impulses at the starts of steps: an elastic
// one of another kind, or by a tie or a link a rigid one or the mass of a point.
bool joins_massless_to_others(const Scene& scene) {
  enum class Kind { massless, rigid, other };
  std::map<std::string, Kind> kinds;
  bool any = false, any_other = false, any_mass = false;
  for (const Instance& instance : scene.instances) {
    const Component& component = component_of(scene, instance);
    const bool massless = instance.as == InstanceKind::superelement && component.reduction &&
                          component.reduction->is_massless();
    Kind& kind = kinds[instance.name] = massless                             ? Kind::massless
                                        : instance.as == InstanceKind::rigid ? Kind::rigid
                                                                             : Kind::other;
    any |= massless;
    any_other |= kind == Kind::other;
    for (const auto& [name, point] : component.points) any_mass |= massless && point.has_mass();
  }
  const auto unlike = [&](const SurfaceName& a, const SurfaceName& b, bool is_joint) {
    if (a.is_wall() || b.is_wall()) return false;
    const Kind &one = kinds.at(a.instance), &other = kinds.at(b.instance);
    return (one == Kind::massless) != (other == Kind::massless) &&
           (is_joint || (one != Kind::rigid && other != Kind::rigid));
  };
  const auto& links = scene.links;
  return any_mass ||
         std::any_of(scene.contact.begin(), scene.contact.end(),
                     [&](const auto& c) {
                       return c.all ? any && any_other : unlike(c.first, c.second, c.tied);
                     }) ||
         std::any_of(links.begin(), links.end(),
                     [&](const auto& link) { return unlike(link.first, link.second, true); });
}

ReducedComponent read_reduced(SceneIndex& index, const Component& component,
                              const BuildOptions& options, Report& report) {
  ReducedComponent reduced;
  {
    const auto phase = report.phase("read");
    reduced = is_superelement_group(component.reduction->superelement)
                  ? of_group(index, component, options)
                  : of_one(index, component, options);
  }
  warn_of_blocks(component, reduced.provenance, report);
  tell_conditioning(component, reduced, report);
  warn_of_missing_statics(options.reduced_for != nullptr ? *options.reduced_for : index.scene(),
                          component, reduced, report);
  const std::vector<InstancePlan*> plans = index.plans(component, InstanceKind::superelement);
  const std::string file = component.reduction->superelement.string();
  if (reduced.superelement && !reduced.superelement->fixed.any() &&
      is_held_inside(*reduced.superelement))
    report.warning("component '" + component.name + "': the stiffness in " + file +
                   " resists rigid translations: the part is taken as held to the ground inside, "
                   "its instances cannot fly");
  if (reduced.superelement && !reduced.superelement->has_interface_matrices()) {
    const auto phase = report.phase("setup");
    const bool has_statics = !reduced.superelement->characteristic.statics.node.empty();
    if (reduced.superelement->is_massless() || has_statics) {
      // Statics and modes have no steps
      const bool meets_others = reduced.superelement->is_massless() &&
                                !index.scene().time->is_static && options.reduced_for == nullptr &&
                                joins_massless_to_others(index.scene());
      reduced.form = free_residual_form(reduced.superelement, file, meets_others);
      if (meets_others)
        report.warning("component '" + component.name +
                       "': basis massless meets bodies of other kinds here, so that its modes have "
                       "their mass at the interface, and impacts lose energy as with "
                       "characteristic: give all of them basis: massless, or this one another");
    } else {
      reduced.form =
          std::make_shared<ModalForm>(free_characteristic_form(*reduced.superelement, file));
    }
  } else if (std::any_of(plans.begin(), plans.end(),
                         [](const InstancePlan* plan) { return plan->moves_freely_in_form(); })) {
    const auto phase = report.phase("setup");
    reduced.form = std::make_shared<ModalForm>(
        free_modal_form(*reduced.superelement, component.reduction->superelement.string()));
  }
  for (InstancePlan* plan : plans) {
    if (reduced.parts.size() != 1) plan->features[feature::domains] = {&component.source};
    if (reduced.form && reduced.form->n_rigid != 6)
      plan->features[feature::parts] = {&component.source,
                                        std::to_string(reduced.form->n_rigid) + " rigid motions"};
  }
  return reduced;
}

// Warns if instances of one component have different masses by default.
void warn_of_two_masses(const Component& component, const MeshedComponent& meshed, Report& report) {
  if (meshed.mass == mass_of_superelement(component, *meshed.mesh)) return;
  report.warning("component '" + component.name +
                 "': the mass of its mesh is lumped and that of its superelement consistent, as is "
                 "the default: give the component mass: lumped, or consistent, to compare the two");
}

MeshedComponent read_meshed(SceneIndex& index, const Component& component,
                            const BuildOptions& options, Report& report) {
  const Scene& scene = index.scene();
  MeshedComponent meshed;
  meshed.modes = options.mesh_modes;
  {
    const auto phase = report.phase("read");
    meshed.mesh = std::make_shared<Mesh>(read_mesh(component));
    for (const InstanceKind as : {InstanceKind::mesh, InstanceKind::rigid})
      check_uses(set_uses(scene, component, as), *meshed.mesh);
  }
  const auto phase = report.phase("setup");
  meshed.properties = block_properties(scene, component, *meshed.mesh);
  // Modes need no inverse of M, and are those of CalculiX with its reduced mass. That is singular,
  // and a joined mesh may get all modes
  for (BlockProperties& of : meshed.properties)
    of.reduced_mass = options.mesh_modes && !options.mesh_modes->is_joined;
  warn_of_blocks(component, block_provenance(*meshed.mesh, meshed.properties), report);
  warn_of_mesh(component, *meshed.mesh, meshed.properties, report);
  const auto assembled = [&](MassKind mass) {
    return std::make_shared<FiniteElementModel>(
        naming(component.mesh, [&] { return assemble(*meshed.mesh, meshed.properties, mass); }));
  };
  const std::vector<InstancePlan*> rigid = index.plans(component, InstanceKind::rigid),
                                   elastic = index.plans(component, InstanceKind::mesh);
  const bool is_rigid = !rigid.empty(), is_elastic = !elastic.empty();
  if (is_elastic) {
    meshed.mass = options.mesh_modes ? mass_of_superelement(component, *meshed.mesh)
                                     : mass_of_mesh(component);
    if (!index.plans(component, InstanceKind::superelement).empty())
      warn_of_two_masses(component, meshed, report);
  } else {
    meshed.mass = MassKind::consistent;
  }
  const auto fe = assembled(meshed.mass);
  meshed.fe = fe;
  if (is_rigid) {
    const auto exact = is_elastic ? assembled(MassKind::consistent) : fe;
    meshed.rigid_body = rigid_body(exact->M, meshed.mesh->coordinates(exact->nodes, Eigen::all),
                                   exact->n_rotations);
  }
  const std::vector<Index> parts = connected_parts(*meshed.mesh, *fe);
  if (const std::string text = unjoined_parts(*meshed.mesh, *fe, parts); !text.empty())
    report.warning("component '" + component.name + "': " + text);
  if (const std::string text = hinged_shells(*meshed.mesh, *fe); !text.empty())
    report.warning("component '" + component.name + "': " + text);
  meshed.body_node = fe->row;
  auto geometry = std::make_shared<Geometry>(cbr::geometry_of(*meshed.mesh, *fe));
  if (component.reduction)
    for (const FixedSet& set : component.reduction->fixed)
      for (const Index node : find_nodes(*geometry, component.name, set.nodes, set.source))
        for (int c = 0; c < 3; ++c)
          if (set.fix[c]) geometry->fixed.emplace(node, c);
  meshed.geometry = geometry;
  const PlannedComponent planned{.geometry = *meshed.geometry,
                                 .as_modes = options.mesh_modes.has_value()};
  plan_bodies(scene, rigid, planned);
  plan_bodies(scene, elastic, planned);
  if (const Index n = 1 + *std::max_element(parts.begin(), parts.end()); n > 1)
    for (InstancePlan* plan : elastic)
      plan->features[feature::parts] = {&component.source, std::to_string(n)};
  const bool may_turn =
      index.scene().time->rotations == Rotations::large && meshed.mass == MassKind::lumped;
  if (std::any_of(elastic.begin(), elastic.end(), [&](const InstancePlan* plan) {
        return plan->body == BodyKind::mesh || (plan->body == BodyKind::coupled && may_turn);
      }))
    meshed.model = std::make_shared<MeshModel>(naming(component.mesh, [&] {
      return meshed.mass == MassKind::lumped
                 ? mesh_model(*fe, meshed.geometry->coordinates, true,
                              MeshForces(*fe, *meshed.mesh, meshed.properties,
                                         fe->n_rotations > 0 ? MeshForces::Variant::assembled
                                                             : MeshForces::Variant::automatic))
                 : mesh_model(*fe, meshed.geometry->coordinates, false);
    }));
  return meshed;
}

}  // namespace

void place_instances(Scene& scene, Report& report) {
  Placer placer(scene, report);
  for (Instance& instance : scene.instances)
    if (!instance.place.on.empty()) placer.place(instance);
}

void check_reduced_component(const Scene& scene, const Component& component, Report& report) {
  naming(component, [&] { check_reduced(scene, component, report); });
}

ReducedComponent read_reduced_component(SceneIndex& index, const Component& component,
                                        const BuildOptions& options, Report& report) {
  return naming(component, [&] { return read_reduced(index, component, options, report); });
}

MeshedComponent read_meshed_component(SceneIndex& index, const Component& component,
                                      const BuildOptions& options, Report& report) {
  return naming(component, [&] { return read_meshed(index, component, options, report); });
}

}  // namespace cbr

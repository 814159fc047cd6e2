// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/component_reducer.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/staleness.hpp"
#include "common/superelement/superelement_file.hpp"
#include "common/superelement/superelement_group.hpp"
#include "reducer/condensation/superelement_algebra.hpp"
#include "reducer/distributed/processes.hpp"
#include "reducer/domains/domains.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/modes/interior_loads.hpp"
#include "reducer/partition/interface_sets.hpp"

namespace cbr {
namespace {

// A folder that was there before the work and is gone after it is no mistake of the user's.
template <typename Write>
void write_after_the_work(const std::filesystem::path& file, const Write& write) {
  try {
    write();
  } catch (const InputError& error) {
    const auto folder = std::filesystem::absolute(file).parent_path();
    std::error_code missing;
    if (!std::filesystem::is_directory(folder, missing)) throw RunError(error.what());
    throw;
  }
}

// The diagonal form costs n^3: of a group, whose explicit and implicit steps do not use it, more
// than its domains do.
constexpr Index group_diagonal_limit = 3000;

// A reduction to one superelement does; others, other bases and points support loads on their
// interface only.
bool takes_loads_in(const ReductionOptions& reduction) {
  return !reduction.is_decomposed() && reduction.basis == Basis::craig_bampton &&
         reduction.interface_points.empty();
}

// Refuses shells where only three dofs a node are supported.
void refuse_with_shells(const Mesh& mesh, const Component& component, bool is_distributed) {
  const ReductionOptions& reduction = *component.reduction;
  if (!has_shells(mesh)) {
    if (reduction.condenses_rotations)
      throw InputError(reduction.source.text() +
                       ": reduction.condense_rotations: the component has no shells "
                       "(blocks.NAME.thickness), and so no rotations: leave it out");
    return;
  }
  const auto refuse = [&](const std::string& what, const std::string& cure) {
    throw InputError(reduction.source.text() + ": " + what +
                     " does not know shells (blocks.NAME.thickness): " + cure);
  };
  if (reduction.is_decomposed()) refuse("domains", "use domains: 1");
  if (!reduction.interface_points.empty())
    refuse("reduction.points",
           "name their sets in reduction.interface, which keeps the rotations of their nodes");
  if (is_distributed)
    refuse("a reduction in several processes (mpirun, --engine petsc)", "use one process");
}

// Of superelements of the component.
std::set<std::string> touching_sets(const Scene& scene, const Component& component) {
  std::set<std::string> sets;
  if (!scene.time || scene.time->is_static || scene.time->integrator != Integrator::exact)
    return sets;
  const auto is_of = [&](const std::string& instance) {
    return std::any_of(scene.instances.begin(), scene.instances.end(), [&](const Instance& i) {
      return i.name == instance && i.component == component.name &&
             i.as == InstanceKind::superelement && i.damping.empty();
    });
  };
  const std::vector<std::string>& kept = component.reduction->interface_sets;
  for (const ContactOptions& contact : scene.contact) {
    if (contact.tied) continue;
    if (contact.all) sets.insert(kept.begin(), kept.end());
    for (const SurfaceName* side : {&contact.first, &contact.second})
      if (!contact.all && is_of(side->instance)) sets.insert(side->surface);
  }
  return sets;
}

// Each set is on the interface or has its load inside, and no others have.
bool has_loads(const Superelement& s, const std::vector<std::string>& sets) {
  const auto is_kept = [&](const std::string& name) {
    return s.nodesets.count(name) > 0 ||
           std::any_of(s.surfaces.begin(), s.surfaces.end(),
                       [&](const Surface& surface) { return surface.name == name; });
  };
  return std::all_of(sets.begin(), sets.end(),
                     [&](const auto& name) { return is_kept(name) || s.loads.count(name) > 0; }) &&
         std::all_of(s.loads.begin(), s.loads.end(), [&](const auto& load) {
           return std::find(sets.begin(), sets.end(), load.first) != sets.end();
         });
}

}  // namespace

Index diagonal_limit(const ReduceCommand& command, const ReductionOptions& reduction) {
  const bool group = reduction.is_decomposed() && !reduction.has_second_reduction();
  return command.diagonal_limit.value_or(group ? group_diagonal_limit
                                               : ReduceSettings{}.diagonal_limit);
}

bool has_shells(const Mesh& mesh) {
  return std::any_of(mesh.blocks.begin(), mesh.blocks.end(),
                     [](const Block& block) { return block.thickness > 0; });
}

void ComponentReducer::reduce_component(const Scene& scene, const Component& component) {
  const ReductionOptions& reduction = *component.reduction;
  refuse_to_overwrite(scene, command_.input, reduction.superelement);
  settings_.memory = command_.memory;
  settings_.diagonal_limit = diagonal_limit(command_, reduction);
  settings_.is_diagonal_read = command_.diagonal_limit || reads_diagonal_form(scene, component);
  UnchangedFiles inputs;
  for (const auto& file : mesh_files(component.mesh)) inputs.add(file);
  const std::string hash = content_hash(scene, component);
  loads_ = load_sets(scene, component);
  needs_ = interface_needs(scene, component);
  const FileState state = command_.force
                              ? FileState::stale
                              : state_of(scene, component, hash, loads_,
                                         {form_limit(), command_.diagonal_limit.has_value()});
  if (state == FileState::without_form && !command_.is_first()) return;
  if (state == FileState::without_form) return add_form(component, inputs);
  if (state == FileState::current) {
    warn_of_blocks(component, Hdf5Reader(reduction.superelement).texts("/provenance"), report_);
    report_.line(component.name + ": " + reduction.superelement.string() +
                 " is up to date: nothing to do");
    return;
  }
  const auto [twin, is_new] = done_.emplace(hash + " " + word_of(mass_words, component.mass) + " " +
                                                std::to_string(form_limit()) + " " + join(loads_),
                                            reduction.superelement);
  if (!is_new && !command_.is_first()) return;
  if (!is_new) {
    write_copy(twin->second, reduction.superelement);
    report_.line(component.name + ": the same as " + twin->second.string() + ", copied to " +
                 reduction.superelement.string());
    return;
  }
  // finds an unwritable file before the work
  if (command_.is_first()) const TemporaryFile probe(reduction.superelement);
  report_.line("reducing " + component.name + " (" + component.mesh.filename().string() + ")");
  make(scene, component, hash, inputs);
}

namespace {

// Without a scene: what a deck has and the file has not.
void warn_of_points(const Component& component, Report& report) {
  std::vector<std::string> names;
  for (const auto& [name, point] : component.points)
    names.push_back(name + (point.rigid ? " (rigid)" : "") + (point.has_mass() ? " (mass)" : ""));
  if (!names.empty())
    report.warning("component '" + component.name +
                   "': points of the deck that the file does not hold: " + join(names) +
                   ": cbr-dyn adds them to it in a scene with this deck, and other "
                   "users of the file have neither their masses nor their rigid sets");
}

}  // namespace

void ComponentReducer::make(const Scene& scene, const Component& component, const std::string& hash,
                            const UnchangedFiles& inputs) {
  Mesh mesh;
  {
    const auto phase = report_.phase("reading the mesh");
    mesh = read_mesh(component);
  }
  const std::vector<BlockProperties> properties = block_properties(scene, component, mesh);
  warn_of_mesh(component, mesh, properties, report_);
  mass_ = {mass_of_superelement(component, mesh), rigid_body_of_geometry(mesh, properties),
           scene.time && scene.time->is_static, touching_sets(scene, component)};
  const auto p = provenance(scene, component, properties, mesh);
  warn_of_blocks(component, p, report_);
  inputs.check();
  refuse_loads_inside(mesh, *component.reduction, loads_, takes_loads_in(*component.reduction));
  check_kept_sets(scene, component, mesh);
  if (scene.file.empty()) warn_of_points(component, report_);
  check_recovery_sets(mesh, *component.reduction);
  refuse_with_shells(mesh, component, command_.is_distributed());
  settings_.points = rigid_points(mesh, component);
  const char* one_process = !settings_.points.empty()             ? "points"
                            : !component.reduction->fixed.empty() ? "fixed"
                                                                  : nullptr;
  if (command_.is_distributed() && one_process != nullptr)
    throw InputError(component.reduction->source.text() + ": reduction." + one_process +
                     " is not known to several processes and --engine petsc: reduce this "
                     "component in one process");
  if (component.reduction->is_decomposed()) {
    make_group(mesh, properties, component, hash, p);
  } else {
    make_one(mesh, properties, component, hash, p);
  }
}

// Coordinates up to which the diagonal form is stored.
Index ComponentReducer::form_limit() const {
  return settings_.is_diagonal_read ? settings_.diagonal_limit : -1;
}

// To a file that was made for a scene which does not read it.
void ComponentReducer::add_form(const Component& component, const UnchangedFiles& inputs) {
  const std::filesystem::path& file = component.reduction->superelement;
  report_.line(component.name + ": adding the diagonal form to " + file.string());
  const Mesh mesh = read_mesh(component);
  inputs.check();
  Superelement s = read_superelement(file);
  {
    const auto phase = report_.phase("diagonal form");
    const bool has_points = !component.reduction->interface_points.empty();
    add_diagonal_form(
        s, has_points ? std::vector<Index>(s.node_ids.size(), 0) : parts_of(mesh, s.node_ids));
  }
  const auto phase = report_.phase("writing the superelement");
  write_after_the_work(file, [&] { write_superelement(s, file); });
}

void ComponentReducer::make_one(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                const Component& component, const std::string& hash,
                                const std::map<std::string, std::string>& provenance) {
  ReductionFigures figures;
  ReductionOptions options = *component.reduction;
  options.loads = takes_loads_in(options) ? loads_ : std::vector<std::string>();
  options.characteristic.needs = needs_;
  const auto reduce_it = command_.is_distributed()
                             ? reduce_in_processes
                             : static_cast<decltype(&reduce_in_processes)>(reduce);
  Superelement s = reduce_it(mesh, properties, mass_.kind, options, settings_, report_, &figures);
  if (!command_.is_first()) return;
  add_recovered_sets(mesh, false, s);
  finish(std::move(s), figures, component, hash, provenance);
}

void ComponentReducer::make_group(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                  const Component& component, const std::string& hash,
                                  const std::map<std::string, std::string>& provenance) {
  GroupFigures figures;
  const DomainShare share = command_.is_distributed() ? share_of_domains() : DomainShare();
  SuperelementGroup group = reduce_domains(mesh, properties, mass_.kind, *component.reduction,
                                           settings_, report_, &figures, share);
  if (!command_.is_first()) return;
  const std::optional<Vector3> rho =
      residual_mass_share(group, component_interface(mesh, component.reduction->interface_sets));
  summarise_domains(group, figures, rho, mass_, report_);
  if (component.reduction->has_second_reduction()) {
    make_second(mesh, group, figures.n_dofs, component, hash, provenance);
    return;
  }
  if (rho && !group.conditioning) group.conditioning.emplace();
  if (rho) group.conditioning->rho_res = rho;
  group.content_hash = hash;
  group.provenance = provenance;
  for (auto& domain : group.domains) {
    domain.content_hash = hash;
    add_recovered_sets(mesh, true, domain);
  }
  {
    const auto phase = report_.phase("writing the superelements");
    write_after_the_work(component.reduction->superelement, [&] {
      write_superelement_group(group, component.reduction->superelement);
    });
  }
  summarise_group(group, mass_, component.reduction->superelement, report_);
}

void ComponentReducer::make_second(const Mesh& mesh, const SuperelementGroup& group, Index n_dofs,
                                   const Component& component, const std::string& hash,
                                   const std::map<std::string, std::string>& provenance) {
  const ReductionOptions& reduction = *component.reduction;
  ReductionFigures figures;
  Superelement s = reduce_again(group, component_interface(mesh, reduction.interface_sets),
                                reduction, settings_, report_, &figures);
  figures.n_dofs = n_dofs;
  {
    const auto phase = report_.phase("diagonal form");
    const std::vector<Index> part = parts_of(mesh, s.node_ids);
    const Cholesky M_res = residual_mass_factor(s);
    if (s.n() <= form_limit()) figures.condition.n_rigid = add_diagonal_form(s, part, &M_res);
    const Index loose =
        examine_reduced(s, rigid_motions_of_parts(s, part), M_res, figures.condition);
    if (loose >= 0) figures.condition.loose_node = name_of_node_id(mesh, s.node_ids[loose / 3]);
  }
  const std::string about = report_.about();
  report_.about(about + "second reduction: ");
  report_conditioning(figures.condition, report_);
  warn_of_conditioning(figures.condition, report_);
  report_.about(about);
  s.conditioning = figures.condition;
  s.conditioning->rho_res = residual_mass_share(s);
  add_recovered_sets(mesh, false, s);
  finish(std::move(s), figures, component, hash, provenance);
}

void ComponentReducer::finish(Superelement&& s, const ReductionFigures& figures,
                              const Component& component, const std::string& hash,
                              const std::map<std::string, std::string>& provenance) {
  s.content_hash = hash;
  s.provenance = provenance;
  {
    const auto phase = report_.phase("writing the superelement");
    write_after_the_work(component.reduction->superelement,
                         [&] { write_superelement(s, component.reduction->superelement); });
  }
  summarise(s, figures, mass_, component.reduction->superelement, report_);
}

FileState state_of(const Scene& scene, const Component& component, const std::string& hash,
                   const std::vector<std::string>& loads, const WantedForm& wanted) {
  const ReductionOptions& reduction = *component.reduction;
  if (read_content_hash(reduction.superelement) != hash || is_of_other_mass(component))
    return FileState::stale;
  if (lacks_face_centres(reduction.superelement)) return FileState::stale;
  Superelement s;
  bool group = false;
  try {
    group = is_superelement_group(reduction.superelement);
    const SuperelementParts light = {false, true, false};
    s = group ? join(read_superelement_group(reduction.superelement, light))
              : read_superelement(reduction.superelement, light);
  } catch (const InputError&) {
    return FileState::stale;  // damaged: it is made anew
  }
  check_kept_sets(scene, component, s);
  if (!has_loads(s, loads)) return FileState::stale;
  const bool is_wanted = s.n() <= wanted.limit && s.has_interface_matrices();
  if (is_wanted && !s.has_diagonal_form())
    return group ? FileState::stale : FileState::without_form;
  return wanted.exact && !is_wanted && s.has_diagonal_form() ? FileState::stale
                                                             : FileState::current;
}

void refuse_to_overwrite(const Scene& scene, const std::string& input,
                         const std::filesystem::path& target) {
  const auto is_target = [&](const std::filesystem::path& file) {
    std::error_code error;
    return std::filesystem::equivalent(file, target, error) && !error;
  };
  for (const auto& [name, component] : scene.components) {
    if (component.has_mesh && is_target(component.mesh))
      throw InputError("superelement '" + target.string() + "' is the mesh of component '" + name +
                       "' and would overwrite it: give the superelement another name, as " + name +
                       ".cbr.h5");
  }
  if (is_target(input))
    throw InputError("superelement '" + target.string() +
                     "' is the scene itself and would overwrite it: give it another name");
  refuse_other_file(target, superelement_kind(), "the superelement",
                    "give the superelement another name");
}

std::map<std::string, std::string> provenance(const Scene& scene, const Component& component,
                                              const std::vector<BlockProperties>& properties,
                                              const Mesh& mesh) {
  std::map<std::string, std::string> p =
      option_provenance(component, mass_of_superelement(component, mesh));
  p["mesh"] = component.mesh.filename().string();
  p["mesh_hash"] = mesh_hash(component.mesh);
  if (component.reduction->is_characteristic())
    p.merge(needs_provenance(interface_needs(scene, component)));
  p.merge(block_provenance(mesh, properties));
  return p;
}

}  // namespace cbr

// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/command.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <ostream>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/number_text.hpp"
#include "common/files/hdf5_file.hpp"
#include "common/files/output_file.hpp"
#include "common/files/replaced_file.hpp"
#include "common/files/unchanged_files.hpp"
#include "common/scene/component_mass.hpp"
#include "common/scene/left_out_blocks.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"
#include "common/scene/staleness.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/condensation/panel_memory.hpp"
#include "reducer/condensation/residual_mass.hpp"
#include "reducer/distributed/distributed_reduction.hpp"
#include "reducer/distributed/processes.hpp"
#include "reducer/domains/decomposition.hpp"
#include "reducer/domains/domains.hpp"
#include "reducer/domains/second_reduction.hpp"
#include "reducer/estimate/estimate.hpp"
#include "reducer/exchange/export/export_superelement.hpp"
#include "reducer/exchange/import/import.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/modes/interior_loads.hpp"
#include "reducer/partition/geometry_body.hpp"
#include "reducer/partition/kept_sets.hpp"
#include "reducer/partition/recovered_sets.hpp"
#include "reducer/summary.hpp"

namespace cbr {
namespace {

// The first option given that describes the component of a mesh; empty: none.
std::string given_mesh_option(const ReduceCommand& c) {
  for (const ReductionKey& key : reduction_keys())
    if (c.reduction.count(key.key) > 0) return key.option;
  const std::vector<std::pair<bool, const char*>> given = {
      {c.youngs_modulus.has_value(), "--youngs-modulus"},
      {c.poissons_ratio.has_value(), "--poissons-ratio"},
      {c.density.has_value(), "--density"},
      {!c.element.empty(), "--element"},
      {!c.mass.empty(), "--mass"}};
  for (const auto& [is_given, option] : given)
    if (is_given) return option;
  return "";
}

void refuse_mesh_options(const ReduceCommand& c) {
  std::string option = given_mesh_option(c);
  if (option.empty() && !c.output.empty()) option = "--output";
  if (option.empty()) return;
  throw InputError(c.input + ": " + option +
                   " requires a mesh (.msh, .exo, .inp, .bdf, ...) as INPUT; in a scene give it "
                   "under components");
}

// A mistyped -o or superelement: would cost the user a mesh or the scene.
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
  refuse_other_file(target, {"cbr-superelement", "cbr-superelement-group"}, "the superelement",
                    "give the superelement another name");
}

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

Index diagonal_limit(const ReduceCommand& command, const ReductionOptions& reduction) {
  const bool group = reduction.is_decomposed() && !reduction.has_second_reduction();
  return command.diagonal_limit.value_or(group ? group_diagonal_limit
                                               : ReduceSettings{}.diagonal_limit);
}

// A reduction to one superelement does; others, other bases and points know loads on their
// interface only.
bool takes_loads_in(const ReductionOptions& reduction) {
  return !reduction.is_decomposed() && reduction.basis == Basis::craig_bampton &&
         reduction.interface_points.empty();
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

enum class FileState { current, without_form, stale };

// Unchanged inputs; `without_form`: all is there but the diagonal form, which is wanted. `wanted`:
// of how many coordinates; an `exact` limit of the command line wants larger ones without it.
struct WantedForm {
  Index limit = 0;
  bool exact = false;
};

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

std::map<std::string, std::string> provenance(const Component& component,
                                              const std::vector<BlockProperties>& properties,
                                              const Mesh& mesh) {
  std::map<std::string, std::string> p =
      option_provenance(component, mass_of_superelement(component, mesh));
  p["mesh"] = component.mesh.filename().string();
  p["mesh_hash"] = file_hash(component.mesh);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    if (!is_structure(mesh.blocks[b])) continue;
    const Material& m = properties[b].material;
    const std::string key = "block " + mesh.blocks[b].name + ": ";
    for (const auto& [what, value] : material_provenance(m)) p[key + what] = value;
    if (const double thickness = mesh.blocks[b].thickness; thickness > 0)
      p[key + "thickness"] = number_text(thickness);
    const ElementType type = mesh.blocks[b].type;
    p[key + "element"] = type == ElementType::hex8 ? word_of(hex8_words, properties[b].hex8)
                                                   : std::string(name(type));
  }
  if (const std::string blocks = left_out_blocks(mesh); !blocks.empty()) p["left_out"] = blocks;
  return p;
}

// What was noted of blocks that were not computed with when the file was made.
std::string left_out_in(const std::filesystem::path& superelement) {
  const Hdf5Reader file(superelement);
  const bool any = file.has("/provenance") && file.has_attribute("/provenance", "left_out");
  return any ? file.read_string("/provenance", "left_out") : "";
}

bool has_shells(const Mesh& mesh) {
  return std::any_of(mesh.blocks.begin(), mesh.blocks.end(),
                     [](const Block& block) { return block.thickness > 0; });
}

// Ways that know three dofs a node.
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
  if (reduction.basis != Basis::craig_bampton)
    refuse("basis: " + word_of(basis_words, reduction.basis), "use basis: craig-bampton");
  if (reduction.is_decomposed()) refuse("domains", "use domains: 1");
  if (is_distributed)
    refuse("a reduction in several processes (mpirun, --engine petsc)", "use one process");
}

class Reducer {
 public:
  Reducer(const ReduceCommand& command, Report& report) : report_(report), command_(command) {}

  void reduce_component(const Scene& scene, const Component& component) {
    const ReductionOptions& reduction = *component.reduction;
    refuse_to_overwrite(scene, command_.input, reduction.superelement);
    settings_.memory = command_.memory;
    settings_.diagonal_limit = diagonal_limit(command_, reduction);
    settings_.is_diagonal_read = command_.diagonal_limit || reads_diagonal_form(scene, component);
    UnchangedFiles inputs;
    inputs.add(component.mesh);
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
      warn_of_left_out_blocks(component, left_out_in(reduction.superelement), report_);
      report_.line(component.name + ": " + reduction.superelement.string() +
                   " is up to date: nothing to do");
      return;
    }
    const auto [twin, is_new] =
        done_.emplace(hash + " " + word_of(mass_words, component.mass) + " " +
                          std::to_string(form_limit()) + " " + join(loads_),
                      reduction.superelement);
    if (!is_new && !command_.is_first()) return;
    if (!is_new) {
      write_copy(twin->second, reduction.superelement);
      report_.line(component.name + ": the same as " + twin->second.string() + ", copied to " +
                   reduction.superelement.string());
      return;
    }
    // what cannot be written is found before the work
    if (command_.is_first()) const TemporaryFile probe(reduction.superelement);
    report_.line("reducing " + component.name + " (" + component.mesh.filename().string() + ")");
    make(scene, component, hash, inputs);
  }

 private:
  void make(const Scene& scene, const Component& component, const std::string& hash,
            const UnchangedFiles& inputs) {
    Mesh mesh;
    {
      const auto phase = report_.phase("reading the mesh");
      mesh = read_mesh(component);
    }
    const std::vector<BlockProperties> properties = block_properties(scene, component, mesh);
    warn_of_left_out_blocks(component, left_out_blocks(mesh), report_);
    mass_ = {mass_of_superelement(component, mesh), rigid_body_of_geometry(mesh, properties)};
    const auto p = provenance(component, properties, mesh);
    inputs.check();
    refuse_loads_inside(mesh, *component.reduction, loads_, takes_loads_in(*component.reduction));
    check_kept_sets(scene, component, mesh);
    check_recovery_sets(mesh, *component.reduction);
    if (command_.is_distributed() && component.reduction->is_decomposed())
      throw InputError(
          "domains is not known to several processes and --engine petsc: reduce this component in "
          "one process");
    refuse_with_shells(mesh, component, command_.is_distributed());
    settings_.points = rigid_points(mesh, component);
    if (command_.is_distributed() && !settings_.points.empty())
      throw InputError(
          "reduction.points is not known to several processes and --engine petsc: reduce this "
          "component in one process");
    if (component.reduction->is_decomposed()) {
      make_group(mesh, properties, component, hash, p);
    } else {
      make_one(mesh, properties, component, hash, p);
    }
  }

  // Coordinates up to which the diagonal form is stored.
  Index form_limit() const { return settings_.is_diagonal_read ? settings_.diagonal_limit : -1; }

  // To a file that was made for a scene which does not read it.
  void add_form(const Component& component, const UnchangedFiles& inputs) {
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

  void make_one(const Mesh& mesh, const std::vector<BlockProperties>& properties,
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

  void make_group(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                  const Component& component, const std::string& hash,
                  const std::map<std::string, std::string>& provenance) {
    GroupFigures figures;
    SuperelementGroup group = reduce_domains(mesh, properties, mass_.kind, *component.reduction,
                                             settings_, report_, &figures);
    const std::optional<Vector3> rho =
        residual_mass_share(group, component_interface(mesh, component.reduction->interface_sets));
    summarise_domains(group, figures, rho, report_);
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

  void make_second(const Mesh& mesh, const SuperelementGroup& group, Index n_dofs,
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
      if (loose >= 0)
        figures.condition.loose_node =
            name_of_node_id(mesh, s.node_ids[static_cast<std::size_t>(loose / 3)]);
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

  void finish(Superelement&& s, const ReductionFigures& figures, const Component& component,
              const std::string& hash, const std::map<std::string, std::string>& provenance) {
    s.content_hash = hash;
    s.provenance = provenance;
    {
      const auto phase = report_.phase("writing the superelement");
      write_after_the_work(component.reduction->superelement,
                           [&] { write_superelement(s, component.reduction->superelement); });
    }
    summarise(s, figures, mass_, component.reduction->superelement, report_);
  }

  Report& report_;
  const ReduceCommand& command_;
  ReduceSettings settings_;
  ComponentMass mass_;  // of the component at hand
  // sets of the component at hand that loads act on
  std::vector<std::string> loads_;
  InterfaceNeeds needs_;  // of the same
  // content hash, form and loads -> file made in this run
  std::map<std::string, std::filesystem::path> done_;
};

// Calls `action` once for each component that an instance uses as a superelement, but not for
// superelement files without a mesh; its InputErrors get the component's place. False when there is
// none.
bool for_each_component(const Scene& scene, const std::string& mesh_input,
                        const std::function<void(const Component&)>& action) {
  std::map<std::string, bool> seen;
  bool any = false;
  for (const auto& instance : scene.instances) {
    if (instance.as != InstanceKind::superelement || seen[instance.component]) continue;
    seen[instance.component] = true;
    const Component& component = component_of(scene, instance);
    if (!component.has_mesh) continue;
    any = true;
    try {
      action(component);
    } catch (const InputError& error) {
      const std::string where = !mesh_input.empty() ? mesh_input
                                                    : component.reduction->source.text() +
                                                          ": component '" + component.name + "'";
      std::string what = error.what();
      // says its line already
      if (mesh_input.empty() && what.starts_with(component.source.file + ":")) throw;
      const std::string path = component.mesh.string() + ":";
      // once is enough, with the line if it says one
      if (!mesh_input.empty() && what.starts_with(path))
        throw InputError(mesh_input + what.substr(path.size() - 1));
      throw InputError(where + ": " + what);
    }
  }
  return any;
}

void estimate_component(const ReduceCommand& command, const Scene& scene,
                        const Component& component, std::ostream& out, Report& report) {
  ReductionOptions reduction = *component.reduction;
  if (reduction.is_massless())
    throw InputError(
        "--estimate does not know basis massless: craig-bampton or characteristic allowed");
  if (!reduction.interface_points.empty())
    throw InputError(
        "--estimate does not know reduction.points: the interface has six dofs for each, and takes "
        "no time beside the factor");
  reduction.characteristic.needs = interface_needs(scene, component);
  const Mesh mesh = read_mesh(component);
  warn_of_left_out_blocks(component, left_out_blocks(mesh), report);
  if (has_shells(mesh))
    throw InputError(component.source.text() + ": component '" + component.name +
                     "': --estimate does not know shells (blocks.NAME.thickness): reduce it");
  const std::vector<Index> domain = decompose(mesh, reduction.domains).domain;
  const Estimate e = estimate(mesh, block_properties(scene, component, mesh), reduction, domain,
                              diagonal_limit(command, reduction));
  const std::string title = "# " + component.name + " (" + component.mesh.filename().string() +
                            "), interface " + join(reduction.interface_sets) +
                            ": what a reduction would give and cost";
  print_estimate(e, machine_rates(), command.memory > 0 ? command.memory : half_of_memory(), title,
                 out);
}

}  // namespace

bool ReduceCommand::is_distributed() const {
  return processes != nullptr && processes->is_started();
}

bool ReduceCommand::is_first() const { return processes == nullptr || processes->is_first(); }

void run_estimate(const ReduceCommand& command, std::ostream& out, Report& report) {
  const bool is_mesh = is_mesh_name(command.input);
  if (!is_mesh) refuse_mesh_options(command);
  const Scene scene = is_mesh ? scene_of_mesh(command) : read_scene(command.input);
  const bool any =
      for_each_component(scene, is_mesh ? command.input : "", [&](const Component& component) {
        estimate_component(command, scene, component, out, report);
      });
  if (!any) report.line("no instance is a superelement that has a mesh: nothing to estimate");
}

void run_export(const ReduceCommand& command, Report& report) {
  std::string target = command.output;
  if (target.empty()) {
    target = command.input;
    const std::string suffix = ".cbr.h5";
    if (target.ends_with(suffix)) target.resize(target.size() - suffix.size());
  }
  export_superelement(command.export_format, command.input, target, command.first_modal_node,
                      report);
}

void run_import(const ReduceCommand& command, Report& report) {
  if (const std::string option = given_mesh_option(command); !option.empty())
    throw InputError(
        command.input + ": " + option +
        " is not available with --import, which takes matrices as they are: leave it out");
  const std::filesystem::path input = command.input;
  ImportOptions options;
  options.format = command.import_format;
  options.file = input;
  options.faces = command.faces;
  options.target = command.output.empty() ? input.stem().string() + ".cbr.h5" : command.output;
  options.diagonal_limit = command.diagonal_limit.value_or(ReduceSettings{}.diagonal_limit);
  import_superelement(options, report);
}

void run_reduce(const ReduceCommand& command, std::ostream* scene_out, Report& report) {
  const bool is_mesh = is_mesh_name(command.input);
  if (!is_mesh) refuse_mesh_options(command);
  if (command.input == "-" && command.processes != nullptr && command.processes->count() > 1)
    throw InputError(
        "a scene on standard input reaches one of the processes only: give the scene as a file");
  const Scene scene = is_mesh ? scene_of_mesh(command) : read_scene(command.input);
  check_contact_with_time(scene);
  for (const auto& [name, component] : scene.components)
    if (component.reduction)
      report.refuse_timings_at(component.reduction->superelement,
                               "the superelement of component '" + name + "'");
  Reducer reducer(command, report);
  const bool any =
      for_each_component(scene, is_mesh ? command.input : "", [&](const Component& component) {
        if (!is_mesh) report.about("component '" + component.name + "': ");
        reducer.reduce_component(scene, component);
        report.about("");
      });
  if (!any) report.line("no instance is a superelement that has a mesh: nothing to reduce");
  report.timings();
  if (!is_mesh && scene_out != nullptr) write_scene(scene, *scene_out);
}

}  // namespace cbr

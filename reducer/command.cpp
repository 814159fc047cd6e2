// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/command.hpp"

#include <functional>
#include <map>
#include <ostream>
#include <utility>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/scene/component_blocks.hpp"
#include "common/scene/limits.hpp"
#include "common/scene/reduction_keys.hpp"
#include "reducer/component_reducer.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/distributed/processes.hpp"
#include "reducer/domains/decomposition.hpp"
#include "reducer/estimate/estimate.hpp"
#include "reducer/exchange/export/export_formats.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {
namespace {

// The first option given that describes the component of a mesh; empty: none.
std::string given_mesh_option(const ReduceCommand& c) {
  ReductionOptions none;
  for (const ReductionKey& key : reduction_keys(none))
    if (c.reduction.count(key.scene.key) > 0) return key.option;
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
  const auto refuse = [&](const std::string& what) {
    throw InputError(component.source.text() + ": --estimate does not know " + what);
  };
  if (reduction.is_massless()) refuse("basis massless: craig-bampton or characteristic allowed");
  if (!reduction.interface_points.empty())
    refuse(
        "reduction.points: the interface has six dofs for each, and takes no time beside the "
        "factor");
  if (!reduction.fixed.empty()) refuse("reduction.fixed: leave it out, for an estimate from above");
  reduction.characteristic.needs = interface_needs(scene, component);
  const Mesh mesh = read_mesh(component);
  const std::vector<BlockProperties> properties = block_properties(scene, component, mesh);
  warn_of_blocks(component, block_provenance(mesh, properties), report);
  warn_of_mesh(component, mesh, properties, report);
  if (has_shells(mesh)) refuse("shells (blocks.NAME.thickness): reduce the component");
  const std::vector<Index> domain = decompose(mesh, reduction.domains).domain;
  const Estimate e =
      estimate(mesh, properties, reduction, domain, diagonal_limit(command, reduction));
  const std::string title = "# " + component.name + " (" + component.mesh.filename().string() +
                            "), interface " + join(reduction.interface_sets) +
                            ": what a reduction would give and cost";
  print_estimate(e, command.memory > 0 ? command.memory : half_of_memory(), title, out);
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
  check_before_reduction(scene);
  for (const auto& [name, component] : scene.components)
    if (component.reduction)
      report.refuse_timings_at(component.reduction->superelement,
                               "the superelement of component '" + name + "'");
  ComponentReducer reducer(command, report);
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

// SPDX-License-Identifier: GPL-3.0-or-later
// The command line of cbr-reduce.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <map>

#include "common/app/program.hpp"
#include "common/base/error.hpp"
#include "common/scene/points_of_file.hpp"
#include "common/scene/reduction_keys.hpp"
#include "common/scene/scene_words.hpp"
#include "reducer/command.hpp"
#include "reducer/exchange/export/export_formats.hpp"
#include "reducer/exchange/import/import.hpp"

namespace cbr {
namespace {

std::filesystem::path absolute(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal();
}

double number_in(const std::string& option, const std::optional<double>& value, double low,
                 double high, const std::string& allowed) {
  if (!value) throw InputError(option + " is missing: a mesh needs " + option + ", " + allowed);
  if (!std::isfinite(*value) || !(*value > low) || !(*value < high)) {
    throw InputError(option + ": " + std::to_string(*value) + " found, " + allowed + " is allowed");
  }
  return *value;
}

// The place of the word among those that are allowed.
std::size_t place_of(const std::string& option, const std::string& found,
                     const std::vector<std::string>& allowed) {
  const auto word = std::find(allowed.begin(), allowed.end(), found);
  if (word != allowed.end()) return static_cast<std::size_t>(word - allowed.begin());
  throw InputError(option + ": '" + found + "' found, allowed: " + join(allowed) +
                   nearest_name(found, allowed));
}

// The first of the words when there is none.
template <typename Value>
Value one_of(const std::string& option, const std::string& found, const Words<Value>& words) {
  return words[found.empty() ? 0 : place_of(option, found, texts_of(words))].second;
}

// "4GB", "500 MB", "1e9"
std::string parse_bytes(const std::string& text, double& bytes) {
  char* end = nullptr;
  bytes = std::strtod(text.c_str(), &end);
  std::string unit(end);
  unit.erase(0, unit.find_first_not_of(' '));
  for (char& letter : unit)
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  double factor = 0;
  if (unit.empty() || unit == "B") factor = 1;
  if (unit == "KB" || unit == "K") factor = 1e3;
  if (unit == "MB" || unit == "M") factor = 1e6;
  if (unit == "GB" || unit == "G") factor = 1e9;
  if (unit == "TB" || unit == "T") factor = 1e12;
  bytes *= factor;
  const bool valid = end != text.c_str() && factor > 0 && std::isfinite(bytes) && bytes >= 1;
  if (!valid) return "'" + text + "' is not a size, give one like 500MB or 8GB";
  constexpr double least_without_unit = 1e5;
  return unit.empty() && bytes < least_without_unit
             ? "'" + text + "' has no unit and would be bytes, give one like 500MB or 8GB"
             : "";
}

template <typename Number, typename Convert>
Number converted(const std::string& option, const std::string& text, const char* what,
                 const Convert& convert) {
  char* end = nullptr;
  errno = 0;
  const Number value = convert(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0' || errno == ERANGE)
    throw InputError(option + ": '" + text + "' found, expected " + what);
  return value;
}

Index whole_number_of(const std::string& option, const std::string& text, Index least) {
  const auto convert = [](const char* from, char** end) { return std::strtoll(from, end, 10); };
  const Index value = converted<Index>(option, text, "a whole number", convert);
  if (value < least)
    throw InputError(option + ": " + std::to_string(value) + " found, " + std::to_string(least) +
                     " or more is allowed");
  return value;
}

// Takes the words that the command line gives for one key of the table.
struct TakeWords {
  const ReductionKey& key;
  const std::vector<std::string>& words;

  void operator()(const OneWord& v) const {
    v.take(place_of(key.option, words.front(), v.allowed()));
  }
  void operator()(const WholeNumber& v) const {
    v.place.set(whole_number_of(key.option, words.front(), v.least));
  }
  void operator()(const Number& v) const {
    const double value =
        converted<double>(key.option, words.front(), key.allowed.c_str(), std::strtod);
    v.place.set(number_in(key.option, value, v.bounds.low, v.bounds.high, key.allowed));
  }
  void operator()(const TrueOrFalse& v) const { v.member = true; }
  void operator()(const NameList& v) const { v.names = words; }
  void operator()(const NamesOrTrue& v) const { v.member = true; }
  void operator()(const auto&) const {}  // no key with an option has such a value
};

ReductionOptions reduction_of(const ReduceCommand& command) {
  ReductionOptions reduction;
  reduction.source.file = "command line";
  std::vector<std::string> given;
  for (const ReductionKey& key : reduction_keys(reduction)) {
    const auto found = command.reduction.find(key.scene.key);
    if (found == command.reduction.end()) continue;
    if (!key.goes_with(reduction.basis))
      throw InputError(key.option + " requires --basis " + word_of(basis_words, *key.only_with));
    if (!key.retired.empty() && found->second == std::vector{key.retired})
      throw InputError(key.option + ": '" + key.retired + "' is retired: " + key.successor);
    std::visit(TakeWords{key, found->second}, key.scene.value);
    given.push_back(key.scene.key);
  }
  if (reduction.interface_sets.empty())
    throw InputError("--interface is missing: name the sideset or nodeset whose nodes are kept");
  complete(reduction, given);
  if (!reduction.modes && !reduction.cutoff_hz && !reduction.tolerance)
    throw InputError("--modes, --cutoff-hz or --tolerance is missing: give one of them");
  if (reduction.tolerance && command.reduction.count("pick") > 0)
    throw InputError(
        "--pick requires --modes: with --tolerance the modes are chosen by participation");
  check_massless(reduction, "command line");
  check_characteristic(reduction, "command line");
  return reduction;
}

void add_reduction_options(CLI::App& group, ReduceCommand& command) {
  std::map<std::string, CLI::Option*> options;
  ReductionOptions none;
  for (const ReductionKey& key : reduction_keys(none)) {
    if (key.option.empty()) continue;
    const std::string& name = key.scene.key;
    auto& words = command.reduction;
    if (key.type_name.empty()) {
      options[name] = group.add_flag_function(
          key.option, [&words, name](std::int64_t) { words[name] = {"true"}; }, key.help);
    } else if (std::holds_alternative<NameList>(key.scene.value)) {
      options[name] =
          group
              .add_option_function<std::vector<std::string>>(
                  key.option, [&words, name](const auto& texts) { words[name] = texts; }, key.help)
              ->allow_extra_args(false)
              ->type_name(key.type_name);
    } else {
      options[name] =
          group
              .add_option_function<std::string>(
                  key.option, [&words, name](const auto& text) { words[name] = {text}; }, key.help)
              ->type_name(key.type_name);
    }
  }
  options["cutoff_hz"]->excludes(options["modes"]);
  options["tolerance"]->excludes(options["modes"])->excludes(options["cutoff_hz"]);
}

}  // namespace

void add_reduce_options(CLI::App& app, ReduceCommand& command) {
  app.add_option("INPUT", command.input,
                 "scene (YAML), - for a scene on standard input, or mesh (.msh .exo .e .g .inp "
                 ".bdf .med .unv .vtk)")
      ->required();
  auto* mesh = app.add_option_group("with a mesh",
                                    "description of the component; in a scene these are keys");
  add_reduction_options(*mesh, command);
  mesh->add_option("--youngs-modulus", command.youngs_modulus,
                   "in consistent units, like all quantities")
      ->type_name("E");
  mesh->add_option("--poissons-ratio", command.poissons_ratio, "between -1 and 0.5")
      ->type_name("NU");
  mesh->add_option("--density", command.density, "mass per volume")->type_name("RHO");
  mesh->add_option("--element", command.element,
                   "hex8-incompatible (default), hex8, hex8-hourglass or reduced (C3D20R, ...)")
      ->type_name("WORD");
  mesh->add_option(
          "--mass", command.mass,
          "auto (default: consistent for hex20, tet10, wedge15 and shells, lumped for others), "
          "lumped or consistent")
      ->type_name("WORD");
  mesh->add_option(
          "-o,--output", command.output,
          "superelement file (default: name of the mesh with .cbr.h5, in the current folder)")
      ->type_name("FILE");
  auto* estimate = app.add_flag("--estimate", command.estimate,
                                "print the expected size and memory of the reduction, beside "
                                "Eqs 5-17 of the paper, and do not reduce. A mesh "
                                "needs no material for it, except with --cutoff-hz");
  auto* info = app.add_flag("--info", command.info,
                            "describe INPUT, which is a superelement, results, fields or "
                            "checkpoint file: its origin, dofs, lowest frequencies, "
                            "faces, mass and known errors");
  auto* exporting = app.add_option("--export", command.export_format,
                                   "write the superelement INPUT for other codes: " +
                                       join(export_format_names()) +
                                       "; -o gives the beginning of the files' names "
                                       "(docs/formats.md, \"Files for other codes\")")
                        ->type_name("FORMAT")
                        ->excludes(estimate)
                        ->excludes(info);
  app.add_option("--first-modal-node", command.first_modal_node,
                 "with --export: the node number of the first modal coordinate; the others follow "
                 "(default: the first above the interface's nodes)")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->needs(exporting);
  auto* import =
      app.add_option(
             "--import", command.import_format,
             "make a superelement of INPUT, a file of another code: " +
                 join(import_format_names()) +
                 "; -o gives the superelement's name (docs/formats.md, \"Files of other codes\")")
          ->type_name("FORMAT")
          ->excludes(estimate)
          ->excludes(info)
          ->excludes(exporting);
  app.add_option("--faces", command.faces,
                 "with --import: the mesh of the same component, which gives the superelement its "
                 "faces and node sets")
      ->type_name("MESH")
      ->needs(import);
  app.add_flag("--force", command.force, "reduce even if the superelement file is up to date");
  app.add_option_function<std::string>(
         "--memory",
         [&command](const std::string& text) {
           const std::string wrong = parse_bytes(text, command.memory);
           if (!wrong.empty()) throw CLI::ValidationError("--memory", wrong);
         },
         "memory for the constraint modes, e.g. 500MB (default: half of RAM minus the factor); "
         "less is slower")
      ->type_name("SIZE");
  app.add_option("--engine", command.engine,
                 "cholmod (default), or petsc, as under mpirun: factor and modes by PETSc, MUMPS "
                 "and SLEPc (docs/distributed.md)")
      ->type_name("WORD")
      ->check(CLI::IsMember({"cholmod", "petsc"}));
  app.add_option("--diagonal-limit", command.diagonal_limit,
                 "largest number of coordinates for which the diagonal form is stored (default: "
                 "6000; 3000 for joined domains)")
      ->type_name("N")
      ->check(whole_number("coordinates", 0));
}

Scene scene_of_mesh(const ReduceCommand& command) {
  Scene scene;
  Component component;
  component.name = std::filesystem::path(command.input).stem().string();
  component.mesh = absolute(command.input);
  component.material = "material";
  component.source.file = "command line";
  const bool no_material = !command.youngs_modulus && !command.poissons_ratio && !command.density;
  if (command.estimate && no_material && command.reduction.count("cutoff_hz") == 0) {
    scene.materials["material"] = {1, 0, 1};  // nothing depends on it
  } else if (no_material && may_hold_materials(component.mesh)) {
    component.material.clear();  // that of the file
  } else {
    scene.materials["material"] = {
        number_in("--youngs-modulus", command.youngs_modulus, 0, INFINITY, "a positive number"),
        number_in("--poissons-ratio", command.poissons_ratio, -1, 0.5,
                  "a number between -1 and 0.5 (both excluded)"),
        number_in("--density", command.density, 0, INFINITY, "a positive number")};
  }
  if (!command.element.empty()) component.element = one_of("--element", command.element, hex_words);
  component.mass = one_of("--mass", command.mass, mass_words);
  add_points_of_deck(component);
  ReductionOptions reduction = reduction_of(command);
  reduction.superelement =
      absolute(command.output.empty() ? component.name + ".cbr.h5" : command.output);
  component.reduction = reduction;
  Instance instance;
  instance.name = instance.component = component.name;
  scene.components[component.name] = component;
  scene.instances.push_back(instance);
  drop_idle_points(scene);
  return scene;
}

}  // namespace cbr

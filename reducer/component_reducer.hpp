// SPDX-License-Identifier: GPL-3.0-or-later
// One component after another, from its mesh to its superelement file.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/app/report.hpp"
#include "common/files/checked_files.hpp"
#include "common/scene/scene.hpp"
#include "common/superelement/superelement.hpp"
#include "reducer/bases/reduce.hpp"
#include "reducer/command.hpp"
#include "reducer/domains/domains.hpp"

namespace cbr {

// The mass that the component has, the rigid body that its geometry is, whether the scene has
// statics alone, and sets that may touch other bodies in exact motion.
struct ComponentMass {
  MassKind kind = MassKind::lumped;
  RigidBody geometry;
  bool is_static = false;
  std::set<std::string> touching = {};
};

// Up to which number of coordinates the diagonal form is stored, if it is read.
Index diagonal_limit(const ReduceCommand& command, const ReductionOptions& reduction);

bool has_shells(const Mesh& mesh);

class ComponentReducer {
 public:
  ComponentReducer(const ReduceCommand& command, Report& report)
      : report_(report), command_(command) {}

  // Reduces the component, or says that its file is up to date, or copies that of an equal one.
  // InputError: everything wrong with the component, its mesh and its sets.
  void reduce_component(const Scene& scene, const Component& component);

 private:
  void make(const Scene& scene, const Component& component, const std::string& hash,
            const UnchangedFiles& inputs);
  Index form_limit() const;
  void add_form(const Component& component, const UnchangedFiles& inputs);
  void make_one(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                const Component& component, const std::string& hash,
                const std::map<std::string, std::string>& provenance);
  void make_group(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                  const Component& component, const std::string& hash,
                  const std::map<std::string, std::string>& provenance);
  void make_second(const Mesh& mesh, const SuperelementGroup& group, Index n_dofs,
                   const Component& component, const std::string& hash,
                   const std::map<std::string, std::string>& provenance);
  void finish(Superelement&& s, const ReductionFigures& figures, const Component& component,
              const std::string& hash, const std::map<std::string, std::string>& provenance);

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

// --- the file of a component before anything is reduced: up to date or not, and what is written
// into it of its making ---

// Unchanged inputs; without_form: all is there but the diagonal form, which is wanted.
enum class FileState { current, without_form, stale };

// Of how many coordinates the diagonal form is wanted; an `exact` limit of the command line wants
// larger ones without it.
struct WantedForm {
  Index limit = 0;
  bool exact = false;
};

// Compares the file with the scene and its mesh; hash: content_hash(), loads: load_sets().
FileState state_of(const Scene& scene, const Component& component, const std::string& hash,
                   const std::vector<std::string>& loads, const WantedForm& wanted);

// InputError: the file is a mesh, the scene or of another kind. A mistyped -o or superelement:
// would cost the user one of these.
void refuse_to_overwrite(const Scene& scene, const std::string& input,
                         const std::filesystem::path& target);

// The file's provenance.
std::map<std::string, std::string> provenance(const Scene& scene, const Component& component,
                                              const std::vector<BlockProperties>& properties,
                                              const Mesh& mesh);

// --- the summary of cbr-reduce about a superelement that it made (summary.cpp) ---

void summarise(const Superelement& superelement, const ReductionFigures& figures,
               const ComponentMass& mass, const std::filesystem::path& file, Report& report);

// A decomposed component: figures of its domains, and the file of the group. rho:
// residual_mass_share() of the group; none: not computed.
void summarise_domains(const SuperelementGroup& group, const GroupFigures& figures,
                       const std::optional<Vector3>& rho, const ComponentMass& mass,
                       Report& report);
void summarise_group(const SuperelementGroup& group, const ComponentMass& mass,
                     const std::filesystem::path& file, Report& report);

}  // namespace cbr

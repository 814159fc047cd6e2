// SPDX-License-Identifier: GPL-3.0-or-later
#include "reducer/domains/domains.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <set>

#include "common/app/report.hpp"
#include "common/base/error.hpp"
#include "common/base/threads.hpp"
#include "common/fem/connected_parts.hpp"
#include "common/linalg/blas_threads.hpp"
#include "common/linalg/dense.hpp"
#include "reducer/condensation/condensation.hpp"
#include "reducer/condensation/superelement_algebra.hpp"
#include "reducer/domains/decomposition.hpp"
#include "reducer/judgement/accuracy.hpp"
#include "reducer/modes/diagonal_form.hpp"
#include "reducer/partition/interface_sets.hpp"
#include "reducer/partition/partition.hpp"

namespace cbr {
namespace {

// All threads to the workers, none to BLAS and to solves within one of them.
class OneThreadEach {
 public:
  OneThreadEach() : before_(n_threads()) { set_threads(1); }
  ~OneThreadEach() { set_threads(before_); }
  OneThreadEach(const OneThreadEach&) = delete;
  OneThreadEach& operator=(const OneThreadEach&) = delete;

 private:
  int before_;
};

// Mesh nodes of the component's interface.
std::vector<Index> kept_nodes(const Mesh& mesh, const FiniteElementModel& model,
                              const std::vector<std::string>& sets) {
  std::vector<Index> nodes;
  for (const Index i : interface_nodes(mesh, model, sets)) nodes.push_back(model.nodes[i]);
  return nodes;
}

// Names of the sets that one superelement of the whole would keep: not those that happen to lie
// between two domains.
std::vector<std::string> kept_sets(const Mesh& mesh, const std::vector<Index>& interface,
                                   const std::vector<std::string>& named) {
  std::vector<Index> place(mesh.node_ids.size(), -1);
  for (std::size_t i = 0; i < interface.size(); ++i) place[interface[i]] = static_cast<Index>(i);
  Superelement whole;
  add_interface_sets(mesh, place, named, whole);
  std::vector<std::string> names;
  for (const Surface& surface : whole.surfaces) names.push_back(surface.name);
  for (const auto& [name, nodes] : whole.nodesets) names.push_back(name);
  return names;
}

class DomainReducer {
 public:
  DomainReducer(const std::vector<BlockProperties>& properties, MassKind mass,
                const ReductionOptions& options, const ReduceSettings& settings,
                const DomainShare& share, std::vector<Domain>&& domains)
      : properties_(properties),
        mass_(mass),
        options_(options),
        settings_(settings),
        share_(share),
        domains_(std::move(domains)),
        superelements_(domains_.size()),
        figures_(domains_.size()),
        failures_(domains_.size()) {}

  std::vector<Superelement> run(Report& report, GroupFigures& figures) {
    std::vector<std::size_t> own;
    for (std::size_t d = 0; d < domains_.size(); ++d) {
      if (share_.is_own(d)) {
        own.push_back(d);
      } else {
        domains_[d] = Domain();
      }
    }
    const auto n = static_cast<int>(own.size());
    figures.n_workers = std::clamp(n_threads(), 1, std::max(1, n));
    figures.n_processes = share_.processes;
    settings_.memory = (settings_.memory > 0 ? settings_.memory : half_of_memory() / share_.here) /
                       figures.n_workers;
    settings_.diagonal_limit = 0;
    settings_.is_domain = true;
    about_ = report.about();
    {
      const OneThreadEach one;
      std::atomic<int> next = 0;
      run_threads(figures.n_workers, [&](int worker) {
        for (int d = next++; d < n; d = next++) {
          reduce_domain(own[d]);
          if (worker == 0) report.progress("domains", static_cast<double>(d + 1) / n);
        }
      });
      report.end_progress();
    }
    share_.together([&] { rethrow(); });
    share_.gather(superelements_, figures_);
    if (!share_.is_first) return {};
    tell_warnings(report);
    for (std::size_t d = 0; d < figures_.size(); ++d) {
      report.about(about_of(d));
      report_conditioning(figures_[d].reduction.condition, report, true);
    }
    report.about(about_);
    figures.domains = std::move(figures_);
    return std::move(superelements_);
  }

 private:
  // Of other processes, which do not print.
  void tell_warnings(Report& report) const {
    report.about("");  // they name their subject
    for (std::size_t d = 0; d < figures_.size(); ++d)
      for (const std::string& warning : figures_[d].warnings)
        if (!share_.is_own(d)) report.warning(warning);
    report.about(about_);
  }

  std::string about_of(std::size_t d) const {
    return about_ + "domain " + std::to_string(d + 1) + " of " +
           std::to_string(superelements_.size()) + ": ";
  }

  void reduce_domain(std::size_t d) {
    try {
      Domain domain = std::move(domains_[d]);  // freed when reduced
      std::vector<BlockProperties> properties;
      for (const Index block : domain.block) properties.push_back(properties_[block]);
      ReductionOptions options = options_;
      const Index n_I = 3 * static_cast<Index>(domain.node.size() - domain.interface.size());
      if (options.modes && *options.modes > n_I) {
        figures_[d].modes_missing = *options.modes - n_I;
        options.modes = n_I;
      }
      for (const Block& block : domain.mesh.blocks)
        figures_[d].n_elements += block.connectivity.rows();
      Report silent("cbr-reduce", Verbosity::quiet);  // but for warnings
      silent.about(about_of(d));
      superelements_[d] = reduce(domain.mesh, properties, mass_, options, domain.interface,
                                 settings_, silent, &figures_[d].reduction);
      figures_[d].warnings = silent.warnings();
    } catch (...) {
      failures_[d] = std::current_exception();
    }
  }

  // The first domain's, whoever failed first.
  void rethrow() const {
    for (std::size_t d = 0; d < failures_.size(); ++d) {
      if (!failures_[d]) continue;
      const std::string where =
          "domain " + std::to_string(d + 1) + " of " + std::to_string(failures_.size()) + ": ";
      try {
        std::rethrow_exception(failures_[d]);
      } catch (const InputError& error) {
        throw InputError(where + error.what());
      } catch (const RunError& error) {
        throw RunError(where + error.what());
      }
    }
  }

  const std::vector<BlockProperties>& properties_;
  const MassKind mass_;
  const ReductionOptions& options_;
  ReduceSettings settings_;
  const DomainShare& share_;
  std::string about_;
  std::vector<Domain> domains_;
  std::vector<Superelement> superelements_;
  std::vector<DomainFigures> figures_;
  std::vector<std::exception_ptr> failures_;
};

// Of bodies fixed to each other: Steiner's theorem.
RigidBody together(const std::vector<Superelement>& parts) {
  RigidBody whole;
  for (const auto& s : parts) whole.mass += s.rigid_body.mass;
  for (const auto& s : parts) whole.center += s.rigid_body.mass / whole.mass * s.rigid_body.center;
  for (const auto& s : parts) {
    const Vector3 arm = s.rigid_body.center - whole.center;
    whole.inertia +=
        s.rigid_body.inertia +
        s.rigid_body.mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  whole.inertia = (0.5 * (whole.inertia + whole.inertia.transpose())).eval();
  return whole;
}

void add_diagonal(const Mesh& mesh, const ReduceSettings& settings, Report& report,
                  SuperelementGroup& group) {
  const Index limit = settings.diagonal_limit;
  Index n = 0;
  for (const auto& s : group.domains) n += s.k();
  n += 3 * static_cast<Index>(join_nodes(group).node_ids.size());
  if (n > limit) {
    report.detail("the domains together: more than " + std::to_string(limit) +
                  " coordinates, whose matrices are not formed: " +
                  "condition of the mass, frequencies and mechanisms not computed");
    return;
  }
  const auto phase = report.phase("diagonal form");
  Superelement whole = join(group);
  const std::vector<Index> part = parts_of(mesh, whole.node_ids);
  Conditioning condition;
  const Cholesky M_res = residual_mass_factor(whole);
  condition.n_rigid = settings.is_diagonal_read ? add_diagonal_form(whole, part, &M_res)
                                                : add_lowest_modes(whole, part, n_beside);
  condition.reduced_rigid =
      rigid_residual(whole.K_cc,
                     reduced_rigid_modes(whole, group.rigid_body.center).bottomRows(whole.c()))
          .value;
  const Index loose = examine_reduced(whole, rigid_motions_of_parts(whole, part), M_res, condition);
  if (loose >= 0) condition.loose_node = name_of_node_id(mesh, whole.node_ids[loose / 3]);
  const std::string about = report.about();
  report.about(about + "the domains together: ");
  report_conditioning(condition, report);
  warn_of_conditioning(condition, report);
  report.about(about);
  group.conditioning = condition;
  if (!settings.is_diagonal_read) return;
  group.omega = std::move(whole.omega);
  group.V = std::move(whole.V);
}

}  // namespace

std::vector<Index> component_interface(const Mesh& mesh, const std::vector<std::string>& sets) {
  std::vector<Index> ids;
  for (const Index node : kept_nodes(mesh, number_nodes(mesh), sets))
    ids.push_back(mesh.node_ids[node]);
  return ids;
}

std::optional<Vector3> residual_mass_share(const SuperelementGroup& group,
                                           const std::vector<Index>& interface_ids, Index most) {
  const JoinedNodes joined = join_nodes(group);
  const std::set<Index> kept(interface_ids.begin(), interface_ids.end());
  std::vector<Index> number(joined.node_ids.size(), -1);  // of nodes that are free to move
  Index n = 0;
  for (std::size_t i = 0; i < number.size(); ++i)
    if (!kept.count(joined.node_ids[i])) number[i] = n++;
  if (3 * n > most) return {};
  Matrix S_bb = Matrix::Zero(3 * n, 3 * n), S_br = Matrix::Zero(3 * n, 3);
  Vector3 whole = Vector3::Zero();  // r^T S_cc r
  for (std::size_t d = 0; d < group.domains.size(); ++d) {
    const Superelement& s = group.domains[d];
    Matrix S = s.M_cc, R = Matrix::Zero(s.c(), 3);
    if (s.k() > 0) S.noalias() -= s.M_kc.transpose() * s.M_kc;
    std::vector<Index> rows, at;  // of S, of S_bb
    for (Index i = 0; i < s.c(); ++i) {
      const auto dof = static_cast<std::size_t>(i);
      const Index free = number[joined.place[d][s.dof_node[dof]]];
      if (free < 0) {
        R(i, s.dof_component[dof]) = 1;
      } else {
        rows.push_back(i);
        at.push_back(3 * free + s.dof_component[dof]);
      }
    }
    const Matrix S_R = S * R;
    whole += (R.cwiseProduct(S_R)).colwise().sum().transpose();
    S_br(at, Eigen::all) += S_R(rows, Eigen::all);
    S_bb(at, at) += S(rows, rows);
  }
  if (n > 0) {
    if (!dense_cholesky(S_bb)) return {};
    S_bb.triangularView<Eigen::Lower>().solveInPlace(S_br);
    whole -= S_br.colwise().squaredNorm().transpose();
  }
  return Vector3(whole / group.rigid_body.mass);
}

std::vector<Index> parts_of(const Mesh& mesh, const std::vector<Index>& node_ids) {
  const FiniteElementModel model = number_nodes(mesh);
  const std::vector<Index> part_of_node = connected_parts(mesh, model);
  std::map<Index, Index> part_of_id;
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    part_of_id[mesh.node_ids[model.nodes[i]]] = part_of_node[i];
  }
  std::vector<Index> parts;
  for (const Index id : node_ids) parts.push_back(part_of_id.at(id));
  return parts;
}

SuperelementGroup reduce_domains(const Mesh& mesh, const std::vector<BlockProperties>& properties,
                                 MassKind mass, const ReductionOptions& options,
                                 const ReduceSettings& settings, Report& report,
                                 GroupFigures* figures, const DomainShare& share) {
  GroupFigures own;
  GroupFigures& f = figures != nullptr ? *figures : own;
  const FiniteElementModel model = number_nodes(mesh);
  const std::vector<Index> interface = kept_nodes(mesh, model, options.interface_sets);
  std::vector<Domain> domains;
  {
    const auto phase = report.phase("decomposition");
    const Decomposition decomposition = decompose(mesh, options.domains);
    f.n_dofs = 3 * static_cast<Index>(model.nodes.size());
    tell_of_parts(mesh, model, connected_parts(mesh, model), report);
    f.n_shared_nodes = static_cast<Index>(shared_nodes(mesh, decomposition).size());
    domains =
        split(mesh, decomposition, interface, kept_sets(mesh, interface, options.interface_sets));
  }
  SuperelementGroup group;
  {
    const double before = report.seconds("reduction of the domains");
    {
      const auto phase = report.phase("reduction of the domains");
      group.domains = DomainReducer(properties, mass, options, settings, share, std::move(domains))
                          .run(report, f);
    }
    f.seconds = report.seconds("reduction of the domains") - before;
  }
  if (!share.is_first) return {};
  group.rigid_body = together(group.domains);
  if (options.tolerance)
    report.warning("the tolerance holds in each of the " + std::to_string(group.domains.size()) +
                   " domains, and not of what they make together: its lowest frequencies may be "
                   "several times farther off; "
                   "take domains: 1 where it has to hold, or a smaller tolerance");
  if (!options.has_second_reduction()) add_diagonal(mesh, settings, report, group);
  return group;
}

}  // namespace cbr

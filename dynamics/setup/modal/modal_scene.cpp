// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/modal/modal_scene.hpp"

#include <algorithm>
#include <cassert>
#include <set>

#include "common/base/error.hpp"
#include "common/linalg/dense.hpp"
#include "common/scene/scene_words.hpp"
#include "dynamics/run/contact/contact_step.hpp"
#include "dynamics/run/equilibrium.hpp"

namespace cbr {
namespace {

// Whether the joint has no spring against motion along the weight.
bool is_without_spring(const JointBody& joint, Index node, const Vector3& weight) {
  if (joint.joint().is_mass()) return false;
  Vector6 motion = Vector6::Zero();
  motion.segment<3>(3 * node) = joint.joint().axes * weight;
  const bool sticks = joint.joint().friction.dot(motion.cwiseAbs()) > 0;
  return !sticks && (joint.stiffness() * motion).isZero(0);
}

// Adds a row for each component of the relative position of a tied point, except rows of zeros of
// its frame.
void add_rows(const Simulation& sim, const ContactList& list, std::vector<TieRow>& rows) {
  for (const ContactPoint& point : list.points) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 direction = point.frame.row(axis).transpose();
      if (direction.isZero(0)) continue;
      TieRow row;
      for (Index t = point.first_term; t < point.first_term + point.n_terms; ++t) {
        const ContactTerm& term = list.terms[t];
        const ContactNodes& contact = sim.contact_nodes[term.body];
        const auto of = std::find_if(row.of_bodies.begin(), row.of_bodies.end(),
                                     [&](const auto& one) { return one.first == contact.body; });
        NodalSum& sum = of == row.of_bodies.end()
                            ? row.of_bodies.emplace_back(contact.body, NodalSum()).second
                            : of->second;
        const Index node = contact.nodes[term.node];
        sum.terms.emplace_back(node, term.coefficient * direction);
        if (const auto* joint = dynamic_cast<const JointBody*>(sim.bodies[contact.body].get()))
          row.is_dashpot |= is_without_spring(*joint, node, direction);
      }
      rows.push_back(std::move(row));
    }
  }
}

// Reports incomplete ties, whose free motions appear in the frequencies.
void tell_ties(const Simulation& sim, Report& report) {
  for (const ContactPair& pair : sim.pairs) {
    if (!pair.has_state()) continue;
    const TieReport& tie = pair.seen().tie_report;
    const std::string text = tie_text(tie, *pair.slave);
    if (text.empty()) continue;
    tie.free_motions > 0 ? report.warning("contact " + pair.name + ": " + text)
                         : report.line("note: contact " + pair.name + ": " + text);
  }
}

// The scene as statics load it before the time 0.
Scene preloaded(Scene scene) {
  const bool grow = scene.time->is_static;
  TimeOptions time;
  time.end = 1;
  time.step = 1;
  time.is_static = true;
  time.preload = preload_steps(scene);
  scene.time = time;
  for (Load& load : scene.loads)
    if (!grow && load.history.time.empty()) load.history = {{0, 1}, {1, 1}};
  for (Instance& instance : scene.instances) instance.velocity.setZero();
  return scene;
}

// Rows of contact that the preload closes: no gap opens, and nothing with friction slips. A point
// that slips in the preload sticks in a small oscillation: its force is within the limit once the
// motion has turned back.
void add_closed(const Scene& scene, const BuildOptions& options, Report& report,
                std::vector<TieRow>& rows) {
  BuiltScene built = build(scene, report, options);
  Simulation& sim = built.simulation;
  const auto phase = report.phase("statics");
  ContactState state = start_contact(sim);
  ContactOutcome outcome;
  outcome.start(sim);
  Equilibrium equilibrium(sim, state, outcome);
  RunResult result;
  const bool is_found = equilibrium.preload(sim.preload, result, [&](Index done) {
    report.progress("statics", static_cast<double>(done) / static_cast<double>(sim.preload));
  });
  report.end_progress();
  if (!is_found) throw RunError(result.failure);
  const std::vector<ContactList> closed = equilibrium.closed_points();
  const std::size_t n_tied = rows.size();
  for (std::size_t p = 0; p < closed.size(); ++p) {
    const ContactPair& pair = sim.pairs[p];
    if (pair.law.law == ContactLaw::tied) continue;
    add_rows(sim, closed[p], rows);
    report.line("contact " + pair.name + ": " + std::to_string(closed[p].points.size()) +
                " points are closed by the preload" +
                (pair.law.law == ContactLaw::coulomb ? ", and stick" : ""));
  }
  if (rows.size() == n_tied) report.warning("the preload closes no contact: no force acts there");
}

// M = L L^T over the motions with mass: L^-T as columns, 6 x n, so that V^T M V = 1.
Matrix mass_shapes(const Matrix6& M) {
  std::vector<Index> rows;
  for (Index i = 0; i < 6; ++i)
    if (!M.row(i).isZero(0)) rows.push_back(i);
  const auto n = static_cast<Index>(rows.size());
  Matrix V = Matrix::Zero(6, n), columns = Matrix::Identity(n, n);
  if (n == 0) return V;
  Cholesky(M(rows, rows)).solve_upper_in_place(columns);
  V(rows, Eigen::all) = columns;
  return V;
}

}  // namespace

BodyModes::BodyModes(Body& body_of_scene, const MeshModes* mesh) : mesh_(mesh) {
  joint_ = dynamic_cast<const JointBody*>(&body_of_scene);
  if (joint_ != nullptr) {
    omega_ = Vector::Zero(mass_shapes(joint_->joint().mass).cols());
    return;
  }
  points_ = body_of_scene.points();
  modal_ = dynamic_cast<ModalBody*>(&body_of_scene);
  assert(modal_ != nullptr && !modal_->turns());
  omega_ = modal_->form().omega;
}

Vector BodyModes::damping_rates() const {
  if (is_joint() || !modal_->is_damped()) return Vector::Zero(omega().size());
  return modal_->damping_rates();
}

Vector BodyModes::loads() const {
  return is_joint() ? Vector(Vector::Zero(omega().size())) : modal_->load_amplitude();
}

Vector BodyModes::gravity(const Vector3& acceleration) const {
  if (is_joint()) return Vector::Zero(omega().size());
  return modal_->form().E.leftCols(3) * (modal_->axes().transpose() * acceleration);
}

Matrix BodyModes::modal_rows(const std::vector<NodalSum>& sums) const {
  const ModalForm& form = modal_->form();
  Matrix A = Matrix::Zero(static_cast<Index>(sums.size()), form.omega.size());
  for (Index i = 0; i < A.rows(); ++i) {
    for (const auto& [node, weight] : sums[i].terms) {
      const Vector3 local = modal_->axes().transpose() * weight;
      for (int d = 0; d < 3; ++d)
        if (const Index row = modal_->rows()(node, d); row >= 0 && local[d] != 0)
          A.row(i) += local[d] * form.V.row(row);
    }
  }
  return A;
}

std::vector<std::pair<Index, Vector3>> BodyModes::inner_terms(const NodalSum& sum) const {
  if (points_ == nullptr) return sum.terms;
  std::vector<std::pair<Index, Vector3>> terms;
  for (const auto& [node, weight] : sum.terms) points_->add_own_terms(node, weight, terms);
  return terms;
}

ModalAnswer BodyModes::answer(const std::vector<NodalSum>& sums, int terms) const {
  if (is_joint()) return answer_of_joint(sums);
  if (points_ == nullptr) return answer_of_modes(sums, terms);
  std::vector<NodalSum> inner(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) inner[i].terms = inner_terms(sums[i]);
  return answer_of_modes(inner, terms);
}

SparseMatrix BodyModes::mesh_rows(const std::vector<NodalSum>& sums) const {
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (const auto& [node, weight] : inner_terms(sums[i])) {
      const Vector3 own = local(weight);
      for (int c = 0; c < 3; ++c)
        if (own[c] != 0) entries.emplace_back(static_cast<Index>(i), 3 * node + c, own[c]);
    }
  SparseMatrix A(static_cast<Index>(sums.size()), 3 * modal_->own_nodes().rows());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

void BodyModes::take_shapes(const Matrix& shapes) {
  auto form = std::make_shared<ModalForm>();
  form->omega = omega_ = Vector::Zero(shapes.cols());
  form->V = shapes;
  form->n_rigid = shapes.cols();
  form->E = Matrix::Zero(shapes.cols(), 6);
  modal_->take_form(std::move(form));
}

ModalAnswer BodyModes::answer_of_joint(const std::vector<NodalSum>& sums) const {
  const Joint& joint = joint_->joint();
  const auto m = static_cast<Index>(sums.size());
  Matrix B = Matrix::Zero(m, 6);
  for (Index i = 0; i < m; ++i)
    for (const auto& [node, weight] : sums[i].terms)
      B.row(i).segment<3>(3 * node) += (joint.axes * weight).transpose();
  ModalAnswer answer;
  answer.r = {Vector::Zero(m)};
  answer.I = {Matrix::Zero(m, 3)};
  answer.A = B * mass_shapes(joint.mass);
  if (joint.is_mass()) return answer;
  answer.S = {B * joint_->compliance() * B.transpose()};
  answer.B = B;
  answer.K = joint_->stiffness();
  answer.C = joint.damping;
  return answer;
}

ModalAnswer BodyModes::answer_of_modes(const std::vector<NodalSum>& sums, int terms) const {
  ModalAnswer answer;
  answer.A = modal_rows(sums);
  const auto m = static_cast<Index>(sums.size());
  answer.r = {Vector::Zero(m)};
  answer.I = {Matrix::Zero(m, 3)};
  const Matrix3& T = modal_->axes();
  if (modal_->form().residual) {
    const StaticRows& rows = modal_->form().residual->rows;
    Matrix B = Matrix::Zero(m, rows.size());
    for (Index i = 0; i < m; ++i)
      for (const auto& [node, weight] : sums[i].terms)
        for (Index s = 0; s < rows.size(); ++s)
          if (rows.node[s] == node) B(i, s) += rows.direction.row(s) * (T.transpose() * weight);
    const Matrix FB = rows.F * B.transpose();
    answer.S = {B * FB};
    answer.r = {FB.transpose() * modal_->residual().load()};
  }
  if (mesh_ != nullptr && !mesh_->is_complete()) add_series(sums, terms, answer);
  return answer;
}

// In batches, as each sum needs a vector of the mesh's size.
void BodyModes::add_series(const std::vector<NodalSum>& sums, int terms,
                           ModalAnswer& answer) const {
  constexpr Index at_a_time = 64;
  const auto m = static_cast<Index>(sums.size());
  const auto n = static_cast<std::size_t>(terms);
  SparseMatrix A(m, 3 * modal_->own_nodes().rows());
  std::vector<Eigen::Triplet<double, Index>> entries;
  for (Index i = 0; i < m; ++i)
    for (const auto& [node, weight] : sums[i].terms)
      for (int c = 0; c < 3; ++c) entries.emplace_back(i, 3 * node + c, local(weight)[c]);
  A.setFromTriplets(entries.begin(), entries.end());
  const SparseMatrix At = A.transpose();
  answer.S.assign(n, Matrix::Zero(m, m));
  answer.r.assign(n, Vector::Zero(m));
  answer.I.assign(n, Matrix::Zero(m, 3));
  answer.sigma = mesh_->sigma();
  for (Index j = 0; j < m; j += at_a_time) {
    const Index q = std::min(at_a_time, m - j);
    const std::vector<Matrix> R = mesh_->left_out(Matrix(At.middleCols(j, q)), terms);
    for (std::size_t k = 0; k < n; ++k) answer.S[k].middleCols(j, q) = A * R[k];
  }
  Matrix own(3 * modal_->own_nodes().rows(), 4);
  const Points& forces = modal_->forces();
  own.col(0) = Eigen::Map<const Vector>(forces.data(), forces.size());
  own.rightCols(3) = mesh_->inertia();
  const std::vector<Matrix> R = mesh_->left_out(own, terms);
  for (std::size_t k = 0; k < n; ++k) {
    const Matrix y = A * R[k];
    answer.r[k] = y.col(0);
    answer.I[k] = y.rightCols(3);
  }
}

bool has_ties(const Scene& scene) {
  return !scene.links.empty() || preload_steps(scene) > 0 ||
         std::any_of(scene.contact.begin(), scene.contact.end(),
                     [](const ContactOptions& contact) { return contact.tied; }) ||
         std::any_of(scene.components.begin(), scene.components.end(),
                     [](const auto& component) { return !component.second.points.empty(); });
}

std::unique_ptr<ModalScene> modal_scene(const Scene& scene, const MeshModesWanted& wanted,
                                        bool loads, Report& report) {
  auto modal = std::make_unique<ModalScene>();
  modal->scene = scene;
  TimeOptions time;  // every superelement in its diagonal form; without steps
  time.end = 1;
  time.step = 1;
  time.force_step = true;
  modal->scene.time = time;
  modal->scene.output.checkpoint.reset();
  modal->scene.output.stress.clear();
  modal->scene.output.every = 0;
  for (Instance& instance : modal->scene.instances) instance.angular_velocity.setZero();
  for (BoundaryCondition& condition : modal->scene.boundary) condition.motion = SupportMotion::none;
  modal->scene.output.reactions.clear();
  Scene before = modal->scene;
  before.time = scene.time;
  const auto n_gravity = std::erase_if(
      modal->scene.loads, [](const Load& load) { return load.kind == Load::Kind::gravity; });
  if (!loads) modal->scene.loads.clear();
  const auto n_closing = std::erase_if(modal->scene.contact,
                                       [](const ContactOptions& contact) { return !contact.tied; });
  const bool is_preloaded = n_closing > 0 && preload_steps(scene) > 0;
  if (loads && n_gravity > 0)
    report.line("note: gravity does not excite a sweep: it acts in load steps alone");
  if (n_closing > 0 && !is_preloaded)
    report.line(
        "note: contact that is not tied is left out: what it alone holds moves freely, with "
        "frequencies of 0 (time.preload, tied: true, or boundary, holds it)");
  BuildOptions options;
  options.mesh_modes = wanted;
  options.reduced_for = &scene;
  modal->built = build(modal->scene, report, options);
  std::set<std::string> told;
  for (const auto& of : modal->built.instances)
    if (of.mass_kind && told.insert(of.component).second)
      report.line("component '" + of.component + "': its mesh has " +
                  word_of(mass_words, of.mass_kind) + " mass");
  Simulation& sim = modal->built.simulation;
  for (std::size_t b = 0; b < sim.bodies.size(); ++b)
    modal->bodies.emplace_back(*sim.bodies[b], b < modal->built.instances.size()
                                                   ? modal->built.instances[b].modes.get()
                                                   : nullptr);
  start_contact(sim);
  tell_ties(sim, report);
  for (const ContactPair& pair : sim.pairs)
    if (pair.has_state()) add_rows(sim, pair.seen().ties, modal->ties);
  if (is_preloaded) {
    options.mesh_modes.reset();
    add_closed(preloaded(std::move(before)), options, report, modal->ties);
  }
  return modal;
}

}  // namespace cbr

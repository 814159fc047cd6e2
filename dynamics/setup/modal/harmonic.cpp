// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/setup/modal/harmonic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/error.hpp"
#include "common/base/name_text.hpp"
#include "common/linalg/dense.hpp"
#include "dynamics/setup/components/superelement_alone.hpp"
#include "dynamics/setup/modal/modal_scene.hpp"

namespace cbr {
namespace {

using Complex = std::complex<double>;
using ComplexVector = Eigen::Matrix<Complex, Eigen::Dynamic, 1>;

// Meshes have modes up to this multiple of the sweep's end; the others respond by a series in (w /
// omega)^2.
constexpr double modes_beyond = 2;
// Terms of that series: each reduces the error to a quarter.
constexpr int series_terms = 6;
// omega^2 - w^2| / omega^2 of an undamped mode that counts as resonance within round-off.
constexpr double on_resonance = 1e-9;

// Harmonic motion of an instance's supports: amplitude and kind, along each axis.
struct Drive {
  std::array<SupportMotion, 3> motion{};
  Vector3 value = Vector3::Zero();
  bool any() const { return !value.isZero(0); }
  // Amplitude of the displacement at w (rad/s)
  Eigen::Vector3cd displacement(double w) const {
    Eigen::Vector3cd s = Eigen::Vector3cd::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      const double amplitude = value[static_cast<Index>(c)];
      if (motion[c] == SupportMotion::displacement) s[static_cast<Index>(c)] = amplitude;
      if (motion[c] == SupportMotion::velocity)
        s[static_cast<Index>(c)] = amplitude / Complex(0, w);
      if (motion[c] == SupportMotion::acceleration) s[static_cast<Index>(c)] = -amplitude / (w * w);
    }
    return s;
  }
};

std::vector<Drive> drives_of(const Scene& scene_of_run) {
  Scene scene = scene_of_run;
  scene.output.reactions.clear();
  TimeOptions time;
  time.end = 1;
  scene.time = time;
  const SceneIndex index(scene);
  std::vector<Drive> drives;
  for (const Instance& instance : scene.instances) {
    const InstancePlan& plan = index.plan(instance);
    if (!plan.moves_alike)
      refuse(plan.boundary.front()->source, "instance '" + instance.name + "'",
             feature::unlike_supports, feature::sweep);
    Drive drive;
    for (const BoundaryCondition* condition : plan.boundary) {
      if (condition->motion == SupportMotion::none) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = condition->value[static_cast<Index>(c)];
        if (!condition->fix[c] || value == 0) continue;
        drive.motion[c] = condition->motion;
        drive.value[static_cast<Index>(c)] = value;
      }
    }
    drives.push_back(drive);
  }
  return drives;
}

// Output quantities of a body: its part of the rows of ties, then three sums for each output set.
struct Asked {
  std::vector<NodalSum> sums;
  std::vector<Index> tie;  // row of ties for each of the first sums
  std::vector<std::size_t> set;
  ModalAnswer answer;
  Vector c, loads;
  // Damping alpha M + beta K, of a mesh's series and of residual compliance.
  MaterialDamping damping;
  Complex stiffer(double w) const { return {1, w * damping.beta}; }
  // Replaces w^2 in the series, which is then divided by stiffer(w).
  Complex square(double w) const { return Complex(w * w, -w * damping.alpha) / stiffer(w); }
};

class Sweep {
 public:
  Sweep(const Scene& scene, const ModalScene& modal)
      : modal_(modal), drives_(drives_of(scene)), asked_(modal.bodies.size()) {
    drives_.resize(modal.bodies.size());
    for (std::size_t t = 0; t < modal.ties.size(); ++t)
      for (const auto& [body, sum] : modal.ties[t].of_bodies) {
        Asked& of = asked_[body];
        of.tie.push_back(static_cast<Index>(t));
        of.sums.push_back(sum);
      }
    const auto& monitors = modal.built.simulation.monitors;
    for (std::size_t m = 0; m < monitors.size(); ++m) ask(scene.output.history[m], m, monitors[m]);
    for (std::size_t b = 0; b < asked_.size(); ++b) {
      asked_[b].answer = modal.bodies[b].answer(asked_[b].sums, series_terms);
      asked_[b].c = modal.bodies[b].damping_rates();
      if (b < modal.built.instances.size())
        asked_[b].damping = modal.built.instances[b].damping.material;
      asked_[b].loads = modal.bodies[b].loads();
      excites_ |=
          !asked_[b].loads.isZero(0) || drives_[b].any() || !asked_[b].answer.r[0].isZero(0);
    }
  }

  bool excites() const { return excites_; }

  // Displacements of all sets at w (rad/s), three entries each.
  ComplexVector at(double w) const {
    const auto m = static_cast<Index>(modal_.ties.size());
    std::vector<ComplexVector> inverse, y;
    ComplexMatrix W = ComplexMatrix::Zero(m, m);
    ComplexVector apart = ComplexVector::Zero(m);
    for (std::size_t b = 0; b < asked_.size(); ++b) {
      inverse.push_back(dynamic(b, w));
      y.push_back(alone(b, inverse.back(), w));
      add_ties(b, inverse.back(), y.back(), w, W, apart);
    }
    ComplexVector out(3 * static_cast<Index>(modal_.built.simulation.monitors.size()));
    const ComplexVector force = solve(W, -apart);
    for (std::size_t b = 0; b < asked_.size(); ++b) take_sets(b, inverse[b], y[b], force, w, out);
    return out;
  }

 private:
  void ask(const SurfaceName& name, std::size_t set, const Monitor& monitor) {
    if (monitor.is_inside())
      refuse(name.source, "output.history: '" + name.text() + "'", feature::inside, feature::sweep);
    const auto& of = modal_.built.instances[monitor.body];
    const Body& body = *modal_.built.simulation.bodies[monitor.body];
    const std::vector<Index> nodes =
        monitor.has_point ? std::vector<Index>{body.points()->translation_node(monitor.point)}
                          : find_nodes(*of.geometry, name.instance, name.surface, name.source);
    Asked& asked = asked_[monitor.body];
    asked.set.push_back(set);
    for (int axis = 0; axis < 3; ++axis) {
      NodalSum sum;
      for (const Index node : nodes)
        sum.terms.emplace_back(node, Vector3::Unit(axis) / static_cast<double>(nodes.size()));
      asked.sums.push_back(std::move(sum));
    }
  }

  // 1 / (omega^2 - w^2 + i w c)
  ComplexVector dynamic(std::size_t b, double w) const {
    const Vector& omega = modal_.bodies[b].omega();
    ComplexVector inverse(omega.size());
    for (Index j = 0; j < omega.size(); ++j) {
      const Complex d(omega[j] * omega[j] - w * w, w * asked_[b].c[j]);
      if (std::abs(d) <= on_resonance * omega[j] * omega[j])
        throw InputError(
            "sweep: instance '" + modal_.built.instances[b].name +
            "' has a mode without damping at " + std::to_string(w / (2 * std::numbers::pi)) +
            " Hz, where its response has no bound: give it damping, or sweep other frequencies");
      inverse[j] = 1.0 / d;
    }
    return inverse;
  }

  // The sums under the body's own loads and prescribed motion.
  ComplexVector alone(std::size_t b, const ComplexVector& inverse, double w) const {
    const ModalAnswer& of = asked_[b].answer;
    ComplexVector g = asked_[b].loads.cast<Complex>();
    const Eigen::Vector3cd s = drives_[b].displacement(w);
    const Complex x = asked_[b].square(w) - of.sigma, stiffer = asked_[b].stiffer(w);
    const ComplexMatrix inertia = sum(of.I, x) / stiffer;
    ComplexVector left_out = sum(of.r, x) / stiffer;
    for (int axis = 0; axis < 3 && drives_[b].any(); ++axis)
      left_out += (w * w * s[axis]) *
                  (inertia * modal_.bodies[b].local(Vector3::Unit(axis)).cast<Complex>());
    if (drives_[b].any())
      for (int axis = 0; axis < 3; ++axis)
        g += (w * w * s[axis]) * modal_.bodies[b].gravity(Vector3::Unit(axis)).cast<Complex>();
    ComplexVector y = of.A.cast<Complex>() * inverse.cwiseProduct(g) + left_out;
    if (drives_[b].any())
      for (Index i = 0; i < y.size(); ++i)
        y[i] += carried(b, asked_[b].sums[i]).cast<Complex>().dot(s);
    return y;
  }

  // Change of the sum per unit translation of the whole body, by component. Rotation nodes do not
  // count.
  Vector3 carried(std::size_t b, const NodalSum& sum) const {
    const auto& rotations = modal_.built.instances[b].geometry->rotations;
    Vector3 whole = Vector3::Zero();
    for (const auto& [node, weight] : modal_.bodies[b].inner_terms(sum)) {
      const bool is_rotation = std::any_of(rotations.begin(), rotations.end(),
                                           [at = node](const auto& of) { return of.second == at; });
      if (!is_rotation) whole += weight;
    }
    return whole;
  }

  // Sum of x^k terms_k, by Horner's scheme
  template <class Term>
  static ComplexMatrix sum(const std::vector<Term>& terms, Complex x) {
    ComplexMatrix all = terms.back().template cast<Complex>();
    for (std::size_t k = terms.size() - 1; k-- > 0;)
      all = terms[k].template cast<Complex>() + x * all;
    return all;
  }

  ComplexMatrix statics(std::size_t b, double w) const {
    const ModalAnswer& of = asked_[b].answer;
    if (of.B.size() > 0) return springs(of, w);
    if (of.S.empty()) return ComplexMatrix::Zero(of.A.rows(), of.A.rows());
    return sum(of.S, asked_[b].square(w) - of.sigma) / asked_[b].stiffer(w);
  }

  // B (K + i w C)^-1 B^T, a column at a time.
  static ComplexMatrix springs(const ModalAnswer& of, double w) {
    const ComplexMatrix D = of.K.cast<Complex>() + Complex(0, w) * of.C.cast<Complex>();
    ComplexMatrix S(of.B.rows(), of.B.rows());
    for (Index i = 0; i < S.cols(); ++i)
      S.col(i) = of.B.cast<Complex>() * solve(D, of.B.row(i).transpose().cast<Complex>());
    return S;
  }

  void add_ties(std::size_t b, const ComplexVector& inverse, const ComplexVector& y, double w,
                ComplexMatrix& W, ComplexVector& apart) const {
    const std::vector<Index>& tie = asked_[b].tie;
    const auto m = static_cast<Index>(tie.size());
    if (m == 0) return;
    const ComplexMatrix A = asked_[b].answer.A.topRows(m).cast<Complex>();
    const ComplexMatrix of_body =
        A * inverse.asDiagonal() * A.transpose() + statics(b, w).topLeftCorner(m, m);
    for (Index i = 0; i < m; ++i) {
      apart[tie[i]] += y[i];
      for (Index j = 0; j < m; ++j) W(tie[i], tie[j]) += of_body(i, j);
    }
  }

  // Solves W x = b in real arithmetic. A row of zeros has no force.
  static ComplexVector solve(const ComplexMatrix& W, const ComplexVector& b) {
    const Index n = W.rows();
    ComplexVector x = ComplexVector::Zero(n);
    if (n == 0) return x;
    Vector more(2 * n);
    for (Index i = 0; i < n; ++i) {
      const double own = std::abs(W(i, i));
      more[i] = more[n + i] = own > 0 ? tie_slack * own : std::numeric_limits<double>::max();
    }
    Matrix real(2 * n, 2 * n);
    real << W.real(), -W.imag(), W.imag(), W.real();
    real.diagonal() += more;
    const Lu factor(std::move(real));
    for (int i = 0; i < tie_refinements; ++i) {
      const ComplexVector left = b - W * x;
      Vector right(2 * n);
      right << left.real(), left.imag();
      const Vector change = factor.solve(right);
      x.real() += change.head(n);
      x.imag() += change.tail(n);
    }
    return x;
  }

  void take_sets(std::size_t b, const ComplexVector& inverse, const ComplexVector& alone,
                 const ComplexVector& force, double w, ComplexVector& out) const {
    const Asked& of = asked_[b];
    const auto m = static_cast<Index>(of.tie.size()), n = static_cast<Index>(3 * of.set.size());
    if (n == 0) return;
    ComplexVector y = alone.tail(n);
    if (m > 0) {
      const ComplexVector p = force(of.tie);
      y += of.answer.A.bottomRows(n).cast<Complex>() *
           inverse.cwiseProduct(of.answer.A.topRows(m).transpose().cast<Complex>() * p);
      y += statics(b, w).bottomLeftCorner(n, m) * p;
    }
    for (std::size_t i = 0; i < of.set.size(); ++i)
      out.segment<3>(3 * static_cast<Index>(of.set[i])) = y.segment<3>(3 * static_cast<Index>(i));
  }

  const ModalScene& modal_;
  std::vector<Drive> drives_;
  std::vector<Asked> asked_;
  bool excites_ = false;
};

void refuse_open_contact(const Scene& scene) {
  for (const ContactOptions& contact : scene.contact)
    if (!contact.tied && preload_steps(scene) == 0)
      refuse(contact.source, "contact", feature::open_contact, feature::sweep);
  for (const LinkOptions& link : scene.links)
    if (link.motion != SupportMotion::none)
      refuse(link.source, "link '" + link.first.text() + "'", feature::driven_link, feature::sweep);
}

Vector frequencies(const SweepOptions& sweep) {
  Vector hz(sweep.points);
  for (Index i = 0; i < hz.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(hz.size() - 1);
    hz[i] = sweep.is_logarithmic ? sweep.from_hz * std::pow(sweep.to_hz / sweep.from_hz, share)
                                 : sweep.from_hz + share * (sweep.to_hz - sweep.from_hz);
  }
  return hz;
}

}  // namespace

HarmonicResponse harmonic_response(const Scene& scene_of_run, Report& report) {
  const Scene scene = with_options_of_files(scene_of_run);
  if (!scene.sweep)
    throw InputError(scene.file.string() +
                     ": --sweep needs sweep: {from_hz: F, to_hz: F} in the scene");
  if (scene.output.history.empty())
    throw InputError(scene.sweep->source.text() +
                     ": sweep: needs output.history: the sets whose motion is written");
  refuse_open_contact(scene);
  const MeshModesWanted wanted{scene.sweep->modes, modes_beyond * scene.sweep->to_hz,
                               has_ties(scene)};
  const std::unique_ptr<ModalScene> modal = modal_scene(scene, wanted, true, report);
  const auto phase = report.phase("sweep");
  const Sweep sweep(scene, *modal);
  if (!sweep.excites())
    throw InputError(scene.sweep->source.text() +
                     ": sweep: nothing excites the scene: give loads, or supports that move");
  HarmonicResponse response;
  response.frequency_hz = frequencies(*scene.sweep);
  for (const Monitor& monitor : modal->built.simulation.monitors)
    response.sets.push_back({monitor.name, ComplexMatrix(response.frequency_hz.size(), 3)});
  std::vector<std::string> names;
  for (const HarmonicResponse::OfSet& set : response.sets) names.push_back(set.name);
  refuse_equal_groups(names, "output.history: the sets");
  for (Index i = 0; i < response.frequency_hz.size(); ++i) {
    const ComplexVector u = sweep.at(2 * std::numbers::pi * response.frequency_hz[i]);
    for (std::size_t s = 0; s < response.sets.size(); ++s)
      response.sets[s].displacement.row(i) = u.segment<3>(3 * static_cast<Index>(s)).transpose();
    report.progress("sweeping",
                    static_cast<double>(i + 1) / static_cast<double>(response.frequency_hz.size()));
  }
  report.end_progress();
  return response;
}

}  // namespace cbr

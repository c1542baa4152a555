#include "formulations/variation/tangent_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/integrators/tolerance.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/penalty/penalty_variation.hpp"
#include "formulations/variation/differences.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/varied_run.hpp"
#include "mechanism/scene.hpp"
#include "simulation/contact_log.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Change of an approach rate in the differences of an impact law, relative.
constexpr double small_change = 1e-3;

/// ln|det A| as the sum of the logarithms of the lengths that orthogonalisation leaves; −∞ if a column
/// has collapsed into the span of those before it.
double log_volume(MatrixXd A) {
  double sum = 0;
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index i = 0; i < j; ++i) {
        const double part = A.col(i).dot(A.col(j));
        A.col(j) -= part * A.col(i);
      }
    const double length = A.col(j).norm();
    if (!(length > collapsed_share)) return -INFINITY;
    sum += std::log(length);
    A.col(j) /= length;
  }
  return sum;
}

}  // namespace

TangentRun::TangentRun(const Plan& plan)
    : scene_(plan.scene),
      system_(plan.system),
      own_(plan.scene, plan.system, plan.start),
      stop_(plan.stop),
      end_(plan.end) {}

bool TangentRun::step(double t_end) {
  if (stop_()) throw Interrupted();
  if (!advance(t_end)) return false;
  for (std::size_t c = 0; c < collapsed_.size(); ++c)
    if (collapsed_[c].empty() && !columns_->reason(c).empty()) {
      failure_ = columns_->reason(c);
      return false;
    }
  return true;
}

void TangentRun::vary(const std::vector<Vector>& vectors) {
  std::vector<VariedKey> keys;
  for (const auto& vector : vectors) keys.push_back({.name = "the state", .start = vector, .refused = {}});
  collapsed_.assign(vectors.size(), "");
  // Times over which the functions of drives are curved: see Scales::time.
  const double duration = std::min(end_ - t(), 100 * own_.time());
  columns_ = &begin_columns(keys, least_curved_length(system_), duration);
}

std::vector<double> TangentRun::orthonormalise() {
  const auto Z = directions();
  project(Z);
  auto& S = columns_->columns();
  const auto at = layout();
  const auto impulses = 2 * static_cast<long>(system_.n());
  // Impulses and works are sums of the motion and do not act on it.
  for (auto& column : S) {
    const auto first = column.begin();
    std::fill(first + impulses, first + impulses + 2 * static_cast<long>(system_.contacts()), 0.0);
    std::fill(first + at.integrals, first + at.end, 0.0);
  }
  return own_.orthonormalise(
      S, {Z, at.states, t(), collapsed_, [&](std::size_t j) { columns_->refuse(j, collapsed_[j]); }});
}

State TangentRun::now() const {
  const auto n = system_.n();
  const double *q = x().data(), *z = q + layout().states;
  return {t(), {q, q + n}, {q + n, q + 2 * n}, {z, z + system_.states()}};
}

double TangentRun::cost() const {
  const auto rhs = own_evaluations();
  return columns_ && rhs > 0 ? static_cast<double>(columns_->evaluations()) / static_cast<double>(rhs) : 0;
}

namespace {

class EventTangentRun final : public TangentRun {
 public:
  explicit EventTangentRun(const Plan& plan)
      : TangentRun(plan),
        restitution_(plan.restitution.empty() ? restitution_of(plan.system) : plan.restitution),
        scheme_(make_event_driven(
            plan.scene, plan.system, restitution_,
            {!redundant_rows(plan.system, plan.start.q).empty(), plan.scene.run.eliminate}, plan.start)),
        log_(plan.system.contacts(), plan.system.reported()),
        predict_(plan.predict),
        impact_error_(plan.impact_error) {
    dissipative_ = system_.has_velocity_forces() || system_.states() > 0 || system_.has_velocity_flows() ||
                   scheme_.dynamics().films.any();
    scheme_.start(plan.start, log_);
    probe_ = scheme_.dynamics().twin();
  }

  double t() const override { return scheme_.t(); }

  bool step(double t_end) override {
    const double begin = scheme_.t();
    if (!TangentRun::step(t_end)) return false;
    if (!columns_) return true;
    const double h = scheme_.t() - begin;
    if (!dissipative_ || !(h > 0) || !predicted_.unknown.empty()) return true;
    // Gauss's rule of three points; the mode of the step is still present.
    take_varied_mode(*probe_, scheme_.dynamics());
    const double off = std::sqrt(0.15) * h, middle = begin + 0.5 * h;
    double sum = 0;
    for (const auto& [t, weight] : {std::pair{middle - off, 5.0}, {middle, 8.0}, {middle + off, 5.0}})
      sum += weight * divergence(Vector(scheme_.x_at(t)), t);
    predicted_.flow += sum * h / 18;
    return true;
  }

 private:
  bool advance(double t_end) override {
    if (columns_) take_varied_mode(*probe_, scheme_.dynamics());
    if (!scheme_.step(t_end)) {
      failure_ = scheme_.failure();
      return false;
    }
    log_.advance(scheme_.t());
    log_.drain([](const auto&) {});
    return true;
  }

  DerivativeColumns& begin_columns(const std::vector<VariedKey>& keys, double length,
                                   double duration) override {
    scheme_.vary(keys, {}, length, duration);
    auto& variation = scheme_.variation();
    variation.trace(equations_, now());
    variation.impact_error = impact_error_;
    variation.on_event = [this](const EventDynamics& d, const Variation::Passed& p) { predict_event(d, p); };
    predicted_ = {};
    if (!predict_) leave_unknown("not requested");
    if (reduced(scheme_.dynamics())) leave_unknown("contacts last or joints stick, without own coordinates");
    variation.project_columns(scheme_.dynamics(), scheme_.x(), scheme_.t());
    return variation;
  }

  /// Whether the mode has fewer coordinates than the constraints leave.
  bool reduced(const EventDynamics& d) const {
    return std::ranges::any_of(d.contacts, [](const auto& c) { return c.closed; }) ||
           std::ranges::any_of(d.preloaded, [](const auto& p) { return p.slip == 0; });
  }

  /// The projection leaves u as it is where the mode has all own coordinates; the differences by which it is
  /// formed would change it by 1e-10, in each of many calls.
  void project(const MatrixXd& Z) override {
    const auto& d = scheme_.dynamics();
    auto& variation = scheme_.variation();
    if (reduced(d)) return variation.project_columns(d, x(), t());
    if (system_.rows() == 0) return;
    auto& S = variation.columns();
    std::vector<VectorXd> before;
    for (const auto& column : S) before.push_back(own_.of(Z, column, d.state_offset()));
    variation.project_columns(d, x(), t());
    const Eigen::Index n = system_.n(), f = Z.cols();
    for (std::size_t j = 0; j < S.size(); ++j) {
      const VectorXd change = before[j] - own_.of(Z, S[j], d.state_offset());
      const VectorXd dq = Z * change.head(f), dv = Z * change.segment(f, f) / own_.time();
      for (Eigen::Index i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(i);
        S[j][k] += dq[i] / std::sqrt(system_.mass()[k]);
        S[j][k + static_cast<std::size_t>(n)] += dv[i] / std::sqrt(system_.mass()[k]);
      }
    }
  }

  /// tr(Zᵀ ∂F/∂v Z) + tr(∂ż/∂z), by differences of the right-hand side along the own velocities: without
  /// tangent vectors, and without the dual numbers of their equations.
  double divergence(const Vector& x, double t) {
    const auto Z = own_.motions(x, t);
    const int n = system_.n();
    const double speed = curved_speed(*probe_, x);
    const double arm = system_.size();
    Vector centre(x.size());
    (*probe_)(x, centre, t);
    const auto slope = [&](double h, const Vector& along) {
      return difference(h, centre,
                        [&](std::size_t i) {
                          auto y = x;
                          for (std::size_t k = 0; k < y.size(); ++k)
                            y[k] += difference_places[i] * h * along[k];
                          Vector out(y.size());
                          (*probe_)(y, out, t);
                          return out;
                        })
          .slope;
    };
    double sum = 0;
    for (Eigen::Index j = 0; j < Z.cols(); ++j) {
      Vector along(x.size());
      double most = 0;
      for (int i = 0; i < n; ++i) {
        along[n + i] = Z(i, j) / std::sqrt(system_.mass()[i]);
        most = std::max(most, std::abs(along[n + i]) * (system_.is_angle(i) ? arm : 1));
      }
      const auto change = slope(small_change * speed / most, along);
      for (int i = 0; i < n; ++i) sum += Z(i, j) * std::sqrt(system_.mass()[i]) * change[n + i];
    }
    for (int k = 0; k < system_.states(); ++k) {
      const auto place = static_cast<std::size_t>(probe_->state_offset()) + static_cast<std::size_t>(k);
      Vector along(x.size());
      along[place] = 1;
      sum += slope(small_change * system_.state_scale(k), along)[place];
    }
    return sum;
  }

  /// The contribution of an event to the predicted growth. `probe_` has the mode before.
  void predict_event(const EventDynamics& d, const Variation::Passed& p) {
    std::vector<int> onsets;
    for (const int k : p.in_impact)
      if (!probe_->contacts[k].closed && p.impacts.rate(k) < -d.speed_tolerance()) onsets.push_back(k);
    onset_count_ += static_cast<long>(onsets.size());
    if (!predicted_.unknown.empty()) return;
    if (reduced(d))
      return leave_unknown(
          fmt::format("t = {:.9g} s: a contact lasts or a joint sticks; the volume of all own coordinates "
                      "vanishes",
                      p.t));
    if (!onsets.empty()) return predict_impact(d, p, onsets);
    if (p.event.kind != ModeEvent::Kind::slide_slip) return;
    // The sliding of a joint is reversed without sticking.
    const int k = p.event.index;
    const auto after = d.twin();
    take_varied_mode(*after, d);
    const auto acceleration = [&](EventDynamics& f, const Vector& x) {
      Vector rate(x.size());
      f(x, rate, p.t);
      const double h = 1e-6 * own_.time();
      const auto at = [&](double s) {
        auto y = x;
        for (std::size_t i = 0; i < y.size(); ++i) y[i] += s * rate[i];
        return f.slide_rate(k, y, p.t + s);
      };
      return (at(h) - at(-h)) / (2 * h);
    };
    predicted_.impacts += std::log(std::abs(acceleration(*after, p.after) / acceleration(*probe_, p.before)));
  }

  void predict_impact(const EventDynamics& d, const Variation::Passed& p, const std::vector<int>& onsets) {
    const int n = system_.n();
    const auto rate = [&](int k, const Vector& x) {
      return probe_->look(k, x, p.t).normal.dot(x.data() + n);
    };
    if (p.in_impact.size() == 1 && probe_->look(onsets[0], p.before, p.t).tangent.size == 0) {
      predicted_.impacts += 2 * std::log(restitution_[static_cast<std::size_t>(onsets[0])]);
      return;
    }
    double approach = INFINITY, sum = 0;
    for (const int k : onsets) {
      sum += std::log(std::abs(rate(k, p.after) / rate(k, p.before)));
      approach = std::min(approach, std::abs(rate(k, p.before)));
    }
    const auto Z = own_.motions(p.before, p.t);
    const auto after_impact = [&](const Vector& y) {
      auto z = y;
      if (!probe_->apply_impact(z, p.t, {p.in_impact, p.ended}).empty()) z.assign(z.size(), NAN);
      return Vector(z.begin() + n, z.begin() + 2 * n);
    };
    const auto centre = after_impact(p.before);
    MatrixXd map(Z.cols(), Z.cols());
    for (Eigen::Index j = 0; j < Z.cols(); ++j) {
      Vector along(p.before.size());
      for (int i = 0; i < n; ++i) along[n + i] = Z(i, j) / std::sqrt(system_.mass()[i]);
      double most = 0;
      for (const int k : p.in_impact) {
        const auto& row = probe_->look(k, p.before, p.t);
        most = std::max(
            {most, std::abs(row.normal.dot(along.data() + n)), std::abs(row.tangent.dot(along.data() + n))});
      }
      if (most == 0) most = 1;
      const double h = small_change * approach / most;
      const auto change = difference(h, centre, [&](std::size_t i) {
        auto y = p.before;
        for (int k = 0; k < n; ++k) y[n + k] += difference_places[i] * h * along[n + k];
        return after_impact(y);
      });
      VectorXd weighted(n);
      for (int i = 0; i < n; ++i) weighted[i] = std::sqrt(system_.mass()[i]) * change.slope[i];
      map.col(j) = Z.transpose() * weighted;
    }
    sum += log_volume(map);
    if (!std::isfinite(sum))
      leave_unknown(
          fmt::format("t = {:.9g} s: the impact without rebound or with sticking in contact {} "
                      "reduces the own coordinates",
                      p.t, d.system.contact_facts(onsets[0]).name));
    else
      predicted_.impacts += sum;
  }

  const Vector& x() const override { return scheme_.x(); }
  Layout layout() const override {
    const auto& d = scheme_.dynamics();
    return {d.state_offset(), d.integral_offset(), d.size()};
  }
  long own_evaluations() const override { return scheme_.work().rhs; }
  void leave_unknown(const std::string& reason) {
    if (predicted_.unknown.empty()) predicted_.unknown = reason;
  }

  std::vector<double> restitution_;
  EventDriven scheme_;
  ContactLog log_;
  std::unique_ptr<EventDynamics> probe_;  // in the mode of the last step
  bool predict_, dissipative_ = false;
  std::function<Variation::ImpactError(int)> impact_error_;
};

class PenaltyTangentRun final : public TangentRun {
 public:
  explicit PenaltyTangentRun(const Plan& plan)
      : TangentRun(plan), parts_(make_penalty_parts(plan.scene, plan.system, plan.start)) {
    predicted_.unknown = "the penalty formulation has no predicted sum";
  }
  double t() const override { return parts_.steps->t(); }
  bool may_vary() const override {
    return std::ranges::none_of(parts_.steps->dynamics().contacts(), [](const auto& c) { return c.closed; });
  }

 private:
  bool advance(double t_end) override {
    if (variation_) variation_->begin_step();
    if (!parts_.steps->step(t_end)) {
      failure_ = parts_.steps->failure();
      return false;
    }
    if (!variation_) return true;
    variation_->end_step();
    onset_count_ += static_cast<long>(variation_->onsets().size());
    variation_->forget_onsets();
    return true;
  }
  DerivativeColumns& begin_columns(const std::vector<VariedKey>& keys, double length,
                                   double duration) override {
    const auto start = now();
    variation_ = std::make_unique<PenaltyVariation>(parts_, scene_, start, keys, std::vector<Column>(),
                                                    length, duration);
    variation_->trace(equations_, start);
    variation_->forget_onsets();
    return *variation_;
  }
  const Vector& x() const override { return parts_.steps->x(); }
  Layout layout() const override {
    const auto& d = parts_.steps->dynamics();
    return {d.state_offset(), d.integral_offset(), d.size()};
  }
  long own_evaluations() const override { return parts_.steps->dynamics().work.rhs; }

  PenaltyParts parts_;
  std::unique_ptr<PenaltyVariation> variation_;
};

}  // namespace

std::unique_ptr<TangentRun> make_tangent_run(const TangentRun::Plan& plan, Family family) {
  if (family == Family::penalty) return std::make_unique<PenaltyTangentRun>(plan);
  return std::make_unique<EventTangentRun>(plan);
}

}  // namespace freeplay

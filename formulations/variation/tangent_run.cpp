#include "formulations/variation/tangent_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/system.hpp"
#include "formulations/variation/variational_run.hpp"

namespace freeplay {

using Eigen::MatrixXd, Eigen::VectorXd;

TangentRun::TangentRun(SensitivityRun run, Family family, Events events)
    : run_(std::move(run)), own_(run_.scene, run_.system, run_.start), events_(std::move(events)) {
  if (!run_.equations) run_.equations = &equations_;
  if (family == Family::penalty)
    motion_ = std::make_unique<VariationalRun<PenaltyScheme>>(run_);
  else
    motion_ = std::make_unique<VariationalRun<EventScheme>>(run_);
}

TangentRun::~TangentRun() = default;

template <class F>
auto TangentRun::with(F f) const {
  return std::visit([&](const auto& motion) { return f(motion->scheme()); }, motion_);
}

/// The event-driven stepper, or null.
const EventDriven* TangentRun::events() const {
  const auto* motion = std::get_if<0>(&motion_);
  return motion ? &(*motion)->scheme().stepper() : nullptr;
}

double TangentRun::t() const {
  return with([](auto& scheme) { return scheme.t(); });
}

const TangentRun::Vector& TangentRun::x() const {
  return *with([](auto& scheme) { return &scheme.vector(); });
}

TangentRun::Layout TangentRun::layout() const {
  return with([](auto& scheme) {
    return Layout{scheme.mode().state_offset(), scheme.mode().integral_offset(), scheme.mode().size()};
  });
}

State TangentRun::now() const {
  const auto n = run_.system.n();
  const double *q = x().data(), *z = q + layout().states;
  return {t(), {q, q + n}, {q + n, q + 2 * n}, {z, z + run_.system.states()}};
}

bool TangentRun::may_vary() const {
  return events() || std::ranges::none_of(std::get<1>(motion_)->scheme().mode().contacts(),
                                          [](const auto& c) { return c.closed; });
}

bool TangentRun::step(double t_end) {
  if (growth_) growth_->begin_step(events()->dynamics());
  const auto known = columns_ ? columns_->onsets().size() : 0;
  const bool stepped = std::visit([&](auto& motion) { return motion->step(t_end); }, motion_);
  if (columns_) onset_count_ += static_cast<long>(columns_->onsets().size() - known);
  if (!stepped) failure_ = std::visit([](auto& motion) { return motion->stopped(); }, motion_);
  for (std::size_t c = 0; stepped && c < collapsed_.size(); ++c)
    if (failure_.empty() && collapsed_[c].empty()) failure_ = columns_->reason(c);
  if (!failure_.empty()) return false;
  if (growth_) growth_->end_step(*events());
  return true;
}

void TangentRun::vary(const std::vector<Vector>& vectors) {
  std::vector<VariedKey> keys;
  for (const auto& vector : vectors) keys.push_back({.name = "the state", .start = vector, .refused = {}});
  collapsed_.assign(vectors.size(), "");
  // Times over which the functions of drives are curved: see Scales::time.
  const double duration = std::min(run_.end - t(), 100 * own_.time());
  std::visit([&](auto& motion) { motion->vary(keys, {}, duration, now()); }, motion_);
  columns_ = with([](auto& scheme) -> DerivativeColumns* { return &scheme.variation(); });
  columns_->forget_onsets();
  if (!events()) return;
  auto& variation = std::get<0>(motion_)->variation();
  variation.impact_error = events_.impact_error;
  if (events_.predict) {
    growth_.emplace(own_, restitution_of(run_), *events(),
                    run_.equations->of(run_.system, keys, now(), SystemTangent::Use::modes));
    variation.on_event = [this](const EventDynamics& d, const Variation::ProcessedEvent& p) {
      growth_->cross_event(d, p);
    };
  }
  variation.project_columns(events()->dynamics(), x(), t());
}

std::vector<double> TangentRun::orthonormalise() {
  const auto Z = directions();
  if (events()) project(Z);
  auto& S = columns_->columns();
  const auto at = layout();
  const auto impulses = 2 * static_cast<long>(run_.system.n());
  // Impulses and works are sums of the motion and do not act on it.
  for (auto& column : S) {
    const auto first = column.begin();
    std::fill(first + impulses, first + impulses + 2 * static_cast<long>(run_.system.contacts()), 0.0);
    std::fill(first + at.integrals, first + at.end, 0.0);
  }
  return own_.orthonormalise(
      S, {Z, at.states, t(), collapsed_, [&](std::size_t j) { columns_->refuse(j, collapsed_[j]); }});
}

/// The projection leaves u as it is where the mode has all own coordinates; the differences by which it is
/// formed would change it by 1e-10, in each of many calls.
void TangentRun::project(const MatrixXd& Z) {
  const auto& d = events()->dynamics();
  const auto& system = run_.system;
  auto& variation = std::get<0>(motion_)->variation();
  if (reduces_coordinates(d)) return variation.project_columns(d, x(), t());
  if (system.rows() == 0) return;
  auto& S = variation.columns();
  std::vector<VectorXd> before;
  for (const auto& column : S) before.push_back(own_.of(Z, column, d.state_offset()));
  variation.project_columns(d, x(), t());
  const Eigen::Index n = system.n(), f = Z.cols();
  for (std::size_t j = 0; j < S.size(); ++j) {
    const VectorXd change = before[j] - own_.of(Z, S[j], d.state_offset());
    const VectorXd dq = Z * change.head(f), dv = Z * change.segment(f, f) / own_.time();
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      S[j][k] += dq[i] / std::sqrt(system.mass()[k]);
      S[j][k + static_cast<std::size_t>(n)] += dv[i] / std::sqrt(system.mass()[k]);
    }
  }
}

PredictedGrowth::Logs TangentRun::predicted() const {
  if (growth_) return growth_->logs();
  return {.unknown = events() ? "not requested" : "the penalty formulation has no predicted sum"};
}

double TangentRun::cost() const {
  return std::visit([](auto& motion) { return motion->cost(); }, motion_);
}

long TangentRun::evaluations() const {
  return with([](auto& scheme) { return scheme.evaluations(); }) + (columns_ ? columns_->evaluations() : 0);
}

}  // namespace freeplay

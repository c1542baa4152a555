#include "formulations/penalty/penalty_tangent_run.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/system.hpp"
#include "formulations/sensitivity.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

PenaltyTangentRun::PenaltyTangentRun(const TangentRun::Plan& plan)
    : scene_(plan.scene),
      system_(plan.system),
      stop_(plan.stop),
      end_(plan.end),
      parts_(make_penalty_parts(plan.scene, plan.system, plan.start)),
      own_(plan.scene, plan.system, plan.start) {
  predicted_.unknown = "the penalty formulation has no predicted sum";
}

bool PenaltyTangentRun::step(double t_end) {
  if (stop_()) throw Interrupted();
  if (variation_) variation_->begin_step();
  if (!parts_.steps->step(t_end)) {
    failure_ = parts_.steps->failure();
    return false;
  }
  if (!variation_) return true;
  variation_->end_step();
  onset_count_ += static_cast<long>(variation_->onsets().size());
  variation_->forget_onsets();
  for (std::size_t c = 0; c < collapsed_.size(); ++c)
    if (collapsed_[c].empty() && !variation_->reason(c).empty()) {
      failure_ = variation_->reason(c);
      return false;
    }
  return true;
}

bool PenaltyTangentRun::may_vary() const {
  return std::ranges::none_of(parts_.steps->dynamics().contacts(), [](const auto& c) { return c.closed; });
}

std::vector<PenaltyTangentRun::Vector> PenaltyTangentRun::full() const {
  const auto& steps = *parts_.steps;
  return own_.basis(own_.motions(steps.x(), steps.t()));
}

void PenaltyTangentRun::vary(const std::vector<Vector>& vectors) {
  std::vector<VariedKey> keys;
  for (const auto& vector : vectors) keys.push_back({.name = "the state", .start = vector, .refused = {}});
  const auto& steps = *parts_.steps;
  const auto& x = steps.x();
  const auto n = static_cast<long>(system_.n());
  const State now{steps.t(), {x.begin(), x.begin() + n}, {x.begin() + n, x.begin() + 2 * n}, {}};
  // Times over which the functions of drives are curved: see Scales::time.
  const double duration = std::min(end_ - steps.t(), 100 * own_.time());
  variation_ = std::make_unique<PenaltyVariation>(parts_, scene_, now, keys, std::vector<Column>(),
                                                  least_curved_length(system_), duration);
  variation_->forget_onsets();
  collapsed_.assign(vectors.size(), "");
}

std::vector<double> PenaltyTangentRun::orthonormalise() {
  const auto& steps = *parts_.steps;
  const auto& d = steps.dynamics();
  auto& S = variation_->columns();
  // Impulses and works are sums of the motion and do not act on it.
  for (auto& column : S) {
    std::fill(column.begin() + d.impulse_offset(),
              column.begin() + d.impulse_offset() + 2 * static_cast<long>(d.contacts().size()), 0.0);
    std::fill(column.begin() + d.integral_offset(), column.begin() + d.size(), 0.0);
  }
  return own_.orthonormalise(S, {own_.motions(steps.x(), steps.t()), d.state_offset(), steps.t(), collapsed_,
                                 [&](std::size_t j) { variation_->end_column(j, collapsed_[j]); }});
}

double PenaltyTangentRun::cost() const {
  const auto rhs = parts_.steps->dynamics().work.rhs;
  return variation_ && rhs > 0 ? static_cast<double>(variation_->evaluations()) / static_cast<double>(rhs)
                               : 0;
}

}  // namespace freeplay

#include "formulations/time_stepping/step_forces.hpp"

#include <algorithm>

namespace freeplay {

void StepForces::watch(const System& system, bool on) {
  watching_ = on;
  if (!on || !smooth_.elements.empty()) return;
  nothing_ = smooth_ = within_ = system.make_forces();
  struck_lambda_.resize(system.rows());
  smooth_lambda_.resize(system.rows());
}

void StepForces::collect(StepData& s, const ContactSet& contacts, const StepProblem& problem,
                         ImpulseResponses& responses, const FilmStep& films) {
  const auto& system = s.system;
  const int n = system.n(), m = system.rows();
  const double h = s.length(), *q = s.q_mid.data();
  const bool many = responses.many();
  bool any_struck = false;
  smooth_.clear();
  within_.clear();
  std::ranges::fill(struck_lambda_, 0.0);
  if (many) std::ranges::fill(s.force, 0.0);
  const auto take = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    const int place = problem.place(row);
    responses.push(place, impulse, within_.acceleration.data());
    if (many) {
      responses.row(place).add_to(s.force.data(), impulse);
      return;
    }
    if (problem.late_multipliers())
      s.saddle.finish(responses.row(row), responses.response(row), responses.reaction(row));
    for (int k = 0; k < m; ++k) struck_lambda_[k] += impulse * responses.reaction(row)[k];
  };
  for (const int k : contacts.live()) {
    const auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    if (!u) continue;
    const bool in_impact = c.steps == 1 && u->impulse_n > 0;
    any_struck |= in_impact;
    if (in_impact) {
      take(u->normal, u->impulse_n);
      take(u->tangent, u->impulse_t);
    }
    auto& out = in_impact ? within_ : smooth_;
    if (contacts.has_slot(k))
      system.report_contact(contacts.told_as(k), System::link_of(contacts.shape(k)), q, s.middle, c.row,
                            u->impulse_n, u->impulse_t, 1, out);
    else
      system.report_contact(k, q, s.middle, c.row, u->impulse_n, u->impulse_t, 1, out);
  }
  if (many && any_struck) s.saddle.solve(s.force.data(), nullptr, s.dq.data(), struck_lambda_.data());
  if (films.any()) films.report(system, q, s.middle, within_.acceleration.data(), smooth_, within_);
  for (int k = 0; k < m; ++k) smooth_lambda_[k] = s.lambda[k] - struck_lambda_[k];
  system.report_rows(q, s.middle, smooth_lambda_.data(), 1, smooth_);
  system.report_rows(q, s.middle, struck_lambda_.data(), 1, within_);
  for (int i = 0; i < n; ++i) {
    smooth_.acceleration[i] = s.v[i] - s.v_old[i] - within_.acceleration[i];
    s.v_mean[i] = 0.5 * (s.v_old[i] + s.v[i]);
  }
  for (std::size_t k = 0; k < problem.slides.size(); ++k)
    system.report_friction(static_cast<int>(k), q, s.v_mean.data(), s.middle, problem.slides[k],
                           problem.friction(static_cast<int>(k)).impulse_t, 1, smooth_);
  const Sweep sweep{h, s.v_old.data(), s.v_mean.data()};
  system.report_loads(s.t_old + 0.5 * h, q, s.v_mean.data(), s.z_mid.data(), s.middle, h, smooth_, {&sweep});
}

}  // namespace freeplay

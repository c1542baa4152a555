#include "formulations/time_stepping/step_modes.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

void list_modes(const ContactSet& contacts, const StepProblem& problem, std::vector<signed char>& list) {
  list.clear();
  const auto way = [](double impulse, double bound) {
    return static_cast<signed char>(std::abs(impulse) < bound * (1 - 1e-9) ? 1 : impulse < 0 ? 2 : 3);
  };
  for (const auto& c : contacts.all()) {
    const auto* u = problem.unknown_of(c);
    const bool rough = u && u->tangent >= 0;
    list.push_back(!u || !(u->impulse_n > 0) ? 0 : rough ? way(u->impulse_t, u->friction * u->impulse_n) : 1);
  }
  for (std::size_t k = 0; k < problem.slides.size(); ++k) {
    const auto& u = problem.friction(static_cast<int>(k));
    list.push_back(way(u.impulse_t, u.bound));
  }
}

double turned_round(const StepData& step, const ContactSet& contacts, const StepProblem& problem) {
  double rate = 0;
  const auto take = [&](const SparseRow& row, const ContactUnknown& u, double bound) {
    const double before = row.dot(step.v_old.data());
    if (bound <= 0 || before == 0) return;
    if (std::abs(u.impulse_t) >= bound * (1 - 1e-9)) {
      if (before * u.impulse_t > 0)
        rate = std::max(rate, std::abs(before));  // friction that drives the sliding
      return;
    }
    // with little normal force, it slides on
    if (std::abs(problem.rate(u.tangent)) > 1e-3 * std::abs(before)) return;
    // Sliding was stopped. The impulse that then holds the contact, which is the total less the
    // impulse that stopped it, may exceed the friction limit.
    const double d = problem.D(u.tangent, u.tangent), held = std::abs(u.impulse_t + before / d);
    if (held > bound) rate = std::max(rate, (held - bound) * d);
  };
  for (const auto& c : contacts.all())
    if (const auto* u = problem.unknown_of(c); u && c.row.tangent.size > 0)
      take(c.row.tangent, *u, u->friction * u->impulse_n);
  for (std::size_t k = 0; k < problem.slides.size(); ++k) {
    const auto& u = problem.friction(static_cast<int>(k));
    take(problem.slides[k], u, u.bound);
  }
  return rate;
}

double lifted(const ContactSet& contacts, const StepProblem& problem, const std::vector<double>& first) {
  double rate = 0;
  for (std::size_t k = 0; k < contacts.all().size(); ++k) {
    const auto& c = contacts.all()[k];
    const auto* u = problem.unknown_of(c);
    if (!c.closed || !u) continue;
    // Forces at a quarter and three quarters of the two half steps, as impulses over both.
    const double early = 2 * first[k], late = 2 * u->impulse_n, slope = 2 * (late - early);
    const double least = std::min(early, late) - 0.25 * std::abs(slope);
    if (!(early > 0) || !(late > 0) || !(least < 0)) continue;
    rate = std::max(rate, 0.5 * least * least / std::abs(slope) * problem.D(u->normal, u->normal));
  }
  return rate;
}

}  // namespace freeplay

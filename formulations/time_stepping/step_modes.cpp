#include "formulations/time_stepping/step_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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

void list_pulls(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                std::vector<Pull>& list) {
  list.clear();
  for (const auto& c : contacts.all()) {
    auto& pull = list.emplace_back();
    if (!c.closed || c.row.normal.size == 0) continue;
    const auto* u = problem.unknown_of(c);
    pull.pressed = u && u->impulse_n > 0;
    pull.rate = pull.pressed ? -u->impulse_n * problem.D(u->normal, u->normal)
                             : c.row.normal.dot(step.v.data()) - c.row.normal.dot(step.v_old.data()) -
                                   step.length() * c.row.gamma_n;
  }
}

Misjudged misjudged(const std::vector<Pull>& whole, const std::vector<Pull>& first,
                    const std::vector<Pull>& second) {
  Misjudged found;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    // Pulls at a quarter, a half and three quarters of the step, as rates over its whole length, and
    // the parabola middle + slope x + bend x² through them, x from −½ to ½.
    const double early = 2 * first[k].rate, middle = whole[k].rate, late = 2 * second[k].rate;
    const double slope = 2 * (late - early), bend = 8 * (early - 2 * middle + late);
    const double root = slope * slope - 4 * bend * middle;
    if (!(root > 0)) continue;
    // Its zeros, in order, without cancellation.
    const double q = -0.5 * (slope + std::copysign(std::sqrt(root), slope));
    std::array<double, 2> zeros{bend != 0 ? q / bend : INFINITY, q != 0 ? middle / q : INFINITY};
    if (zeros[0] > zeros[1]) std::swap(zeros[0], zeros[1]);
    const auto total = [&](double x) { return x * (middle + x * (slope / 2 + x * bend / 3)); };
    const auto missed = [&](const Pull& pull, double from, double to) {
      double rate = 0;
      for (const double end : {std::clamp(zeros[0], from, to), std::clamp(zeros[1], from, to), to}) {
        const double gained = total(end) - total(from);
        rate += std::max(pull.pressed ? gained : -gained, 0.0);
        from = end;
      }
      // Pulls of one sign are as they were taken; rounding may place a zero at an end.
      found.rate = std::max(found.rate, rate);
    };
    missed(first[k], -0.5, 0);
    missed(second[k], 0, 0.5);
    for (const double x : zeros)
      if (std::abs(x) < 0.5 && slope + 2 * bend * x > 0)
        found.separation = std::min(found.separation, x + 0.5);
  }
  return found;
}

}  // namespace freeplay

// Periodic motions of time stepping and of the automatic scheme, and a motion that is periodic up to a shift.
#include "analysis/orbit.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/references/published/woodpecker.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

const reference::ShakenBall table_ball{0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L};
const char* const table_ball_name = "ball on a table that moves by 3.2 mm at 10 Hz";
const char* const order_reason =
    "first order; root mean squares of eight steps, whose errors have random phases, "
    "are known to a quarter each";
const char* const closed_form = "flight and impact in closed form";

Orbit ball_by(const std::vector<std::string>& options) {
  auto text = scenes::shaken_ball(table_ball, 1e-3L);
  text.resize(text.find("[nonsmooth]"));
  return orbit(parse_scene(text, "ball", options), {.settle = 1});
}

/// Half the sum of both multipliers; NaN without a motion.
double mean_multiplier(const Orbit& found) {
  if (!found.failure.empty() || found.multipliers.size() < 2) return NAN;
  return 0.5 * (found.multipliers[0] + found.multipliers[1]).real();
}

/// Order of an error between two groups of steps around h and a tenth of it. The phase of the impact within
/// its step scatters single errors; `errors_at` has several quantities.
template <std::size_t N, class ErrorsAt>
std::array<double, N> order_between(double h, ErrorsAt errors_at) {
  constexpr int in_group = 8;
  std::array<double, N> sums{}, fine{}, order{};
  for (int i = 0; i < in_group; ++i) {
    const double part = 1 + 0.1 * i;
    const auto coarse_errors = errors_at(h * part), fine_errors = errors_at(0.1 * h * part);
    for (std::size_t k = 0; k < N; ++k) {
      sums[k] += coarse_errors[k] * coarse_errors[k];
      fine[k] += fine_errors[k] * fine_errors[k];
    }
  }
  for (std::size_t k = 0; k < N; ++k) order[k] = 0.5 * std::log10(sums[k] / fine[k]);
  return order;
}

void stepped_balls(Findings& f) {
  const double speed = static_cast<double>(table_ball.approach()),
               mean = static_cast<double>(table_ball.trace()) / 2;
  const auto order = order_between<2>(2e-3, [&](double h) {
    const auto found = ball_by({fmt::format("nonsmooth.step={}", h)});
    const bool once = found.failure.empty() && found.impacts.size() == 1;
    return std::array{once ? found.impacts[0].speed - speed : NAN, mean_multiplier(found) - mean};
  });
  const char* const quantities[] = {"approach speed", "mean of the multipliers"};
  for (std::size_t i = 0; i < 2; ++i)
    f.within(
        claim_name(table_ball_name, fmt::format("order in the step of the error of the {}", quantities[i]),
                   "Moreau–Jean"),
        "", order[i], 1, 0.3, closed_form,
        "first order; root mean squares of eight steps, whose errors have random phases, are known to a "
        "quarter each");
  const auto adaptive = ball_by({"nonsmooth.scheme=moreau-jean"});
  const bool once = adaptive.failure.empty() && adaptive.impacts.size() == 1;
  f.relative(claim_name(table_ball_name, "approach speed", "adaptive Moreau–Jean"), "m/s",
             once ? adaptive.impacts[0].speed : NAN, speed, 1e-5, closed_form,
             "ten times the tolerance of the steps");
  f.within(claim_name(table_ball_name, "mean of the multipliers", "adaptive Moreau–Jean"), "",
           mean_multiplier(adaptive), mean, 1e-5, closed_form, "ten times the tolerance of the steps");
  const auto automatic = ball_by({}), events = ball_by({"nonsmooth.scheme=event-driven"});
  f.within(claim_name(table_ball_name, "mean of the multipliers less that of event-driven", "automatic"), "",
           mean_multiplier(automatic) - mean_multiplier(events), 0, 0, "definition",
           "without a change of the scheme, the same digits");
}

void stepped_oscillator(Findings& f) {
  const reference::ImpactOscillator oscillator{0.5L, 1, 200, 3, 22, 0.005L, 0.7L};
  long double impact = 0;
  auto text = scenes::impact_oscillator(oscillator, impact);
  text.resize(text.find("[nonsmooth]"));
  const double speed = static_cast<double>(oscillator.motion().v_minus),
               mean = static_cast<double>(oscillator.trace()) / 2;
  const auto order = order_between<2>(1e-3, [&](double h) {
    const auto found =
        orbit(parse_scene(text, "oscillator", {fmt::format("nonsmooth.step={}", h)}), {.settle = 0});
    const bool once = found.failure.empty() && found.impacts.size() == 1;
    return std::array{once ? found.impacts[0].speed - speed : NAN, mean_multiplier(found) - mean};
  });
  const char* const quantities[] = {"approach speed", "mean of the multipliers"};
  for (std::size_t k = 0; k < order.size(); ++k)
    f.within(
        claim_name("oscillator with a stop at 5 mm, force of 22 rad/s",
                   fmt::format("order in the step of the error of the {}", quantities[k]), "Moreau–Jean"),
        "", order[k], 1, 0.3, "linear oscillation with two matching conditions", order_reason);
}

/// Limit cycle of the reference: period, fall and multiplier of the one-dimensional map, from the intervals
/// d between pecks: T∞ by Aitken's extrapolation, multiplier d_k+1/d_k.
struct PeckCycle {
  double period, fall, multiplier;
};
PeckCycle cycle_of(const reference::Woodpecker& toy, std::size_t count, std::size_t at) {
  auto motion = reference::woodpecker(toy);
  std::vector<reference::Long> pecks;
  while (pecks.size() < count) {
    motion.run(motion.t + 0.05L);
    pecks.clear();
    for (const auto& e : motion.impacts)
      if (e.contact == 0) pecks.push_back(e.t);
  }
  const auto interval = [&](std::size_t k) { return pecks[k + 1] - pecks[k]; };
  const auto change = [&](std::size_t k) { return interval(k + 1) - interval(k); };
  const std::size_t last = count - 4;
  const auto period =
      interval(last + 2) - change(last + 1) * change(last + 1) / (change(last + 1) - change(last));
  const auto height = motion.q[0];
  motion.run(motion.t + period);
  return {static_cast<double>(period), static_cast<double>(height - motion.q[0]),
          static_cast<double>(change(at + 1) / change(at))};
}

void pecking_motions(Findings& f) {
  const char* const independent = "three coordinates in long double, contact laws by enumeration";
  const auto claims = [&](const std::string& subject, const Orbit& found, const PeckCycle& cycle,
                          double period, double fall, double multiplier, const char* period_reason,
                          const char* multiplier_reason) {
    const bool known = found.failure.empty() && found.multipliers.size() == 5;
    const auto name = [&](const char* what) { return claim_name(subject, what, "event-driven"); };
    f.within(name("period"), "s", known ? found.period : NAN, cycle.period, period, independent,
             period_reason);
    f.relative(name("fall per peck"), "m", known ? -found.shift : NAN, cycle.fall, fall, independent,
               period_reason);
    f.within(name("multiplier of a shift in time"), "", known ? found.multipliers[0].real() : NAN, 1, 1e-6,
             "definition", "tolerance of the integration over the rate of the motion");
    f.within(name("multiplier of the one-dimensional map"), "", known ? found.multipliers[1].real() : NAN,
             cycle.multiplier, multiplier, independent, multiplier_reason);
    f.at_most(
        name("greatest modulus of the other three multipliers"), "",
        known ? std::abs(found.multipliers[2]) : NAN, 1e-6,
        "sticking leaves one free number of the state (Leine, Glocker and van Campen, DETC2001/VIB-21608)",
        "rounding of the projections");
  };
  claims("woodpecker toy",
         orbit(read_scene(test::published("woodpecker")), {.settle = 8.7, .period = 0.13, .shift = {"y"}}),
         cycle_of({}, 11, 5), 1e-11, 1e-9, 1e-6, "tolerance 1e-12 per step, some thousand steps",
         "second-order terms of the intervals, 1e-9 s, over rounding of events of 1e-18 s");
  const reference::Woodpecker straight{.stretch = 1e-3L};
  claims("woodpecker toy, small angles",
         orbit(parse_scene(scenes::stretched_woodpecker(straight), "toy"),
               {.settle = 8.7, .period = 0.146, .shift = {"y"}}),
         cycle_of(straight, 16, 12), 1e-6, 2e-3, 1e-2,
         "the last intervals of the reference differ by 1e-5 s and falls by 1e-5 m; "
         "Aitken's extrapolation of the "
         "period leaves terms of second order",
         "the intervals still differ by 1e-4 of the period");
}

}  // namespace

void orbits_of_schemes(Findings& f) {
  stepped_balls(f);
  stepped_oscillator(f);
  pecking_motions(f);
}

}  // namespace freeplay::verification

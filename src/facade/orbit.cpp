// Newton's method on the return map (facade/return_map.hpp).
#include "facade/orbit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "dynamics/system.hpp"
#include "facade/excitation.hpp"
#include "facade/identify.hpp"
#include "facade/return_map.hpp"
#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

constexpr int most_iterations = 40;
/// A motion is accepted as periodic if its residual is at most this times nonsmooth.tolerance: the
/// errors of the steps of some periods.
constexpr double accepted_errors = 1e3;
/// Newton steps are shortened at most to this share.
constexpr double least_share = 1e-3;
/// Directions in which the residual changes less than this, relative, are neutral: the mechanism has a
/// family of periodic motions along them.
constexpr double neutral = 1e-9;
/// A motion without a drive that would change the state by less than this in a period, in error scales
/// of unit tolerance, is an equilibrium.
constexpr double at_rest = 1e-3;

/// The Newton step: local coordinates, then the relative change of the period if that is unknown. Of
/// several solutions, it is the shortest one, so that neutral directions are not followed.
VectorXd newton_step(const ReturnPoint& p) {
  MatrixXd A(p.map.rows(), p.map.cols() + (p.flow.size() > 0 ? 1 : 0));
  A.leftCols(p.map.cols()) = p.map - MatrixXd::Identity(p.map.rows(), p.map.cols());
  if (p.flow.size() > 0) A.rightCols(1) = p.flow;
  return MinimumNorm(A, neutral).solve(-p.residual);
}

/// A shortened Newton step that reduces the residual. Returns false and the reason if there is none.
bool advance(ReturnMap& map, ReturnPoint& p, std::string& reason) {
  const auto step = newton_step(p);
  const double length = map.length();
  for (double share = 1; share >= least_share; share *= 0.5) {
    State s = p.state;
    if (map.autonomous()) {
      const double ratio = 1 + share * step[step.size() - 1];
      if (!(ratio > 0.5 && ratio < 2)) continue;
      map.set_length(length * ratio);
    }
    reason = map.move(share * step.head(map.size()), s);
    if (!reason.empty()) continue;
    map.chart(s);
    auto next = map.at(s);
    if (next.failure.empty() && next.greatest < p.greatest) {
      p = std::move(next);
      return true;
    }
    reason = next.failure;
    map.chart(p.state);
  }
  map.set_length(length);
  return false;
}

/// Whether removed whole turns of bodies have wound up a spring.
bool wound(const System& system, const ReturnPoint& p) {
  const double before = system.potential(p.state.q.data());
  double size = std::max({std::abs(before), std::abs(p.end.potential), p.end.kinetic});
  bool turned = false;
  for (int i = 2; i < system.n(); i += 3)
    turned |= std::abs(p.end.state.q[static_cast<std::size_t>(i)] - p.state.q[static_cast<std::size_t>(i)]) >
              std::numbers::pi;
  return turned && std::abs(p.end.potential - before) > 1e-6 * size;
}

bool is_equilibrium(const ReturnPoint& p) {
  const auto& rate = p.end.columns.back();
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (std::abs(rate[i]) > at_rest * p.end.scales[i]) return false;
  return true;
}

}  // namespace

Orbit orbit(const Scene& scene, const OrbitRequest& request) {
  const auto family = family_of(request.formulation);
  if (family == Family::nonsmooth && scene.nonsmooth.scheme_in_force() == Scheme::moreau_jean)
    throw ModelError(
        "nonsmooth.scheme",
        "orbits of time stepping are not available; set it to \"event-driven\" or \"automatic\"");
  if (request.periods < 1) throw ModelError("periods", "must be 1 or greater");
  if (!(request.settle >= 0) || !std::isfinite(request.settle))
    throw ModelError("settle", "must be 0 or greater");
  Simulation simulation(scene, request.formulation, {.start = {}, .stop = request.stop});
  const auto& given = simulation.scene();
  const System system(given.mechanism);
  const auto excitation = excitation_of(given.mechanism, system);
  Orbit found;
  found.periods = request.periods;
  found.period = section_period(excitation, request.period);
  const bool autonomous = !excitation.any;
  if (request.settle > 0) {
    const auto result = simulation.run({.until = simulation.t() + request.settle * found.period,
                                        .keep_events = false,
                                        .stop = request.stop});
    if (result.ending.status == Ending::Status::interrupted) throw Interrupted();
    if (result.ending.status != Ending::Status::finished) {
      found.failure = fmt::format("the run before the section stopped: {}", result.ending.reason);
      return found;
    }
  }
  ReturnMap map(given, system, found.period * request.periods, autonomous, request.stop, family);
  auto start = simulation.state();
  map.take_closed(start);
  map.chart(start);
  if (const auto why = map.move(VectorXd::Zero(map.size()), start); !why.empty()) {
    found.failure = fmt::format("t = {:.9g} s, at the section: {}", start.t, why);
    return found;
  }
  if (map.size() == 0 && map.closed().empty())
    throw ModelError("",
                     "the drives determine the motion of all bodies: it has no degrees of freedom whose "
                     "stability could be computed");
  auto p = map.at(start);
  int steps = fewest_map_steps;
  if (!p.end.refused.empty() && p.end.stopped.empty())
    p.failure += "; a fraction of a period in settle moves the section";
  const double accepted =
      accepted_errors * (family == Family::penalty ? given.penalty.tolerance : given.nonsmooth.tolerance);
  std::string reason = p.failure;
  while (map.size() > 0 && p.failure.empty() && found.iterations < most_iterations) {
    const double before = p.greatest;
    if (before == 0 || !advance(map, p, reason)) break;
    ++found.iterations;
    if (p.greatest <= accepted && p.greatest > 0.5 * before) break;
  }
  found.state = p.state;
  if (p.failure.empty()) found.residual = p.greatest;
  if (!(found.residual <= accepted)) {
    found.failure =
        p.failure.empty()
            ? fmt::format("Newton's method ends at a residual of {:.3g} after {} steps{}", found.residual,
                          found.iterations,
                          found.iterations == most_iterations ? std::string()
                          : reason.empty() ? std::string(": no shorter step reduces it; try another number "
                                                         "of periods, or more periods to settle")
                                           : ": " + reason)
            : p.failure;
    return found;
  }
  if (autonomous) found.period = map.length() / request.periods;
  if (autonomous && is_equilibrium(p))
    found.failure = "the state found is an equilibrium; start with more motion, or give another period";
  else if (wound(system, p))
    found.failure = "bodies advance by whole turns against a torsional spring: the motion is not periodic";
  else
    found.failure = refine(map, p, steps);
  if (!found.failure.empty()) return found;
  found.residual = p.greatest;
  for (const auto& onset : p.end.onsets)
    found.impacts.push_back({onset.t, system.contact_facts(onset.contact).name, -onset.rate});
  for (const auto& contact : p.end.lasting)
    found.lasting.push_back({system.contact_facts(contact.contact).name, contact.least, contact.t});
  auto multipliers = multipliers_of(p, autonomous);
  found.multipliers = std::move(multipliers.values);
  found.stable = multipliers.stable;
  return found;
}

}  // namespace freeplay

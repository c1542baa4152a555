// Newton's method on the return map (analysis/return_map.hpp).
#include "analysis/orbit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "analysis/orbit_shooting.hpp"
#include "analysis/periodicity.hpp"
#include "analysis/return_map.hpp"
#include "dynamics/sampling.hpp"
#include "dynamics/system.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "formulations/variation/end_state.hpp"
#include "mechanism/duration.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Where time stepping made steps, the return map has jumps as great as their errors. A motion is accepted
/// up to this multiple of the change of its end under the finer steps below.
constexpr double accepted_changes = 2;
constexpr std::array finer_steps{0.5, 0.25};
/// If the search fails, the section is moved at most this number of times away
/// from a contact onset that comes nearer to it than this share of the motion.
constexpr int most_moves = 2;
constexpr double near_section = 0.05;
/// A motion without a drive that would change the state by less than this in a period, in error scales
/// of unit tolerance, is an equilibrium.
constexpr double at_rest = 1e-3;

/// The Newton step: local coordinates, then the relative change of the period if that is unknown. The state
/// then moves orthogonally to the flow, so that only the period changes the phase. Of several solutions, it
/// is the shortest one, so that neutral directions are not followed.
VectorXd newton_step(const ReturnPoint& p) {
  const auto size = p.map.cols(), extra = static_cast<Eigen::Index>(p.flow.size() > 0 ? 1 : 0);
  MatrixXd A = MatrixXd::Zero(size + extra, size + extra);
  VectorXd change = VectorXd::Zero(size + extra);
  A.topLeftCorner(size, size) = p.map - MatrixXd::Identity(size, size);
  change.head(size) = -p.residual;
  const double unit = extra > 0 && p.flow.norm() > 0 ? p.flow.norm() : 1;
  if (extra > 0) {
    A.topRightCorner(size, 1) = p.flow / unit;
    A.bottomLeftCorner(1, size) = p.flow.transpose() / unit;
  }
  VectorXd step = MinimumNorm(A, neutral_direction).solve(change);
  if (extra > 0) step[size] /= unit;
  return step;
}

/// A shortened Newton step that reduces the residual. Returns false and the reason if there is none.
bool advance(ReturnMap& map, ReturnPoint& p, std::string& reason) {
  const auto step = newton_step(p);
  const double length = map.length();
  for (double share = 1; share >= least_newton_share; share *= 0.5) {
    auto s = p.state;
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
  constexpr double turn = 2 * std::numbers::pi;
  auto unwound = p.end.state.q;
  bool turned = false;
  for (std::size_t i = 2; i < unwound.size(); i += 3) {
    const double turns = std::round((unwound[i] - p.state.q[i]) / turn);
    turned |= turns != 0;
    unwound[i] -= turns * turn;
  }
  const double before = system.potential(unwound.data());
  const double after = system.potential(p.end.state.q.data());
  const double size = std::max({std::abs(before), std::abs(after), system.kinetic(p.end.state.v.data())});
  constexpr double rounding = 1e-6;  // of the energies
  return turned && std::abs(after - before) > rounding * size;
}

bool is_equilibrium(const ReturnMap& map, const ReturnPoint& p) {
  auto rate = p.end.columns.back();
  map.remove_shift(rate);
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (std::abs(rate[i]) > at_rest * p.end.scales[i]) return false;
  return true;
}

/// Orbit::step_error. The errors of adaptive steps are of second order.
double step_error(const Scene& scene, const System& system, const ReturnMap& map, const ReturnPoint& p,
                  StopToken stop) {
  double greatest = 0;
  for (const double share : finer_steps) {
    auto finer = scene;
    if (finer.nonsmooth.step)
      *finer.nonsmooth.step *= share;
    else
      finer.nonsmooth.step_tolerance *= share * share;
    const auto end = run_end_state(
        {.scene = finer, .system = system, .start = p.state, .end = p.state.t + map.length(), .stop = stop},
        Family::nonsmooth);
    if (!end.stopped.empty()) continue;
    const auto compare = [&](const std::vector<double>& a, const std::vector<double>& b, std::size_t from) {
      for (std::size_t i = 0; i < a.size(); ++i)
        greatest = std::max(greatest, std::abs(a[i] - b[i]) / p.end.scales[from + i]);
    };
    const auto n = end.state.q.size();
    compare(end.state.q, p.end.state.q, 0);
    compare(end.state.v, p.end.state.v, n);
    compare(end.state.z, p.end.state.z, 2 * n);
  }
  return greatest;
}

/// Throws if the shift is no symmetry of the mechanism at a state.
void check_shift(const System& system, const VectorXd& shift, const State& s) {
  if (shift.size() == 0) return;
  if (const auto what = changes_with_shift(system, shift, s); !what.empty())
    throw ModelError("shift", fmt::format("{} changes if the coordinates are shifted together", what));
}

/// The state of the section, after the periods to settle. Returns the reason of an earlier stop, else
/// nothing.
std::string settle(Simulation& simulation, const System& system, Family family, const OrbitRequest& request,
                   double period, SectionState& section) {
  const double end = simulation.t() + request.settle * period;
  if (family == Family::penalty) {
    const auto settled = run_end_state({.scene = simulation.scene(),
                                        .system = system,
                                        .start = simulation.state(),
                                        .end = end,
                                        .stop = request.stop},
                                       family);
    section = {settled.state, settled.contacts};
    return settled.stopped;
  }
  if (request.settle > 0) {
    const auto result = simulation.run({.until = end, .keep_events = false, .stop = request.stop});
    if (result.ending.status == Ending::Status::interrupted) throw Interrupted();
    if (result.ending.status != Ending::Status::finished) return result.ending.reason;
  }
  section = simulation.state();
  return {};
}

/// The state in the middle of the longest interval without a contact onset, if
/// one is near the section.
std::optional<SectionState> later_section(const ReturnMap& map, const SectionState& start) {
  const double length = map.length();
  const auto motion = map.motion(start, start.t + length, 0);
  if (!motion.stopped.empty() || motion.onsets.empty()) return {};
  double last = motion.onsets.back().t - length, longest = 0, middle = 0, least = length;
  for (const auto& onset : motion.onsets) {
    least = std::min({least, onset.t - start.t, start.t + length - onset.t});
    if (onset.t - last > longest) {
      longest = onset.t - last;
      middle = last + 0.5 * longest;
    }
    last = onset.t;
  }
  if (least > near_section * length) return {};
  const auto end = map.motion(start, middle > start.t ? middle : middle + length, 0);
  if (!end.stopped.empty()) return {};
  return SectionState(end.state, end.contacts);
}

}  // namespace

Orbit orbit(const Scene& scene, const OrbitRequest& request) {
  SectionState section;
  return orbit(scene, request, section);
}

Orbit orbit(const Scene& scene, const OrbitRequest& request, SectionState& section) {
  const auto family = family_of(request.formulation);
  if (request.periods < 1) throw ModelError("periods", "must be 1 or greater");
  if (!(request.settle >= 0) || !std::isfinite(request.settle))
    throw ModelError("settle", "must be 0 or greater");
  Simulation simulation(scene, request.formulation, {.start = {}, .stop = request.stop});
  const auto& given = simulation.scene();
  const System system(given.mechanism);
  refuse_sampling(system, no_derivatives);
  const auto excitation = excitation_of(given.mechanism, system);
  Orbit found;
  found.periods = request.periods;
  found.period = section_period(excitation, request.period);
  require_duration("settle", request.settle * found.period);
  require_duration("periods", request.periods * found.period);
  const bool autonomous = !excitation.any;
  SectionState start;
  if (const auto reason = settle(simulation, system, family, request, found.period, start); !reason.empty()) {
    found.failure = "the run before the section stopped: " + reason;
    return found;
  }
  ReturnMap map(given, system, found.period * request.periods, autonomous, request.stop, family);
  const auto shift = request.shift.empty() ? VectorXd() : shift_of(given.mechanism, request.shift);
  check_shift(system, shift, start);
  map.set_shift(shift);
  std::string why;
  ReturnPoint p;
  const auto begin = [&] {
    why = map.take_closed(start);
    map.chart(start);
    if (why.empty()) why = map.move(VectorXd::Zero(map.size()), start);
    if (!why.empty()) why = fmt::format("t = {:.9g} s, at the section: {}", start.t, why);
    if (!why.empty()) return;
    if (map.size() == 0 && map.closed().empty())
      throw ModelError("",
                       "the drives determine the motion of all bodies: it has no degrees of freedom whose "
                       "stability could be computed");
    p = map.at(start);
    if (!p.end.refused.empty() && p.end.stopped.empty())
      p.failure += "; a fraction of a period in settle moves the section";
  };
  double accepted = 0;
  std::string reason;
  bool exhausted = false;
  const auto search = [&] {
    exhausted = false;
    for (int i = 0; map.size() > 0 && p.failure.empty(); ++i) {
      exhausted = i == most_newton_steps;
      if (exhausted) return;
      const double before = p.greatest;
      if (before == 0 || !advance(map, p, reason)) return;
      ++found.iterations;
      if (p.greatest <= 0.5 * before) continue;
      accepted = map.accepted(p);
      if (p.greatest <= accepted) return;
      // The search has come to the errors of the steps, or it converges slowly.
      if (p.end.stepped && p.greatest <= step_error(given, system, map, p, request.stop)) return;
    }
  };
  const double settled = start.t;
  for (int moves = 0;; ++moves) {
    begin();
    reason = p.failure;
    if (why.empty()) search();
    if (why.empty() && p.failure.empty()) accepted = map.accepted(p);
    const bool ends = p.end.stepped || (p.failure.empty() && p.greatest <= accepted);
    if ((why.empty() && ends) || moves == most_moves) break;
    auto later = later_section(map, start);
    if (!later && why.empty()) later = later_section(map, p.state);
    if (!later) break;
    found.moved = later->t - settled;
    start = std::move(*later);
  }
  if (!why.empty()) {
    found.failure = why;
    return found;
  }
  int steps = fewest_map_steps;
  const bool several = request.periods > 1 && !autonomous && shift.size() == 0 && family == Family::nonsmooth;
  if (several && p.failure.empty() && !p.end.stepped && !(p.greatest <= accepted))
    if (const auto shot = shoot_periods(given, system, found.period, request.periods, start, request.stop)) {
      found.iterations += shot->iterations;
      map.take_closed(shot->first);
      map.chart(shot->first);
      if (auto next = map.at(shot->first); next.failure.empty()) {
        p = std::move(next);
        search();
      } else {
        map.take_closed(p.state);
        map.chart(p.state);
      }
    }
  found.state = section = p.state;
  if (p.failure.empty()) found.residual = p.greatest;
  if (p.end.stepped && p.failure.empty()) {
    found.step_error = step_error(given, system, map, p, request.stop);
    accepted = std::max(accepted, accepted_changes * found.step_error);
  }
  if (!(found.residual <= accepted)) {
    found.failure =
        p.failure.empty()
            ? fmt::format("Newton's method ends at a residual of {:.3g}, above {:.3g}, after {} steps{}",
                          found.residual, accepted, found.iterations,
                          exhausted        ? std::string()
                          : reason.empty() ? std::string(": no shorter step reduces it; try another number "
                                                         "of periods, or more periods to settle")
                                           : ": " + reason)
            : p.failure;
    return found;
  }
  if (autonomous) found.period = map.length() / request.periods;
  if (autonomous && is_equilibrium(map, p))
    found.failure = "the state found is an equilibrium; start with more motion, or give another period";
  else if (wound(system, p))
    found.failure = "bodies advance by whole turns against a torsional spring: the motion is not periodic";
  else
    found.failure = refine(map, p, steps);
  if (!found.failure.empty()) return found;
  found.residual = p.greatest;
  found.shift = p.shift;
  check_shift(system, shift, p.end.state);
  for (const auto& onset : p.end.onsets)
    found.impacts.push_back({onset.t, system.contact_facts(onset.contact).name, -onset.rate});
  for (const auto& contact : p.end.lasting)
    found.lasting.push_back({system.contact_facts(contact.contact).name, contact.least, contact.t, {}});
  for (const int k : map.constants())
    for (auto& contact : found.lasting)
      if (contact.joint == system.contact_facts(k).name)
        contact.v0 = p.state.contacts[static_cast<std::size_t>(k)].v0;
  auto multipliers = multipliers_of(p, autonomous);
  found.multipliers = std::move(multipliers.values);
  found.stable = multipliers.stable;
  return found;
}

}  // namespace freeplay

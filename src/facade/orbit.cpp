// Newton's method on the return map P of the section t = t₀ mod N T, in local coordinates
//
//     x(u) = Π(x_k + B u),   B = diag(Z, (2π/N T) Z, scales of states),   Zᵀ M Z = 1, G Z = 0,
//
// where Π is the projection onto the constraints, among them the contacts that are closed at the section.
// Π changes x orthogonally to B in the mass metric, so that Bᵀ M S B is the derivative of the map in these
// coordinates (docs/theory/orbits.md).
#include "facade/orbit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "dynamics/assembly/projection.hpp"
#include "dynamics/system.hpp"
#include "facade/excitation.hpp"
#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "formulations/differences.hpp"
#include "formulations/sensitivity.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

constexpr double whole_turn = 2 * std::numbers::pi;
constexpr int most_iterations = 40;
/// A motion is accepted as periodic if its residual is at most this times nonsmooth.tolerance: the
/// errors of the steps of some periods.
constexpr double accepted_errors = 1e3;
/// Newton steps are shortened at most to this share.
constexpr double least_share = 1e-3;
/// Directions in which the residual changes less than this, relative, are neutral: the mechanism has a
/// family of periodic motions along them.
constexpr double neutral = 1e-9;
/// A contact is closed at the section if its gap, relative to its measure, and its rate, relative to the
/// greatest speed, are below this.
constexpr double closed_gap = 1e-8;
/// Multipliers closer to the unit circle than this do not decide about stability. A double multiplier
/// is known to the square root of the error of the map.
constexpr double undecided = 1e-5;
/// Steps of the variational equations: at least this number over all periods, and then twice as many
/// until the derivative of the map changes by less than `settled`.
constexpr int fewest_steps = 64, most_steps = 1 << 16;
constexpr double settled = 1e-8;
/// A motion without a drive that would change the state by less than this in a period, in error scales
/// of unit tolerance, is an equilibrium.
constexpr double at_rest = 1e-3;

/// The return map near one state of the section.
struct Point {
  State state;
  EndState end;
  VectorXd residual;    ///< in local coordinates
  MatrixXd map;         ///< derivative of the map in local coordinates
  VectorXd flow;        ///< rate of the end along the motion, if the period is unknown
  double greatest = 0;  ///< Orbit::residual
  std::string failure;
};

class ReturnMap {
 public:
  ReturnMap(const Scene& scene, const System& system, double length, bool autonomous, StopToken stop)
      : scene_(scene), system_(system), stop_(stop), autonomous_(autonomous), length_(length) {
    if (system.longest_arm() > 0) curved_ = system.longest_arm();
    for (int k = 0; k < system.contacts(); ++k)
      if (system.contact_facts(k).has_clearance)
        curved_ = std::min(curved_, system.contact_facts(k).clearance);
  }

  bool autonomous() const { return autonomous_; }
  bool has_closed() const { return !closed_.empty(); }
  double length() const { return length_; }
  void set_length(double length) { length_ = length; }
  /// The contacts that are closed at a state, to rounding and to the errors of the method.
  void take_closed(const State& s) {
    auto e = system_.make_evaluation();
    system_.place(s.t, s.q.data(), e);
    double fastest = 0;
    for (const double v : s.v) fastest = std::max(fastest, std::abs(v));
    for (int k = 0; k < system_.contacts(); ++k) {
      ContactRow row;
      system_.contact(k, s.q.data(), s.v.data(), e, row);
      const double measure = system_.contact_facts(k).measure();
      if (std::abs(row.gap) < closed_gap * (measure > 0 ? measure : curved_) &&
          std::abs(row.normal.dot(s.v.data())) < closed_gap * fastest)
        closed_.push_back(k);
    }
  }
  /// Sets the local coordinates at a state: columns of the basis are directions of (q, v, z).
  void chart(const State& s) {
    const int n = system_.n();
    roots_ = VectorXd(n);
    for (int i = 0; i < n; ++i) roots_[i] = std::sqrt(system_.mass()[i]);
    MatrixXd rows = weighted_rows(system_, closed_, s);
    for (Eigen::Index k = 0; k < rows.cols(); ++k)
      if (const double size = rows.col(k).norm(); size > 0) rows.col(k) /= size;
    basis_ = MatrixXd::Identity(n, n);
    if (rows.cols() > 0) basis_ = orthogonal_complement(rows, 1e-9);
  }
  /// Number of local coordinates.
  Eigen::Index size() const { return 2 * basis_.cols() + system_.states(); }
  /// The state at local coordinates u; a failure if it cannot be assembled or a contact overlaps.
  std::string move(const VectorXd& u, State& s) const {
    const auto f = basis_.cols();
    const VectorXd dq = (basis_ * u.head(f)).cwiseQuotient(roots_);
    const VectorXd dv = (basis_ * u.segment(f, f)).cwiseQuotient(roots_) / time_unit();
    for (Eigen::Index i = 0; i < dq.size(); ++i) {
      s.q[static_cast<std::size_t>(i)] += dq[i];
      s.v[static_cast<std::size_t>(i)] += dv[i];
    }
    for (int k = 0; k < system_.states(); ++k)
      s.z[static_cast<std::size_t>(k)] += u[2 * f + k] * system_.state_scale(k);
    if (!project_onto_constraints(system_, closed_, s)) return "the mechanism cannot be closed there";
    auto e = system_.make_evaluation();
    system_.place(s.t, s.q.data(), e);
    for (int k = 0; k < system_.contacts(); ++k)
      if (std::ranges::find(closed_, k) == closed_.end() && system_.gap(k, s.q.data(), e) < 0)
        return fmt::format("contact {} overlaps there", system_.contact_facts(k).name);
    return {};
  }
  /// `steps`: least number of steps.
  Point at(const State& s, int steps = fewest_steps) const {
    Point p;
    p.state = s;
    p.end = run_end_state({.scene = scene_,
                           .system = system_,
                           .start = s,
                           .end = s.t + length_,
                           .keys = directions(s),
                           .quantities = {},
                           .stop = stop_,
                           .longest_step = length_ / steps});
    p.failure = p.end.stopped.empty() ? p.end.refused : p.end.stopped;
    if (p.failure.empty()) compare(p);
    return p;
  }

 private:
  double time_unit() const { return length_ / whole_turn; }
  /// Derivatives of the projected state with respect to the local coordinates.
  std::vector<VariedKey> directions(const State& s) const {
    const auto n = static_cast<Eigen::Index>(system_.n());
    const auto all = [](const State& state) {
      auto list = state.q;
      list.insert(list.end(), state.v.begin(), state.v.end());
      list.insert(list.end(), state.z.begin(), state.z.end());
      return list;
    };
    std::vector<VariedKey> list;
    for (Eigen::Index c = 0; c < size(); ++c) {
      const VectorXd unit = VectorXd::Unit(size(), c);
      const VectorXd dq = (basis_ * unit.head(basis_.cols())).cwiseQuotient(roots_);
      double most = 0;
      for (Eigen::Index i = 0; i < n; ++i)
        most = std::max(most, std::abs(dq[i]) / (system_.is_angle(static_cast<int>(i)) ? 1 : curved_));
      const double spacing = most > 0 ? 1e-3 / most : 1;
      const auto d = difference(spacing, all(s), [&](std::size_t i) {
        State moved = s;
        move(difference_places[i] * spacing * unit, moved);
        return all(moved);
      });
      list.push_back({.name = "the state of the section", .start = d.slope, .refused = {}});
    }
    if (autonomous_) {
      list.push_back({.name = "the period",
                      .start = std::vector<double>(static_cast<std::size_t>(2 * n + system_.states())),
                      .refused = {}});
      list.back().end_rate = length_;
    }
    return list;
  }
  /// Local coordinates of a difference of (q, v, z).
  VectorXd local(const std::vector<double>& difference) const {
    const Eigen::Map<const VectorXd> all(difference.data(), static_cast<Eigen::Index>(difference.size()));
    const auto n = static_cast<Eigen::Index>(system_.n()), f = basis_.cols();
    VectorXd u(size());
    u.head(f) = basis_.transpose() * all.head(n).cwiseProduct(roots_);
    u.segment(f, f) = basis_.transpose() * all.segment(n, n).cwiseProduct(roots_) * time_unit();
    for (int k = 0; k < system_.states(); ++k) u[2 * f + k] = all[2 * n + k] / system_.state_scale(k);
    return u;
  }
  void compare(Point& p) const {
    std::vector<double> change;
    const auto append = [&](const std::vector<double>& to, const std::vector<double>& from) {
      for (std::size_t i = 0; i < to.size(); ++i) change.push_back(to[i] - from[i]);
    };
    append(p.end.state.q, p.state.q);
    append(p.end.state.v, p.state.v);
    append(p.end.state.z, p.state.z);
    for (int i = 2; i < system_.n(); i += 3)
      change[static_cast<std::size_t>(i)] = std::remainder(change[static_cast<std::size_t>(i)], whole_turn);
    for (std::size_t i = 0; i < change.size(); ++i)
      p.greatest = std::max(p.greatest, std::abs(change[i]) / p.end.scales[i]);
    p.residual = local(change);
    p.map.resize(size(), size());
    for (Eigen::Index c = 0; c < size(); ++c)
      p.map.col(c) = local(p.end.columns[static_cast<std::size_t>(c)]);
    if (autonomous_) p.flow = local(p.end.columns.back());
  }

  const Scene& scene_;
  const System& system_;
  StopToken stop_;
  bool autonomous_;
  double length_;   // s, of all periods
  MatrixXd basis_;  // M^(1/2) Z
  VectorXd roots_;  // diagonal of M^(1/2)
  std::vector<int> closed_;
  double curved_ = 1;  // m, length over which the constraints are curved
};

/// The Newton step: local coordinates, then the relative change of the period if that is unknown. Of
/// several solutions, it is the shortest one, so that neutral directions are not followed.
VectorXd newton_step(const Point& p) {
  MatrixXd A(p.map.rows(), p.map.cols() + (p.flow.size() > 0 ? 1 : 0));
  A.leftCols(p.map.cols()) = p.map - MatrixXd::Identity(p.map.rows(), p.map.cols());
  if (p.flow.size() > 0) A.rightCols(1) = p.flow;
  return MinimumNorm(A, neutral).solve(-p.residual);
}

/// A shortened Newton step that reduces the residual. Returns false and the reason if there is none.
bool advance(ReturnMap& map, Point& p, std::string& reason) {
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
bool wound(const System& system, const Point& p) {
  const double before = system.potential(p.state.q.data());
  double size = std::max({std::abs(before), std::abs(p.end.potential), p.end.kinetic});
  bool turned = false;
  for (int i = 2; i < system.n(); i += 3)
    turned |= std::abs(p.end.state.q[static_cast<std::size_t>(i)] - p.state.q[static_cast<std::size_t>(i)]) >
              std::numbers::pi;
  return turned && std::abs(p.end.potential - before) > 1e-6 * size;
}

/// Refines the steps until the derivative of the map no longer depends on them. Returns the reason if it
/// always does.
std::string refine(const ReturnMap& map, Point& p) {
  if (map.size() == 0) return {};
  for (int steps = 2 * fewest_steps; steps <= most_steps; steps *= 2) {
    auto finer = map.at(p.state, steps);
    if (!finer.failure.empty()) return finer.failure;
    const double change = (finer.map - p.map).cwiseAbs().maxCoeff();
    p = std::move(finer);
    if (change <= settled * std::max(1.0, p.map.cwiseAbs().maxCoeff())) return {};
  }
  return fmt::format("the derivative of the return map still changes between {} and {} steps per motion",
                     most_steps / 2, most_steps);
}

bool is_equilibrium(const Point& p) {
  const auto& rate = p.end.columns.back();
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (std::abs(rate[i]) > at_rest * p.end.scales[i]) return false;
  return true;
}

void take_multipliers(const Point& p, bool autonomous, Orbit& found) {
  found.stable = true;
  if (p.map.size() == 0) return;
  const auto values = general_eigen(p.map).values;
  found.multipliers.assign(values.begin(), values.end());
  std::ranges::stable_sort(found.multipliers, [](const auto& a, const auto& b) {
    return std::pair(std::abs(a), a.imag()) > std::pair(std::abs(b), b.imag());
  });
  auto decisive = found.multipliers;
  if (autonomous && !decisive.empty())  // that of a shift along the motion
    decisive.erase(std::ranges::min_element(decisive, {}, [](const auto& m) { return std::abs(m - 1.0); }));
  found.stable = std::ranges::all_of(decisive, [](const auto& m) { return std::abs(m) < 1 - undecided; });
}

}  // namespace

Orbit orbit(const Scene& scene, const OrbitRequest& request) {
  if (family_of(request.formulation) == Family::penalty)
    throw ModelError("formulation", "\"penalty\" has no derivatives yet; use \"nonsmooth\"");
  if (scene.nonsmooth.scheme_in_force() == Scheme::moreau_jean)
    throw ModelError("nonsmooth.scheme",
                     "time stepping has no derivatives yet; set it to \"event-driven\" or \"automatic\"");
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
  ReturnMap map(given, system, found.period * request.periods, autonomous, request.stop);
  auto start = simulation.state();
  map.take_closed(start);
  map.chart(start);
  if (const auto why = map.move(VectorXd::Zero(map.size()), start); !why.empty()) {
    found.failure = fmt::format("t = {:.9g} s, at the section: {}", start.t, why);
    return found;
  }
  if (map.size() == 0 && !map.has_closed())
    throw ModelError("",
                     "the drives determine the motion of all bodies: it has no degrees of freedom whose "
                     "stability could be computed");
  auto p = map.at(start);
  if (!p.end.refused.empty() && p.end.stopped.empty())
    p.failure += "; a fraction of a period in settle moves the section";
  const double accepted = accepted_errors * given.nonsmooth.tolerance;
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
    found.failure = refine(map, p);
  if (!found.failure.empty()) return found;
  found.residual = p.greatest;
  for (const auto& onset : p.end.onsets)
    found.impacts.push_back({onset.t, system.contact_facts(onset.contact).name, -onset.rate});
  take_multipliers(p, autonomous, found);
  return found;
}

}  // namespace freeplay

// VariedColumns: what the variational equations of both formulations share. With x the integrated
// vector, S = dx/dp has one column per parameter, and
//
//     Ṡ = f_x S + f_p
//
// within a mode. f_x S is exact to rounding (Dynamics::directional). Ṡ is integrated by the stages of
// Dormand and Prince. Derivatives with respect to p at a fixed state, and those of functions of the
// state, are differences of fourth order of closed forms at a fixed mode (differences.hpp). For this, each
// parameter has four systems with displaced values, and closer ones where a kink is within the first. No
// trajectory is differenced. Where the equations can be traced (trace()), f_p is exact, too, but for the
// differences of the constants in them.
//
// A Dynamics has the members system, knot, size(), state_offset(), operator() and directional(), the type
// Present of the run's dynamics, and these functions of its namespace (optionally pin() and unpin(), between
// which it is evaluated beside one state):
//
//     take_varied_mode(f, dynamics)        copies the mode
//     observed(column, f, x, t)            value of a column of trajectory.csv or forces.csv
//     curved_length(f, x, length)          length (m) and
//     curved_speed(f, x)                   speed (m/s) over which functions of the state are curved there
//     further_spacing(f, x, dx)            inverse of the greatest step along dx by other components
//
// Subclasses add the events (event_driven/variation.hpp, penalty/penalty_variation.hpp).
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/variation/differences.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/traced_equations.hpp"
#include "formulations/variation/varied_peaks.hpp"

namespace freeplay {

/// S, whatever the dynamics. A column ends where there is no derivative, with a reason.
class DerivativeColumns {
 public:
  using Vector = std::vector<double>;
  using Onset = VariedOnset;

  /// From now on all columns have no derivative, for this reason.
  void refuse(const std::string& reason) {
    for (std::size_t c = 0; c < keys_.size(); ++c) refuse(c, reason);
  }
  /// Ends a column, for this reason.
  void refuse(std::size_t c, const std::string& reason) {
    if (!open(c)) return;
    reasons_[c] = reason;
    std::ranges::fill(S_[c], 0.0);
  }
  /// The reason why a column has ended; empty if it has not.
  const std::string& reason(std::size_t c) const { return reasons_[c]; }
  const std::vector<Onset>& onsets() const { return onsets_; }
  virtual void forget_onsets() { onsets_.clear(); }
  /// A caller may replace them between steps (tangent_run.hpp).
  std::vector<Vector>& columns() { return S_; }
  /// Continues with the columns of another object.
  void take_columns(const DerivativeColumns& from) {
    S_ = from.S_;
    reasons_ = from.reasons_;
  }
  long evaluations() const { return evaluations_; }

 protected:
  explicit DerivativeColumns(std::vector<VariedKey> keys) : keys_(std::move(keys)), reasons_(keys_.size()) {}
  ~DerivativeColumns() = default;
  bool open(std::size_t c) const { return reasons_[c].empty(); }

  std::vector<VariedKey> keys_;
  std::vector<Vector> S_;
  std::vector<std::string> reasons_;
  std::vector<Onset> onsets_;
  long evaluations_ = 0;
};

template <class Dynamics>
class VariedColumns : public DerivativeColumns {
 public:
  using Present = typename Dynamics::Present;
  /// A function of the state, evaluated with the dynamics of the nominal or of a displaced system.
  using Function = std::function<Vector(Dynamics&, const Vector& x, double t)>;

  /// Value and derivatives of a function at the end of the run, at x and t in the present mode of
  /// `dynamics`.
  Vector end_derivatives(const Present& dynamics, const Vector& x, double t, const Function& value,
                         double& now, std::vector<std::string>& reasons);
  /// dx/dp of all columns at the end of the run, at x and t in the present mode. A column without a
  /// derivative is zero.
  std::vector<Vector> end_columns(const Present& dynamics, const Vector& x, double t) {
    take_mode(dynamics);
    Vector f(size_);
    (*probe_)(x, f, t);
    auto columns = S_;
    for (std::size_t c = 0; c < keys_.size(); ++c)
      if (open(c)) add_multiple(columns[c], keys_[c].end_rate, f);
    return columns;
  }
  /// Mean of the i-th integrand from `begin` to `end` (s), and its derivatives at the end of the run. The
  /// mean of a force includes the impulses of impacts.
  double mean(std::size_t i, double begin, double end) const { return integrals_[i] / (end - begin); }
  Vector mean_derivatives(std::size_t i, const Present& dynamics, const Vector& x, double begin, double end);
  /// Signals whose peaks are needed; called before the run.
  void watch_peaks(std::vector<PeakChannel> channels) { peaks_.watch(std::move(channels), keys_.size()); }
  /// The peak of a signal at the end of the run, at x and t in the present mode of `dynamics`.
  VariedPeaks::Peak peak(std::size_t i, const Present& dynamics, const Vector& x, double t);

  /// Demand of a controller over its limit.
  static double demand(const Dynamics& f, int k, const Vector& x, double t) {
    std::vector<Saturation> all(static_cast<std::size_t>(f.system.limiters()));
    f.system.saturations(t, x.data(), x.data() + f.system.n(), x.data() + f.state_offset(), all.data());
    return all[static_cast<std::size_t>(k)].share;
  }
  /// Distance of the coordinate of a phase from a kink, which is the end of the nominal system's piece, for
  /// any system of the same structure; NaN if it has other kinks.
  template <class State>
  static double from_kink(const System& nominal, const System& system, int k, double kink, const State& x) {
    const auto &a = nominal.phase(k), &b = system.phase(k);
    const double turns = a.period > 0 ? std::floor((kink - a.kinks.front()) / a.period + 1e-9) : 0;
    const auto place = std::ranges::min_element(
        a.kinks, {}, [&](double at) { return std::abs(at + turns * a.period - kink); });
    if (a.kinks.size() != b.kinks.size()) return NAN;
    return b.at(x.data(), x.data() + system.n()).value -
           (b.kinks[static_cast<std::size_t>(place - a.kinks.begin())] + turns * b.period);
  }

 protected:
  using Displaced = std::array<std::unique_ptr<Dynamics>, 4>;
  /// The dynamics of the i-th displaced system of a key, beside those of the nominal one.
  using Displace =
      std::function<std::unique_ptr<Dynamics>(Dynamics& probe, const VariedKey& key, std::size_t i)>;
  /// `probe`: of the nominal system; `integrands`: columns whose means are needed; `length` (m) and
  /// `duration` (s): scales over which functions of the state and of time are curved.
  VariedColumns(std::unique_ptr<Dynamics> probe, std::vector<VariedKey> keys, const Displace& displace,
                std::vector<Column> integrands, double length, double duration);
  ~VariedColumns() = default;

  /// Right-hand side and integrands on one side of an event.
  struct Side {
    Vector f, integrands;
  };
  Side side(Dynamics& f, const Vector& x, double t) const {
    Side s{Vector(x.size()), {}};
    f(x, s.f, t);
    if (!integrands_.empty()) s.integrands = integrands()(f, x, t);
    return s;
  }
  /// Whether accelerations, forces, rates of states or powers jump between the two sides of an event. Forces
  /// of a prescribed motion may jump alone.
  bool jumps(const Side& before, const Side& after) const {
    // Relative changes that are no jumps: rounding at the event, and of a state over the scene's duration.
    constexpr double same = 1e-7, same_rate = 1e-12;
    const auto n = static_cast<std::size_t>(probe_->system.n());
    const auto impulses = static_cast<std::size_t>(probe_->impulse_offset()),
               contacts = static_cast<std::size_t>(probe_->system.contacts()),
               states = static_cast<std::size_t>(probe_->system.states()),
               works = static_cast<std::size_t>(probe_->integral_offset());
    const auto differ = [](std::span<const double> a, std::span<const double> b) {
      double scale = 0;
      for (std::size_t i = 0; i < a.size(); ++i) scale = std::max({scale, std::abs(a[i]), std::abs(b[i])});
      for (std::size_t i = 0; i < a.size(); ++i)
        if (!(std::abs(b[i] - a[i]) <= same * scale)) return true;
      return false;
    };
    const std::span<const double> f(before.f), g(after.f);
    const auto in = [&](std::size_t from, std::size_t count) {
      return differ(f.subspan(from, count), g.subspan(from, count));
    };
    const auto flows = static_cast<std::size_t>(probe_->state_offset());
    for (std::size_t k = flows; k < flows + states; ++k)
      if (!(std::abs(g[k] - f[k]) <=
            same * std::max(std::abs(f[k]), std::abs(g[k])) +
                same_rate * probe_->system.state_scale(static_cast<int>(k - flows)) / duration_))
        return true;
    return in(n, n) || in(impulses, 2 * contacts) || in(works, f.size() - works) ||
           differ(before.integrands, after.integrands);
  }
  /// An event at x⁻ and t, at which S⁺ = J_x (S⁻ + f⁻ dt) + J_t dt + J_p − f⁺ dt (saltation).
  struct EventMap {
    const Vector& x;
    double t;
    Side before, after;
    double speed;  ///< m/s, over which functions of the state are curved
    Vector dt;     ///< of each column
  };
  /// S⁻ + f⁻ dt of column c.
  Vector carried(const EventMap& e, std::size_t c) const {
    auto dx = S_[c];
    add_multiple(dx, e.dt[c], e.before.f);
    return dx;
  }
  /// Sets dt for a root of `value` that changes at `rate` (1/s); `normal`: of a gap, else null. Ends a column
  /// without dt, and if `strict` one along whose key the function has a kink.
  void set_times(EventMap& e, const Function& value, double rate, const SparseRow* normal, bool strict);
  /// Refuses an onset after which the contact separates again within grazing_depth(). `away`: acceleration of
  /// the gap.
  void refuse_grazing(int k, const EventMap& e, double rate, double away) {
    const auto& system = probe_->system;
    if (away > 0 && rate * rate < 2 * away * grazing_depth(system, k, e.x))
      refuse(
          fmt::format("t = {:.9g} s: contact {} grazes (approach {:.2g} m/s); grazing contacts have no "
                      "derivative",
                      e.t, system.contact_facts(k).name, -rate));
  }
  /// The sides of a controller's limit; `next`: the dynamics after it, at x_after.
  void take_sides_of_limit(EventMap& e, Dynamics& next, int k, const Vector& x_after);
  /// Depth (m) up to which a contact grazes: one that would separate again within it without an impact. Below
  /// it, rounding and the curvature of the gap decide whether there is an impact.
  template <class State>
  static double grazing_depth(const System& system, int k, const State& x) {
    const auto& facts = system.contact_facts(k);
    const double size = facts.has_clearance ? facts.clearance : facts.radius;
    return std::max(1e-6 * size, 1e3 * gap_rounding(system, k, x.data()));
  }
  Function integrands() const {
    return [this](Dynamics& f, const Vector& x, double t) {
      Vector list;
      for (const auto& c : integrands_) list.push_back(observed(c, f, x, t));
      return list;
    };
  }
  /// Whether steps need not be followed.
  bool idle() const {
    return integrands_.empty() && !peaks_.any() &&
           std::ranges::none_of(reasons_, [](const auto& r) { return r.empty(); });
  }
  /// Copies the mode to all objects.
  void take_mode(const Present& dynamics) {
    take_varied_mode(*probe_, dynamics);
    each_displaced([&](Dynamics& f) { take_varied_mode(f, dynamics); });
  }
  template <class Visit>
  void each_displaced(Visit visit) {
    for (auto& list : displaced_)
      for (auto& f : list)
        if (f) visit(*f);
    for (auto& levels : closer_)
      for (auto& level : levels)
        for (auto& f : level.dynamics) visit(*f);
  }
  /// Before a step from t_old that ends at the knot or before.
  void take_knot(const System& system, double t_old, double knot);
  /// Advances S over a step of constant mode, in halves where S varies faster than the motion, as about a
  /// rest. Returns x at its end.
  Vector advance_stages(double t_old, const Vector& x_old, double h, int halvings = 0);
  /// x after the time h, which may be negative, in the present mode, without S.
  Vector flow(const Vector& x, double t, double h);
  /// advance_stages() that finds peaks of signals within the step.
  Vector advance_watched(double t_old, const Vector& x_old, double h);
  /// A possible peak of signal i at a state; `dt`: of each column, the derivative of the time.
  void add_peak(std::size_t i, double t, const Vector& x, double rate, const Vector& dt);
  /// Possible peaks at an event at x, where the rates of signals change.
  void add_event_peaks(double t, const Vector& x, const Vector& f, const Vector& after, const Vector& f_after,
                       const Vector& dt);
  double spacing(const Dynamics& f, const Vector& x, const Vector& dx, double dt, double speed) const;
  Difference along(Dynamics& f, const Function& value, const Vector& centre, const Vector& x, double t,
                   const Vector& dx, double dt, double speed);
  double within_rates(double h, Dynamics& f, const Vector& x, double t, const Vector& dx, double dt);
  Difference across(std::size_t c, const Function& value, const Vector& centre, const Vector& x, double t);
  std::optional<Difference> together(std::size_t c, const Function& value, const Vector& centre,
                                     const Vector& x, double t, const Vector& dx, double dt, double speed);
  /// Total derivative of a function along column c; ends the column at a kink if `strict`. Rounding errors
  /// of a smooth function that nearly vanishes can pass for a kink.
  Vector total(std::size_t c, const Function& value, const Vector& x, double t, const Vector& dx, double dt,
               double speed, bool strict = true);

  static void add_multiple(Vector& y, double factor, const Vector& x) {
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
  }

  std::unique_ptr<Dynamics> probe_;
  std::vector<Displaced> displaced_;  // null for initial values
  /// The dynamics of another value of a parameter, in the present mode; without it there are no closer
  /// values.
  std::function<std::unique_ptr<Dynamics>(const System&)> twin_of_;
  std::vector<int> approaching_;  // contacts of the impact whose derivatives are formed
  std::vector<Column> integrands_;
  Vector integrals_;                    // ∫ of the integrands
  std::vector<Vector> integral_rates_;  // their derivatives, one list for each column
  double length_, duration_;
  std::size_t size_;
  std::array<Vector, 6> f_, trial_;  // of advance_stages() and flow()
  /// s, dt of each column: in advance_stages(), S is the derivative at times that change by it.
  Vector shifts_;
  VariedPeaks peaks_;

 private:
  Vector advance_part(double t_old, const Vector& x_old, double h);
  /// What a step changes, to repeat it.
  struct Place {
    std::vector<Vector> S, integral_rates;
    Vector integrals;
    std::vector<VariedPeaks::Modes> modes;
  };
  Place place() const { return {S_, integral_rates_, integrals_, peaks_.modes}; }
  void go_back(const Place& p) {
    S_ = p.S;
    integral_rates_ = p.integral_rates;
    integrals_ = p.integrals;
    peaks_.modes = p.modes;
  }
  /// Ratio of the spacings of differences that are tried in turn.
  static constexpr double ratio = 0.03;
  /// Displaced dynamics at closer values, where they were needed.
  struct Closer {
    double spacing = 0;
    Displaced dynamics;
  };
  bool displace_closer(std::size_t c);
  Vector slopes_at(double t, std::vector<Vector>& slopes);
  template <std::size_t stages>
  double error_of(const double (&weights)[stages], double h, double speed);
  bool varies_fast(const Vector& x_old, double t_old, double h);
  std::vector<std::vector<Closer>> closer_;
  void integrate(double weight, std::size_t stage, const Vector& x, double t);
  void parameter_part(std::size_t c, const Vector& x, double t, const Vector& f, Vector& out);

  Vector stage_, part_;
  std::array<std::vector<Vector>, 6> slopes_;
  std::vector<Vector> seeds_;
  Vector last_f_;                      // at the end of a step, if ends_
  std::vector<Vector> last_slopes_;    // likewise
  bool ends_ = false, begun_ = false;  // begun_: f_[0] and slopes_[0] are those at the beginning of a step
};

}  // namespace freeplay

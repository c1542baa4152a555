// The oracle: every impact of the slider-crank with clearance of loose_slider_crank.hpp, in either
// formulation.
//
//     flight        θ̈ = (m s r ω²/J_A) sin(φ − θ),   ẍ = 0,   up to the root of |e| = c
//     nonsmooth     u_N⁺ = −e u_N⁻,   −P_T ∈ μ P_N Sgn(u_T⁺),   at once (oblique_impact.hpp)
//     penalty       F_N = max(0, K δ^{3/2} (1 + χ δ̇/v₀)),   F_T = −μ c_d F_N sgn(v_T),
//                   while δ ≥ 0;
//                   v₀ is δ̇ at first contact; c_d(|v_T|) rises from 0 at v_a to 1 at v_b
//                   (Ambrósio)
//
// This is the one reference with time integration, since a damped contact under load has no closed
// form. It shares nothing with the project's solvers: two coordinates instead of nine and rows of
// constraints, and steps of order 8 whose error is below rounding. A root is bisected on the length
// of the step itself until it no longer changes, so an impact is located to the rounding of Real
// (long double, or a multiprecision type). δ^{3/2} is not smooth at the ends of a contact: no step
// there exceeds 1/16 of the time to the end, which keeps the order.
//
// Sign convention: v_n the gap's rate ġ, negative when closing; v_t = t·ė − R_i θ̇; impulses on the
// journal along −n and t. Units: s, m/s, N s, N/m^{3/2}. Not included: Painlevé's cases, friction
// in the guide, motion in lasting contact (a run ends there and reports it).
// Source: loose_slider_crank.hpp; laws of Flores et al., Nonlinear Dyn. 65 (2011) 383, and of
// Moreau (1988).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "verification/references/loose_slider_crank.hpp"
#include "verification/references/numerics.hpp"

namespace freeplay::reference {

template <class Real>
struct OracleOptions {
  Real flight_step = Real(2e-5L);  ///< s
  int contact_steps = 256;         ///< per undamped Hertz duration of the contact
  /// in undamped Hertz durations; a longer contact counts as lasting
  Real longest_contact = 20;
  /// m/s: a rebound slower than this into a closing gap counts as lasting. The bounce height u²/(2
  /// g̈) must stay above the rounding of the coordinates, hence √ε.
  Real least_speed = [] {
    using std::sqrt;
    return Real(32 * sqrt(std::numeric_limits<Real>::epsilon()));
  }();
  int most_impacts = 10000;
};

template <class Real>
struct PenaltyContact {
  Real stiffness = Real(1.055e11L);  ///< K, N/m^{3/2}
  Real chi = 0;                      ///< χ; delivered_restitution.hpp gives that of an ê
  Real friction_v0 = Real(1e-4L);    ///< v_a, m/s; used where the mechanism has friction
  Real friction_v1 = Real(1e-3L);    ///< v_b, m/s, > v_a
  Real least_v0 = Real(1e-9L);       ///< m/s: v₀ of a contact with a slower onset
};

template <class Real>
struct OracleImpact {
  Real t = 0, duration = 0;           ///< s, first contact; 0 for the nonsmooth law
  Real v_n_minus = 0, v_n_plus = 0;   ///< m/s
  Real v_t_minus = 0, v_t_plus = 0;   ///< m/s
  Real impulse_n = 0, impulse_t = 0;  ///< N s
};

enum class OracleEnd { end_time, most_impacts, lasting_contact };

template <class Real>
struct OracleRun {
  std::vector<OracleImpact<Real>> impacts;  ///< complete ones only
  /// Compliant contact still open at the end: its onset; as `duration`, that of the undamped Hertz
  /// impact.
  std::optional<OracleImpact<Real>> open;
  OracleEnd end = OracleEnd::end_time;
  Real t = 0;                ///< s, where the run ends
  LooseState<Real> state{};  ///< there
};

/// The least length in (0, h] at which `crossed` becomes true, given that it is false at 0 and true
/// at h.
template <class Real, class Predicate>
Real bisect_length(const Predicate& crossed, Real h) {
  Real low = 0, high = h;
  for (int i = 0; i < 200; ++i) {
    const Real middle = (low + high) / 2;
    if (middle <= low || middle >= high) break;
    (crossed(middle) ? high : low) = middle;
  }
  return high;
}

template <class Real>
class SliderCrankOracle {
 public:
  explicit SliderCrankOracle(const LooseSliderCrank<Real>& mechanism, const OracleOptions<Real>& options = {})
      : m_(mechanism), options_(options) {}

  /// Newton's restitution and Coulomb's friction, from the ideal start to the end time (s).
  OracleRun<Real> nonsmooth(Real restitution, Real end_time) const {
    return run(end_time, [&](OracleRun<Real>& r) {
      const GudgeonContact<Real> k = gudgeon_contact(m_, r.t, r.state);
      const ObliqueImpact<Real> p = oblique_impact(k.delassus, k.u_n, k.u_t, restitution, m_.friction);
      if (p.kind == ImpactCase::none) return true;  // grazing
      r.state[1] += (k.w_n[0] * p.impulse_n + k.w_t[0] * p.impulse_t) / m_.rod_inertia_about_pin();
      r.state[3] += (k.w_n[1] * p.impulse_n + k.w_t[1] * p.impulse_t) / m_.slider_mass;
      r.impacts.push_back({r.t, 0, k.u_n, p.u_n, k.u_t, p.u_t, p.impulse_n, p.impulse_t});
      return p.u_n > options_.least_speed || !closing(r.t, r.state);
    });
  }

  /// The compliant contact, from the ideal start to the end time (s).
  OracleRun<Real> penalty(const PenaltyContact<Real>& law, Real end_time) const {
    return run(end_time, [&](OracleRun<Real>& r) { return pass_contact(law, end_time, r); });
  }

  /// Free flight from t over h (s), in one step.
  LooseState<Real> fly(Real t, const LooseState<Real>& y, Real h) const {
    return method_.step([this](Real at, const LooseState<Real>& s) { return loose_rates(m_, at, s); }, t, y,
                        h);
  }

 private:
  /// Flights, each followed by `contact`, which returns whether the journal separates again.
  template <class Contact>
  OracleRun<Real> run(Real end_time, const Contact& contact) const {
    OracleRun<Real> r;
    r.state = ideal_start(m_);
    bool from_wall = false;
    while (fly_to_touch(end_time, from_wall, r)) {
      from_wall = true;
      const bool leaves = contact(r);
      if (!leaves) {
        if (r.t < end_time) r.end = OracleEnd::lasting_contact;
        return r;
      }
      if (static_cast<int>(r.impacts.size()) >= options_.most_impacts) {
        r.end = OracleEnd::most_impacts;
        return r;
      }
    }
    return r;
  }

  /// Integrates the flight until first contact with the wall (true) or the end time.
  bool fly_to_touch(Real end_time, bool from_wall, OracleRun<Real>& r) const {
    while (r.t < end_time) {
      const Real h = std::min(options_.flight_step, end_time - r.t);
      const auto room = [&](Real tau) { return eccentricity(m_, r.t + tau, fly(r.t, r.state, tau)); };
      Real touch = -1;
      if (from_wall) {
        // At the start `room` is zero up to rounding: the next root is bracketed by a point of the
        // bounce before it.
        Real inside = h;
        for (int i = 0; i < 200 && !(room(inside).room > 0); ++i) inside /= 2;
        if (inside < h) {
          touch = inside + bisect_length([&](Real tau) { return room(inside + tau).room < 0; }, h - inside);
        }
      } else if (room(h).room < 0) {
        touch = bisect_length([&](Real tau) { return room(tau).room < 0; }, h);
      } else if (eccentricity(m_, r.t, r.state).room_rate < 0 && room(h).room_rate > 0) {
        const Real least = bisect_length([&](Real tau) { return room(tau).room_rate > 0; }, h);
        if (room(least).room < 0) touch = bisect_length([&](Real tau) { return room(tau).room < 0; }, least);
      }
      const Real tau = touch < 0 ? h : touch;
      r.state = fly(r.t, r.state, tau);
      r.t = touch < 0 && h < options_.flight_step ? end_time : r.t + tau;
      if (touch >= 0) return true;
      from_wall = false;
    }
    return false;
  }

  /// Whether the gap accelerates inwards in free flight: d²room/dt² = −(ė·ė + e·ë)/c.
  bool closing(Real t, const LooseState<Real>& y) const {
    using std::cos, std::sin;
    const Eccentricity<Real> e = eccentricity(m_, t, y);
    const LooseState<Real> rate = loose_rates(m_, t, y);
    const Real phi = m_.start_angle + m_.speed * t, w2r = m_.speed * m_.speed * m_.crank_length;
    const Real s = sin(y[0]), c = cos(y[0]), l = m_.rod_length;
    const Real a_x = w2r * cos(phi) + l * (rate[1] * s + y[1] * y[1] * c);
    const Real a_y = w2r * sin(phi) - l * (rate[1] * c - y[1] * y[1] * s);
    return e.rate_x * e.rate_x + e.rate_y * e.rate_y + e.e_x * a_x + e.e_y * a_y > 0;
  }

  /// From first contact to separation (true), or to a lasting contact or the end time (false).
  bool pass_contact(const PenaltyContact<Real>& law, Real end_time, OracleRun<Real>& r) const {
    using std::abs, std::pow, std::sqrt;
    const GudgeonContact<Real> first = gudgeon_contact(m_, r.t, r.state);
    OracleImpact<Real> impact;
    impact.t = r.t, impact.v_n_minus = first.u_n, impact.v_t_minus = first.u_t;
    const Real v0 = std::max(-first.u_n, law.least_v0);
    const Real scale =
        Real(2.9432L) / v0 * pow(5 * v0 * v0 / (4 * law.stiffness * first.delassus.nn), Real(2) / 5);
    const auto rates = [&](Real t, const LooseState<Real>& y) {
      const GudgeonContact<Real> k = gudgeon_contact(m_, t, y);
      if (k.delta <= 0) return loose_rates(m_, t, y);
      const Real force =
          std::max(Real(0), law.stiffness * k.delta * sqrt(k.delta) * (1 - law.chi * k.u_n / v0));
      const Real ramp = (abs(k.u_t) - law.friction_v0) / (law.friction_v1 - law.friction_v0);
      const Real share = std::clamp(ramp, Real(0), Real(1)) * m_.friction;
      const Real drag = k.u_t > 0 ? -share * force : share * force;
      LooseState<Real> rate =
          loose_rates(m_, t, y, k.w_n[0] * force + k.w_t[0] * drag, k.w_n[1] * force + k.w_t[1] * drag);
      rate[4] = force, rate[5] = drag;
      return rate;
    };
    r.state[4] = r.state[5] = 0;
    GudgeonContact<Real> now = first;
    for (;;) {
      const Real to_end = abs(now.delta) / (16 * abs(now.u_n) + std::numeric_limits<Real>::min());
      // As a lasting contact rotates, its effective mass may decrease by decades, and its period
      // with it.
      const Real pace = std::min(Real(1), Real(pow(first.delassus.nn / now.delassus.nn, Real(2) / 5)));
      const Real h = std::min(
          {pace * scale / Real(options_.contact_steps), std::max(to_end, scale / 1000000), end_time - r.t});
      const LooseState<Real> next = method_.step(rates, r.t, r.state, h);
      const GudgeonContact<Real> then = gudgeon_contact(m_, r.t + h, next);
      if (then.delta < 0 && then.u_n > 0) {
        const Real tau = bisect_length(
            [&](Real at) {
              return gudgeon_contact(m_, r.t + at, method_.step(rates, r.t, r.state, at)).delta < 0;
            },
            h);
        r.state = method_.step(rates, r.t, r.state, tau);
        r.t += tau;
        break;
      }
      r.state = next, r.t += h, now = then;
      if (r.t >= end_time || r.t - impact.t > options_.longest_contact * scale) {
        impact.duration = scale;
        r.open = impact;
        return false;
      }
    }
    const GudgeonContact<Real> last = gudgeon_contact(m_, r.t, r.state);
    impact.duration = r.t - impact.t;
    impact.v_n_plus = last.u_n, impact.v_t_plus = last.u_t;
    impact.impulse_n = r.state[4], impact.impulse_t = r.state[5];
    r.impacts.push_back(impact);
    return true;
  }

  LooseSliderCrank<Real> m_;
  OracleOptions<Real> options_;
  CooperVerner<Real> method_;
};

}  // namespace freeplay::reference

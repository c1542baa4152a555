// A journal in a bearing in the plane, of which one or both deviate from a circle. With the centre of the journal
// at d from that of the bearing, angles θ_b and θ_j of the bodies and deviations p_b and p_j of the support
// functions,
//
//     G(φ) = c + p_b(φ − θ_b) − p_j(φ − θ_j) − d·n(φ),    n = (cos φ, sin φ),  t = ẑ × n
//     g    = least G over a grid of directions, improved between the neighbours of the least
//     ġ    = −n·ḋ − p_b′ ω_b + p_j′ ω_j                 = N v
//     v_T  = t·ḋ + (R_b − c + p_j) ω_j − (R_b + p_b) ω_b    = T v
//
// the distance of both tangents with the normal n, and the velocities of the points that they touch. Flights are
// closed forms. An impact has N v⁺ = −e N v⁻ and Coulomb's impulse, v⁺ = v⁻ + M⁻¹(Nᵀ P_N + Tᵀ P_T), |P_T| ≤ μ P_N
// with T v⁺ = 0 or opposite to T v⁺. A contact that lasts has N v̇ + Ṅ v = 0, with slip (λ_T = ∓μ λ_N) or without
// (T v̇ + Ṫ v = 0); Ṅ v and Ṫ v are central differences. A compliant contact pushes with
//
//     λ_N = K δ^(3/2) max(0, 1 + χ δ̇/v₀),    λ_T = −λ_N μ clamp((|v_T| − v₁)/(v₂ − v₁), 0, 1) sign v_T
//
// δ = −g, v₀ the approach at the onset, with the χ that delivers e. Events are bisected; contacts are integrated
// by the classical Runge–Kutta method. The motion is unknown from a compliant contact that is compressed again or
// touches in two places, and from a rigid contact in two places that lasts.
// Bodies without an inverse mass or inertia keep their velocity or spin. No solver of the program is included.
// Units: m, s, kg, rad, N.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "verification/references/delivered_restitution.hpp"
#include "verification/references/numerics.hpp"
#include "verification/references/one_coordinate.hpp"
#include "verification/references/planar.hpp"
#include "verification/references/surface_deviation.hpp"

namespace freeplay::reference {

class ProfiledJournal {
 public:
  using Point = Planar<double>;
  using Six = std::array<double, 6>;  ///< x, y, θ of the bearing's body, then of the journal's
  struct State {
    double t = 0;
    Six q{}, v{};
  };

  SurfaceDeviation bearing, journal;       ///< p_b, p_j
  double clearance = 0, radius = 0;        ///< m, c and R_b
  std::array<Point, 2> arms{};             ///< m, centres of bearing and journal in their bodies
  Six inverse{};                           ///< 1/kg and 1/(kg m²)
  State start;                             ///< at t = 0
  Point gravity{0, 0};                     ///< m/s², of bodies with an inverse mass
  double restitution = 1, friction = 0;    ///< e, μ
  double stiffness = 0;                    ///< K, N/m^(3/2); 0: rigid
  double slow = 0, fast = 0;               ///< m/s, v₁ and v₂
  double step = 1e-3, step_inside = 1e-3;  ///< s; in a compliant contact
  double rest = 1e-9;  ///< m/s, an impact that rebounds more slowly ends in lasting contact
  static constexpr int directions = 240;   ///< of the grid
  static constexpr int most_events = 300;  ///< the motion is unknown from there on

  /// Changes the start of the journal, the gravity and all spins.
  ProfiledJournal under(const Change& c) const {
    auto one = *this;
    one.step *= c.fine, one.step_inside *= c.fine;
    one.start.q[3] += c.x, one.start.q[4] += 0.7 * c.x;
    one.start.v[3] += c.v, one.start.v[4] -= 0.6 * c.v;
    one.gravity = (1 + c.load) * one.gravity;
    for (const std::size_t i : {2, 5}) one.start.v[i] *= 1 + c.load;
    return one;
  }

  struct Rows {
    std::vector<State> states;   ///< one for each instant that is known
    std::vector<double> onsets;  ///< s
    int events = 0;              ///< onsets, separations and changes of slip
    bool lasting = false;        ///< whether a rigid contact lasted
  };

  Rows rows(const std::vector<double>& instants, long most_steps = 200'000) const {
    auto one = *this;
    one.tabulate();
    return one.march(instants, most_steps);
  }

  /// A gap with its rows.
  struct Place {
    double gap = 0, phi = 0;
    double second = 0;  ///< m, least G of the grid at a minimum elsewhere
    Six normal{}, tangent{};
  };
  /// Needs tabulate().
  Place place(const Six& q) const {
    const Point rb = turned(arms[0], q[2]), rj = turned(arms[1], q[5]);
    const Point d = Point{q[3], q[4]} + rj - Point{q[0], q[1]} - rb;
    const double frame = on_journal() ? q[5] : q[2];
    const Point local = turned(d, -frame);
    static thread_local std::array<double, directions> grid;
    for (std::size_t k = 0; k < directions; ++k) grid[k] = table_[k] - dot(local, along_[k]);
    if (!bearing.is_zero() && !journal.is_zero())
      for (std::size_t k = 0; k < directions; ++k) grid[k] -= journal.at(angle_of(k) + q[2] - q[5]).p;
    const auto least = static_cast<std::size_t>(std::min_element(grid.begin(), grid.end()) - grid.begin());
    Place x;
    x.second = INFINITY;
    for (std::size_t k = 0; k < directions; ++k) {
      const double before = grid[(k + directions - 1) % directions], next = grid[(k + 1) % directions];
      if (k != least && grid[k] < before && grid[k] <= next) x.second = std::min(x.second, grid[k]);
    }
    // Newton's method for G′ = 0 between the neighbours, halving where it would leave them.
    double low = frame + angle_of(least) - spacing, high = low + 2 * spacing, phi = low + spacing;
    SurfaceDeviation::Value b, j;
    Point n, t;
    for (int i = 0; i < 100; ++i) {
      n = direction(phi), t = quarter_turn(n);
      b = bearing.at(phi - q[2]), j = journal.at(phi - q[5]);
      const double slope = b.slope - j.slope - dot(d, t), bend = b.bend - j.bend + dot(d, n);
      (slope < 0 ? low : high) = phi;
      double next = bend > 0 ? phi - slope / bend : low;
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (std::abs(next - phi) < 4e-16 * (1 + std::abs(phi))) break;
      phi = next;
    }
    x.phi = phi;
    x.gap = clearance + b.p - j.p - dot(d, n);
    x.normal = {n.x, n.y, cross(rb, n) - b.slope, -n.x, -n.y, j.slope - cross(rj, n)};
    x.tangent = {-t.x, -t.y, -cross(rb, t) - radius - b.p, t.x, t.y, cross(rj, t) + radius - clearance + j.p};
    return x;
  }
  /// Tables of the grid; of rows() itself.
  void tabulate() {
    table_.resize(directions), along_.resize(directions);
    for (std::size_t k = 0; k < directions; ++k) {
      along_[k] = direction(angle_of(k));
      table_[k] = clearance + (on_journal() ? -journal.at(angle_of(k)).p : bearing.at(angle_of(k)).p);
    }
  }

  static double times(const Six& a, const Six& b) {
    double sum = 0;
    for (std::size_t i = 0; i < 6; ++i) sum += a[i] * b[i];
    return sum;
  }

 private:
  static constexpr double spacing = 6.283185307179586 / directions;
  static double angle_of(std::size_t k) { return spacing * static_cast<double>(k); }
  static Point turned(const Point& p, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * p.x - s * p.y, s * p.x + c * p.y};
  }
  /// The grid turns with the only surface that deviates, or with the bearing.
  bool on_journal() const { return bearing.is_zero() && !journal.is_zero(); }

  std::vector<double> table_;
  std::vector<Point> along_;

  struct Contact {
    bool held = false;    ///< a rigid contact that lasts
    int slips = 0;        ///< sign of v_T; 0: rolls
    bool inside = false;  ///< in a compliant contact
    bool eased = false, unknown = false;
    double v0 = 0, chi = 0;
  };

  Six scaled(const Six& row) const {
    Six y;
    for (std::size_t i = 0; i < 6; ++i) y[i] = inverse[i] * row[i];
    return y;
  }
  static void add(Six& y, double factor, const Six& x) {
    for (std::size_t i = 0; i < 6; ++i) y[i] += factor * x[i];
  }
  static State moved(const State& s, double h, const Six& q_rate, const Six& v_rate) {
    State y = s;
    y.t += h;
    add(y.q, h, q_rate), add(y.v, h, v_rate);
    return y;
  }
  Six fall() const {
    Six a{};
    for (const std::size_t i : {0, 3})
      if (inverse[i] > 0) a[i] = gravity.x, a[i + 1] = gravity.y;
    return a;
  }

  // Rigid contacts.

  /// Forces or impulses of a contact whose normal and tangential velocities or accelerations change by un and ut.
  struct Push {
    double normal = 0, tangent = 0;
  };
  struct Compliances {
    double nn, nt, tt;
  };
  Compliances compliances(const Place& x) const {
    const auto n = scaled(x.normal), t = scaled(x.tangent);
    return {times(x.normal, n), times(x.tangent, n), times(x.tangent, t)};
  }
  static Push rolling(const Compliances& d, double un, double ut) {
    const double det = d.nn * d.tt - d.nt * d.nt;
    return {(d.tt * un - d.nt * ut) / det, (d.nn * ut - d.nt * un) / det};
  }
  Push slipping(const Compliances& d, double un, int sign) const {
    const double normal = un / (d.nn - friction * sign * d.nt);
    return {normal, -friction * sign * normal};
  }
  void push(Six& v, const Place& x, const Push& p) const {
    add(v, p.normal, scaled(x.normal)), add(v, p.tangent, scaled(x.tangent));
  }
  void impact(State& s) const {
    const auto x = place(s.q);
    const auto d = compliances(x);
    const double un = -(1 + restitution) * times(x.normal, s.v);
    auto p = slipping(d, un, 0);
    if (friction > 0) {
      p = rolling(d, un, -times(x.tangent, s.v));
      if (!(std::abs(p.tangent) <= friction * p.normal)) p = slipping(d, un, p.tangent > 0 ? -1 : 1);
    }
    push(s.v, x, p);
  }
  /// Force of a contact that lasts, with slip in the direction of `slips`, or rolling.
  Push lasting(const State& s, int slips) const {
    const auto x = place(s.q);
    double fastest = 0;
    for (std::size_t i = 0; i < 6; ++i)
      fastest = std::max(fastest, std::abs(s.v[i]) / (i % 3 == 2 ? 1 : clearance));
    const double h = fastest > 0 ? 1e-5 / fastest : 0;
    const auto before = place(moved(s, -h, s.v, {}).q), behind = place(moved(s, h, s.v, {}).q);
    const auto f = fall();
    double an = times(x.normal, f), at = times(x.tangent, f);
    if (h > 0) {
      an += (times(behind.normal, s.v) - times(before.normal, s.v)) / (2 * h);
      at += (times(behind.tangent, s.v) - times(before.tangent, s.v)) / (2 * h);
    }
    const auto d = compliances(x);
    return friction > 0 && slips == 0 ? rolling(d, -an, -at) : slipping(d, -an, slips);
  }
  /// Begins or ends slip where v_T is zero or a contact begins to last.
  void choose_slip(const State& s, Contact& in) const {
    in.slips = 0;
    if (friction == 0) return;
    const double slip = times(place(s.q).tangent, s.v);
    if (std::abs(slip) > rest) {
      in.slips = slip > 0 ? 1 : -1;
      return;
    }
    const auto p = lasting(s, 0);
    if (std::abs(p.tangent) > friction * p.normal) in.slips = p.tangent > 0 ? -1 : 1;
  }
  /// Removes the rounding and truncation of the gap.
  void close(State& s) const {
    const auto x = place(s.q);
    add(s.q, -x.gap / compliances(x).nn, scaled(x.normal));
  }
  /// The same, and of velocities.
  void settle(State& s, const Contact& in) const {
    close(s);
    const auto x = place(s.q);
    const auto d = compliances(x);
    const double un = -times(x.normal, s.v);
    push(s.v, x, friction > 0 && in.slips == 0 ? rolling(d, un, -times(x.tangent, s.v)) : Push{un / d.nn, 0});
  }

  // Compliant contacts.

  Six pulled(const State& s, const Contact& in) const {
    auto a = fall();
    const auto x = place(s.q);
    const double depth = std::max(-x.gap, 0.0), slip = times(x.tangent, s.v);
    const double normal =
        stiffness * depth * std::sqrt(depth) * std::max(0.0, 1 - in.chi * times(x.normal, s.v) / in.v0);
    const double share = friction > 0 ? std::clamp((std::abs(slip) - slow) / (fast - slow), 0.0, 1.0) : 0;
    push(a, x, {normal, -normal * friction * share * (slip > 0 ? 1 : -1)});
    return a;
  }

  State after(const State& s, const Contact& in, double h) const {
    if (!in.held && !in.inside) {
      const auto f = fall();
      auto y = moved(s, h, s.v, f);
      add(y.q, 0.5 * h * h, f);
      return y;
    }
    const auto rate = [&](const State& x) {
      if (in.inside) return pulled(x, in);
      auto a = fall();
      push(a, place(x.q), lasting(x, in.slips));
      return a;
    };
    const auto k1 = rate(s);
    const auto s2 = moved(s, 0.5 * h, s.v, k1);
    const auto k2 = rate(s2);
    const auto s3 = moved(s, 0.5 * h, s2.v, k2);
    const auto k3 = rate(s3);
    const auto s4 = moved(s, h, s3.v, k3);
    const auto k4 = rate(s4);
    State y = s;
    y.t += h;
    for (std::size_t i = 0; i < 6; ++i) {
      y.q[i] += h / 6 * (s.v[i] + 2 * s2.v[i] + 2 * s3.v[i] + s4.v[i]);
      y.v[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
    return y;
  }

  /// What ends the present phase at a state.
  enum class What { none, onset, separation, slip };
  What ends(const State& s, const Contact& in) const {
    if (in.held) {
      const auto p = lasting(s, in.slips);
      if (p.normal < 0) return What::separation;
      if (friction == 0) return What::none;
      if (in.slips == 0) return std::abs(p.tangent) > friction * p.normal ? What::slip : What::none;
      // Beyond rounding, so that slip that begins does not end at once.
      return in.slips * times(place(s.q).tangent, s.v) < -1e-3 * rest ? What::slip : What::none;
    }
    const auto x = place(s.q);
    if (in.inside) return x.gap > 0 ? What::separation : What::none;
    return x.gap < -1e-12 * clearance && times(x.normal, s.v) < 0 ? What::onset : What::none;
  }
  /// m, gap of a second place below which the motion is unknown; in lasting contact more than passes in a step.
  double apart(const Contact& in) const { return in.held ? 0.02 * clearance : 0; }
  double rate(const State& s) const { return times(place(s.q).normal, s.v); }

  Rows march(const std::vector<double>& instants, long most_steps) const {
    Rows list;
    auto s = start;
    Contact in;
    for (const double until : instants) {
      while (s.t < until) {
        if (--most_steps < 0) return list;
        advance(s, in, std::min(in.inside ? step_inside : step, until - s.t), list);
        if (in.unknown) return list;
        if (until - s.t <= 1e-15 * until) s.t = until;
      }
      list.states.push_back(s);
    }
    return list;
  }
  /// One step of h, or up to the first event in it.
  void advance(State& s, Contact& in, double h, Rows& list) const {
    const auto go = [&](double length) { return after(s, in, length); };
    auto next = go(h);
    if (ends(next, in) == What::none) {
      // Onset and separation within the step, nearly tangential.
      if (!in.held && !in.inside && rate(s) < 0 && rate(next) > 0) {
        double before = 0, behind = h;
        bisect(before, behind, 60, [&](double middle) { return rate(go(middle)) < 0; });
        if (ends(go(before), in) != What::none && before < h) return advance(s, in, before, list);
      }
      s = next;
      if (in.held) settle(s, in);
      if (in.held || in.inside) in.unknown = place(s.q).second < apart(in);
      if (!in.inside || in.chi == 0) return;
      in.eased = in.eased || rate(s) > 0;
      in.unknown = in.unknown || (in.eased && rate(s) < 0);
      return;
    }
    double before = 0, behind = h;
    bisect(before, behind, 60, [&](double middle) { return ends(go(middle), in) == What::none; });
    s = go(behind);
    in.unknown = ++list.events > most_events;
    const auto what = ends(s, in);
    if (what == What::separation) {
      if (in.held) settle(s, in);
      in = {};
    } else if (what == What::slip) {
      // v_T is zero to the rounding of the bisection.
      auto rolls = in;
      rolls.slips = 0;
      settle(s, rolls);
      choose_slip(s, in);
    } else {
      touch(s, in, list);
    }
  }
  void touch(State& s, Contact& in, Rows& list) const {
    list.onsets.push_back(s.t);
    const double approach = -rate(s);
    if (stiffness > 0) {
      in.unknown = approach < rest;
      in.inside = true, in.v0 = approach, in.chi = static_cast<double>(exact_chi(restitution));
      return;
    }
    impact(s);
    if (restitution * approach > rest) return;
    choose_slip(s, in);
    if (lasting(s, in.slips).normal <= 0) return close(s);  // else rounding might close it again at once
    in.held = list.lasting = true;
    settle(s, in);
    in.unknown = place(s.q).second < apart(in);
  }
};

}  // namespace freeplay::reference

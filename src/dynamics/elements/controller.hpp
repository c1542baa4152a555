// Dynamics of mechanism/elements/controller.hpp, which states the equations. The states of a
// controller are its integral z, if it has one, and then its lagging torque or force M.
//
// A sampled controller has more states, in this order:
//
//     number of the next instant; z; the last error e, with a derivative;
//     outputs that wait for the dead time, oldest first; the acting output, if the dead time is no
//     whole number of samples (else the oldest one acts); M
//
// All but M change at instants only, by sample(): the output of t_k is computed at t_k and takes effect
// at t_k + dead time. Instants are t_k = k h or, with a rest r of the dead time, alternately k h and k h + r.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "dynamics/sampling.hpp"
#include "mechanism/elements/controller.hpp"
#include "mechanism/piecewise.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

/// Both kinds of controller; Joint: the kind of joint that they drive.
template <class Facts, class Joint>
struct ControllerDynamics : Facts {
  static constexpr bool slides = std::is_same_v<Joint, TranslationalJoint>;
  Piecewise course = {};  ///< set by prepare(), as are the following
  Link sensed = {};       ///< of the joint that is fed back
  Vec2 axis{1, 0}, sensed_axis{1, 0};
  double error_scale = 1;  ///< rad or m
  int acting = 0;          ///< index of the acting output of a sampled controller

  void prepare(const auto& mechanism) {
    const auto& on = std::get<Joint>(mechanism.joints[this->joint]);
    const auto& by = std::get<Joint>(mechanism.joints[this->fed_back()]);
    course = Facts::course(mechanism);
    sensed = {by.between[0], by.between[1], by.at[0], by.at[1]};
    if constexpr (slides) {
      axis = on.axis;
      sensed_axis = by.axis;
    }
    std::vector<double> q(3 * mechanism.bodies.size()), v(q.size());
    for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
      const Vec2 at = mechanism.bodies[b].position.value_or(Vec2{});
      q[3 * b] = at.x();
      q[3 * b + 1] = at.y();
      q[3 * b + 2] = mechanism.bodies[b].angle.value_or(0);
    }
    const double from = course.value(0.0);
    error_scale = std::max(course.greatest().value, std::abs(from - state(q.data(), v.data()).place));
    if (!(error_scale > 0)) error_scale = slides ? 1e-3 : 1;
    if (sampled()) acting = rest() > 0 ? outputs() + whole() + 1 : outputs();
  }
  auto link(auto& b) const { return b.joint_link(this->joint); }
  bool does_work() const { return true; }
  bool sampled() const { return this->sampling_time.has_value(); }
  bool needs_velocity() const { return !sampled() && this->derivative > 0; }
  int states() const {
    if (sampled()) return outputs() + whole() + 1 + (rest() > 0) + this->lag.has_value();
    return (this->integral > 0) + this->lag.has_value();
  }
  /// Scale of errors of a state: the values of z and M at the error scale.
  double state_scale(int k) const {
    if (sampled()) {
      if (k-- == 0) return 1;
      if (this->derivative > 0 && k == (this->integral > 0)) return error_scale;
    }
    if (k == 0 && this->integral > 0) return error_scale * this->proportional / this->integral;
    const double most = this->proportional * error_scale;
    return this->limit ? std::min(*this->limit, most) : most;
  }
  /// A sampled controller reads its target at instants only.
  double next_knot(double t) const { return sampled() ? INFINITY : course.next_knot(t); }
  std::optional<CurveReader> reader(const Link& link) const {
    if (sampled()) return {};
    return reader_of(this->name, course, Argument::time, link);
  }

  /// See System; only if sampled().
  double next_sample(double t, const double* z) const { return instant(next_number(t, z)); }
  bool sample(double t, const double* q, const double* v, double* z) const {
    bool taken = false;
    for (double number = next_number(t, z); is_due(instant(number), t); z[0] = ++number, taken = true) {
      if (is_sample(number))
        compute(instant(number), q, v, z);
      else
        z[acting] = z[outputs()];
    }
    return taken;
  }

  int limiters() const { return !sampled() && this->limit.has_value(); }
  Saturation saturation(const auto& m, const Link&, const double* z) const {
    const auto now = state(m.q, m.v);
    const auto goal = course.jet(m.t);
    double terms = this->proportional * (std::abs(goal.value) + std::abs(now.place)) +
                   this->derivative * (std::abs(goal.slope) + std::abs(now.rate));
    if (this->integral > 0) terms += this->integral * std::abs(*z);
    return {demand<double>(m, z).u / *this->limit, terms / *this->limit};
  }
  template <class T>
  void flow(const auto& m, const T* z, T* dz) const {
    if (sampled()) {
      std::fill_n(dz, states(), T(0));
      if (this->lag) dz[states() - 1] = (z[acting] - z[states() - 1]) / *this->lag;
      return;
    }
    const auto d = demand<T>(m, z);
    const T held = saturated(d.u);
    if (this->integral > 0) {
      *dz = d.error;
      if (this->limit) *dz -= (d.u - held) / (this->integral * this->tracking());
      ++dz, ++z;
    }
    if (this->lag) *dz = (held - *z) / *this->lag;
  }
  /// `z` is nullptr without a state.
  template <class T>
  void act(const auto& m, const auto& link, const T* z, auto& out) const {
    const T effort = this->lag ? z[states() - 1] : sampled() ? z[acting] : saturated(demand<T>(m, z).u);
    if constexpr (slides) {
      const AlongAxis<T> on(link, axis, m.q, m.e);
      out.pull(link, on.arms, Vec2Of<T>{effort * on.axis.x(), effort * on.axis.y()});
      out.power.drive += effort * on.rate(link, m.v);
    } else {
      out.couple(link, effort);
      out.power.drive += effort * m.spin(link);
    }
  }

 private:
  template <class T>
  struct Place {
    T place = 0, rate = 0;
  };
  template <class T>
  struct Demand {
    T error = 0, u = 0;
  };

  /// Index of the first output of a sampled controller.
  int outputs() const { return 1 + (this->integral > 0) + (this->derivative > 0); }
  int whole() const { return this->delay().first; }
  double rest() const { return this->delay().second; }
  /// Whether the controller computes at the instant of this number; else an output takes effect there.
  bool is_sample(double number) const { return !(rest() > 0) || std::fmod(number, 2) == 0; }
  double instant(double number) const {
    if (!(rest() > 0)) return number * *this->sampling_time;
    const double sample = std::floor(number / 2) * *this->sampling_time;
    return is_sample(number) ? sample : sample + rest();
  }
  bool has_begun(const double* z) const { return z[0] > 0.5; }
  /// That of z (which integrators may round) or, at the beginning, that of the first sample from t on. A run
  /// begins with z = 0, or with the end of another run and another time: then z belongs to an instant far away.
  double next_number(double t, const double* z) const {
    const double h = *this->sampling_time, number = std::round(z[0]);
    if (has_begun(z) && std::abs(instant(number) - t) < 1.5 * h) return number;
    const double samples = std::max(0.0, t / h);
    return std::ceil(samples - 1e-12 * std::max(1.0, samples)) * (rest() > 0 ? 2 : 1);
  }
  void compute(double t, const double* q, const double* v, double* z) const {
    const double h = *this->sampling_time, place = state(q, v).place;
    const double seen = this->resolution ? *this->resolution * std::round(place / *this->resolution) : place;
    const double error = course.value(t) - seen;
    double u = this->proportional * error, *next = z + 1;
    double* const sum = this->integral > 0 ? next++ : nullptr;
    if (sum) u += this->integral * *sum;
    if (this->derivative > 0) {
      if (has_begun(z)) u += this->derivative * (error - *next) / h;
      *next++ = error;
    }
    const double held = saturated(u);
    if (sum) *sum += h * (error - (this->limit ? (u - held) / (this->integral * this->tracking()) : 0));
    std::copy(next + 1, next + whole() + 1, next);
    next[whole()] = held;
  }
  template <class T>
  T saturated(const T& u) const {
    return this->limit ? limited(u, *this->limit) : u;
  }
  /// s and ṡ = a·ḋ + ω_i perp a·d of the joint that is fed back. (flow() has no placed bodies.)
  template <class T>
  Place<T> state(const T* q, const T* v) const {
    if constexpr (!slides) {
      return {theta(q, sensed.j) - theta(q, sensed.i), omega(v, sensed.j) - omega(v, sensed.i)};
    } else {
      using std::cos, std::sin;
      const auto turned = [&](int body, const Vec2& s) -> Vec2Of<T> {
        if (body == ground || s.is_zero()) return {T(s.x()), T(s.y())};
        const T c = cos(q[3 * body + 2]), n = sin(q[3 * body + 2]);
        return {c * s.x() - n * s.y(), n * s.x() + c * s.y()};
      };
      Arms<T> a{turned(sensed.i, sensed.si), turned(sensed.j, sensed.sj), {T(0), T(0)}};
      a.d = {a.rj.x() - a.ri.x(), a.rj.y() - a.ri.y()};
      if (sensed.i != ground) a.d -= Vec2Of<T>{q[3 * sensed.i], q[3 * sensed.i + 1]};
      if (sensed.j != ground) a.d += Vec2Of<T>{q[3 * sensed.j], q[3 * sensed.j + 1]};
      const auto along = turned(sensed.i, sensed_axis);
      a.ri += a.d;
      return {dot(along, a.d), dot(along, freeplay::relative_velocity(sensed, a, v))};
    }
  }
  /// Over a time step, the means of the target and of its rate.
  template <class T>
  Demand<T> demand(const auto& m, const T* z) const {
    const auto now = state(m.q, m.v);
    Demand<T> d;
    Jet<T> goal;
    bool swept = false;
    if (const auto* s = m.reading.sweep) {
      const T from = m.t - 0.5 * s->h, to = m.t + 0.5 * s->h;
      goal.value = course.mean(from, to);
      goal.slope = (course.value(to) - course.value(from)) / s->h;
      swept = true;
    }
    if (!swept) goal = course.jet(m.t);
    d.error = goal.value - now.place;
    d.u = this->proportional * d.error;
    if (this->derivative > 0) d.u += this->derivative * (goal.slope - now.rate);
    if (this->integral > 0) d.u += this->integral * *z;
    return d;
  }
};

template <>
struct Dynamics<AngleController> : ControllerDynamics<AngleController, RevoluteJoint> {};
template <>
struct Dynamics<PositionController> : ControllerDynamics<PositionController, TranslationalJoint> {};

}  // namespace freeplay

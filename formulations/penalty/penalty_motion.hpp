// PenaltyMotion: the data of a step of the penalty formulation, on which the parts of PenaltyStepper
// operate: the mechanism in its present mode, the integration method with the ends of the last step,
// and every contact at these ends.
#pragma once

#include <algorithm>
#include <vector>

#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/kinks.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/penalty/dynamics.hpp"

namespace freeplay {

/// A contact at one state: its gap (m) with its rate, and the quantity that its friction's zone follows.
struct ContactSample {
  double gap = 0, rate = 0;
  double slide = 0;  // sliding speed, or load of a tangential spring that sticks
  template <class M>
  void serialize(M& m) {
    m(gap, rate, slide);
  }
};

struct ContactMark {
  ContactSample at;                            // end of the last step
  double impulse_n = 0, impulse_t = 0, t = 0;  // at contact onset
  template <class M>
  void serialize(M& m) {
    m(at, impulse_n, impulse_t, t);
  }
};

/// The end of a mode within a step.
struct PenaltyEvent {
  int contact = -1;
  // slide: the sliding speed reaches `boundary`; impact: an impact on a closed contact
  // begins or ends; clamp: its force reaches zero, or leaves it
  enum class Kind { gap, slide, impact, clamp } kind = Kind::gap;
  double t = 0, boundary = 0;
  Phases::Crossing crossing = {};  // or an angle reaches a kink of its table
  Limits::Crossing limit = {};     // or the demand of a controller its limit
  bool found() const { return contact >= 0 || crossing.phase >= 0 || limit.found(); }
};

template <class Method>
struct PenaltyMotion {
  PenaltyDynamics f;
  Method method;
  double v0_floor;
  std::vector<ContactMark> mark;
  std::vector<ContactSample> end;  // of the whole step, before it is shortened to an event
  /// Open contacts whose gap, its rate and its acceleration are zero up to rounding at the
  /// beginning of the step: bodies in contact without load. Rounding changes the sign of such a gap
  /// repeatedly; this is no contact event.
  std::vector<char> unloaded;
  bool restart = false;  // the mode has changed since the last evaluation of the right-hand side
  // components of the state on which a contact's gap and rates depend
  std::vector<std::vector<int>> seen;
  mutable Vector scratch;
  Vector slope, moving;

  PenaltyMotion(PenaltyDynamics dynamics, Method integrator, double least_v0)
      : f(std::move(dynamics)), method(std::move(integrator)), v0_floor(least_v0) {
    const auto contacts = static_cast<std::size_t>(f.system().contacts());
    mark.resize(contacts);
    end.resize(contacts);
    unloaded.resize(contacts);
    seen.resize(contacts);
    const int n = f.system().n();
    for (std::size_t k = 0; k < contacts; ++k) {
      for (const int body : f.system().contact_facts(static_cast<int>(k)).bodies)
        for (int c = 0; body != ground && c < planar::coordinates; ++c)
          for (const int at : {planar::first(body) + c, n + planar::first(body) + c}) seen[k].push_back(at);
      if (f.bristles()) seen[k].push_back(f.bristle_offset() + static_cast<int>(k));
    }
    for (auto* x : {&scratch, &slope, &moving}) x->resize(f.size());
  }

  template <class M>
  void serialize(M& m) {
    m(f, method, mark, restart);
  }

  const double* q() const { return method.x.data(); }
  const double* v() const { return method.x.data() + f.system().n(); }
  double crank() const { return f.system().crank_angle(q()); }
  const double* v_old() const { return method.x_old.data() + f.system().n(); }

  ContactSample sampled(int k, const ContactRow& row, const Vector& x) const {
    const double* v = x.data() + f.system().n();
    ContactSample s{row.gap, row.normal.dot(v), row.tangent.dot(v)};
    const auto& c = f.contacts()[k];
    if (c.shear && c.closed && c.zone == 0) [[unlikely]]
      s.slide = c.shear->load(c.normal_force(s.gap, s.rate), x[f.bristle_offset() + k]);
    return s;
  }
  ContactSample sample(int k, const Vector& x, double t) { return sampled(k, f.contact_rows.at(k, x, t), x); }
  /// At the present state, which place_end() has evaluated.
  ContactSample sample_end(int k) { return sampled(k, f.contact_rows.end(k, method.x), method.x); }
  ContactSample sample_at(int k, double t) {
    if (t >= method.t) return end[k];
    // With the two bodies of the contact only, because scenes of many contacts call this for each.
    if constexpr (Method::cubic) {
      method.hermite(t, seen[static_cast<std::size_t>(k)], scratch);
      return sampled(k, f.contact_rows.alone(k, scratch), scratch);
    }
    return sample(k, state_at(t), t);
  }
  /// The state at a time of the last step.
  const Vector& state_at(double t) {
    if (t >= method.t) return method.x;
    method.interpolate(t, scratch);
    return scratch;
  }
  /// Depth (m) below zero gap at which an unloaded contact closes. The force there is 1e-10 or less
  /// of that of an impact whose penetration is a thousandth of the clearance.
  double unloaded_gap(int k) const {
    return 1e-7 * f.system().contact_facts(k).clearance + 64 * gap_rounding(f.system(), k, q());
  }
  /// The value that is positive while the mode of contact k lasts.
  Watched watched(int k, const ContactSample& s) const {
    if (f.contacts()[k].closed) return {-s.gap, -s.rate};
    return {s.gap + (unloaded[k] ? unloaded_gap(k) : 0), s.rate};
  }
  /// w of a closed contact (see contact_law.hpp).
  double touch_speed(const PenaltyContact& c, const ContactSample& s) const {
    return c.law.touch_speed(std::max(0.0, -s.gap), -s.rate, c.mass);
  }
};

}  // namespace freeplay

// EventDynamics: a mechanism in a mode of the event-driven scheme. It combines the equations at one
// state (mode_equations.hpp) with
//
//   ModeMotion       dx/dt in the mode (mode_motion.hpp), and its derivative (event_jacobian.cpp),
//   ModeChoice       the mode after an event (mode_choice.hpp),
//   ImpactEquations  impulses of an impact (impact_equations.hpp),
//   ModeProjection   projection onto the constraints of the mode (below),
//
// which it owns, and accumulates the energies that impacts and projections dissipate.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formulations/event_driven/impact_equations.hpp"
#include "formulations/event_driven/mode_choice.hpp"
#include "formulations/event_driven/mode_equations.hpp"
#include "formulations/event_driven/mode_motion.hpp"
#include "formulations/probe.hpp"
#include "numerics/dual.hpp"

namespace freeplay {

/// ModeProjection: the least mass-weighted change that projects a state onto the constraints of its
/// mode,
///
///     positions:   G Δq = −Φ,           W_Nᵀ Δq = −g       (closed)
///     velocities:  G Δv = −(G v + Φ_t),  W_Nᵀ Δv = −W_Nᵀ v (closed),  W_Tᵀ Δv = −W_Tᵀ v (sticking)
class ModeProjection {
 public:
  /// Projects the positions of x, then its velocities; adds the impulses of the latter to
  /// `impulses`, if given. Returns the change of energy (J).
  double project(ModeEquations& d, std::vector<double>& x, double t, Forces* impulses);

 private:
  /// Owner of a row: a contact and which of its rows, or a joint with friction.
  struct Owner {
    int contact, friction;
    bool tangent;
  };
  /// Adds to y the least change Δ with G Δ = −residual and, for active rows, W Δ = −b.
  void move(ModeEquations& d, double* y);
  void hold_positions(ModeEquations& d, const double* q, const double* v);
  void hold_velocities(ModeEquations& d, const double* q, const double* v);
  void enter(ModeEquations& d, const double* q, const double* v, Forces& impulses) const;

  std::vector<double> residual_, change_;
  std::vector<Owner> owners_;
};

class SystemTangent;

class EventDynamics : public ModeEquations {
 public:
  using Present = EventDynamics;
  /// film_loss: only if there are films.
  enum Integral { drive, load, damping, friction_loss, integrals, film_loss = integrals };

  EventDynamics(const System& system, const NonsmoothOptions& options, const std::vector<double>& restitution,
                RowFacts facts, double speed_scale);

  int size() const { return integral_offset() + integrals + films.any(); }

  /// dx/dt in the present mode.
  void operator()(const Vector& x, Vector& dxdt, double t) { rate(x, dxdt, t, true); }
  /// ∂(dx/dt)/∂x (column-major, size() × size()) and ∂(dx/dt)/∂t in the present mode.
  void jacobian(const Vector& x, double t, double* J, double* dfdt);
  /// Derivatives of dx/dt in the present mode along `directions` of x, at constant t. Returns dx/dt.
  const Vector& directional(const Vector& x, double t, std::span<const Vector> directions,
                            std::span<Vector> out);
  /// From now on the derivatives are those of these traced equations (dynamics/system_tangent.hpp), and
  /// include those by their parameters.
  void use_tangent(std::shared_ptr<SystemTangent> traced);
  /// Whether the derivatives of the last directional() along the c-th direction include those with respect to
  /// the c-th parameter of the SystemTangent.
  bool includes_parameter(std::size_t c) const;
  /// Allocates the work space of jacobian(), which otherwise does so at its first call.
  void reserve_jacobian();
  /// Forces and accelerations at x in the present mode.
  void report(const Vector& x, double t, Forces& out);
  /// g̈ of an open contact in the present mode.
  double gap_acceleration(int k, const Vector& x, double t);
  /// λ_N of contact k times its mobility, the acceleration of its gap by this force (m/s²), at the
  /// last evaluation of a mode.
  double pressure(int k) const { return contacts[k].lambda_n * contacts[k].mobility; }
  /// Bounds of the motion of a contact's gap within a step; x is the state at its end and of the
  /// last look().
  GapMotion gap_motion(int k, const MotionBounds& bounds, const Vector& x) const {
    return system.gap_motion(k, bounds, x.data(), e);
  }

  /// Determines the mode from the contacts that are closed without relative normal speed. Returns
  /// an empty text, or the reason of a failure.
  std::string choose(const Vector& x, double t, const std::vector<int>& candidates) {
    return choice_.choose(*this, motion_, x, t, candidates);
  }
  /// Whether, by the last choice of mode or the last evaluation, friction admits no force on a
  /// sliding contact, and whether this is proved (lockup_proved()).
  bool locked_up() const { return choice_.locked_up() || motion_.behind_pole(); }
  bool lockup_proved() const { return choice_.lockup_proved() || motion_.behind_pole(); }

  /// Adds the impulses of an impact to v and to the impulses and works in x. Returns an empty text,
  /// or the reason of a failure.
  std::string apply_impact(Vector& x, double t, const ImpactEquations::Impact& impact);
  const ImpactEquations& last_impact() const { return impact_; }
  void report_impact(const Vector& x, const std::vector<int>& in_impact, Forces& out) {
    impact_.report(*this, x, in_impact, out);
  }

  /// Projects x onto the constraints of the mode, first positions, then velocities, by the least
  /// mass-weighted change. Adds the impulses of the velocity change to `impulses`, if
  /// given.
  void project(Vector& x, double t, Forces* impulses = nullptr) {
    stabilisation += projection_.project(*this, x, t, impulses);
  }

  /// Makes a second object for the same scene, which can evaluate without changing the state of
  /// this one.
  std::unique_ptr<EventDynamics> twin() const;
  /// The same for a system of the same structure with another value of a parameter, whose surfaces
  /// give the restitution.
  std::unique_ptr<EventDynamics> twin_of(const System& displaced) const;
  /// Copies the mode of another object.
  void take_mode(const EventDynamics& other);
  /// Takes the mode at x from another scheme: of each contact and of each joint with friction, 0 open,
  /// 1 sticking, 2 and 3 sliding with a negative and a positive friction force.
  void take_mode(const Vector& x, std::span<const signed char> modes);

  double contact_loss = 0, stabilisation = 0;  ///< J

  template <class M>
  void serialize(M& m) {
    m.part("event dynamics");
    ModeEquations::serialize(m);
    m(contact_loss, stabilisation, counts.undecided, counts.wedged, counts.unresolved, choice_.modes_left(),
      impact_.modes_left());
  }

 private:
  /// operator(); `compiled`: by compiled functions if there are any. Otherwise `rows` has the active rows.
  void rate(const Vector& x, Vector& dxdt, double t, bool compiled);
  void begin_tangent(const Vector& x, double t);
  void differentiate(const Vector& x, double t, std::span<const Vector> directions,
                     std::span<const double> times, std::span<Vector> out);
  struct ActingContact;
  double faster(const ActingContact& p, const Vector& x, double slide) const;
  void respond(const Vector& x, int s, double* column);

  NonsmoothOptions options_;
  ModeMotion motion_;
  ModeChoice choice_;
  ImpactEquations impact_;
  ModeProjection projection_;
  struct Tangent;
  std::shared_ptr<Tangent> tangent_;  // the traced equations and work space of derivatives, made at first use
};

/// WatchedForces: forces of an event-driven run for observers.
class WatchedForces : public ForceProbe<EventDynamics> {
 public:
  /// Called before a step.
  void clear() {
    if (!watching_) return;
    before_.clear();
    within_.clear();
  }
  void clear_before() {
    if (watching_) before_.clear();
  }
  /// Forces at x in the mode of the last step, which lasts until the next step begins.
  void at(const EventDynamics& dynamics, const std::vector<double>& x, double t, Forces& out) {
    probe_->take_mode(dynamics);
    probe_->report(x, t, out);
  }
  /// Impulses of an impact, before it is accepted.
  void apply_impact(EventDynamics& dynamics, const std::vector<double>& x,
                    const std::vector<int>& in_impact) {
    if (watching_) dynamics.report_impact(x, in_impact, scratch_);
  }
  void keep_impact() {
    if (watching_) before_.add(1, scratch_);
  }
  /// Where the impulses of projections before a step and within it are accumulated; null without
  /// observers.
  Forces* impulses_before() { return watching_ ? &before_ : nullptr; }
  Forces* impulses_within() { return watching_ ? &within_ : nullptr; }
  /// Number of instants at which no forces were found.
  long unreported() const { return probe_ ? probe_->counts.unreported : 0; }
};

}  // namespace freeplay

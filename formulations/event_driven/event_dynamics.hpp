// A mechanism in a mode of the event-driven scheme: the equations (mode_equations.hpp) with all that is asked of them,
//
//   ModeMotion       dx/dt in the mode (mode_motion.hpp), and its derivative (event_jacobian.cpp),
//   ModeChoice       the mode that follows an event (mode_choice.hpp),
//   ImpactEquations  impulses of an impact (impact_equations.hpp),
//   ModeProjection   the way back onto what the mode holds (mode_projection.hpp),
//
// and the energies that impacts and projections take out.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formulations/event_driven/impact_equations.hpp"
#include "formulations/event_driven/mode_choice.hpp"
#include "formulations/event_driven/mode_equations.hpp"
#include "formulations/event_driven/mode_motion.hpp"
#include "formulations/event_driven/mode_projection.hpp"

namespace freeplay {

class EventDynamics : public ModeEquations {
 public:
  /// film_loss: only where there are films.
  enum Integral { drive, load, damping, friction_loss, integrals, film_loss = integrals };

  EventDynamics(const System& system, const NonsmoothOptions& options, const std::vector<double>& restitution,
                RowFacts facts, double speed_scale);

  int size() const { return integral_offset() + integrals + films.any(); }

  /// dx/dt of the present mode.
  void operator()(const Vector& x, Vector& dxdt, double t);
  /// ∂(dx/dt)/∂x of the present mode (column-major, size() × size()) and ∂(dx/dt)/∂t.
  void jacobian(const Vector& x, double t, double* J, double* dfdt);
  /// Makes what jacobian() works in, which it else makes when first called.
  void reserve_jacobian();
  /// Forces and accelerations at x in the present mode.
  void report(const Vector& x, double t, Forces& out);
  /// g̈ of an open contact in the present mode.
  double gap_acceleration(int k, const Vector& x, double t);
  /// λ_N of contact k as the acceleration of its gap that it makes (m/s²), at the last evaluation of a mode.
  double pressure(int k) const { return contacts[k].lambda_n * contacts[k].mobility; }
  /// How a contact's gap may bend within a step, x its end and the state of the last look().
  GapMotion gap_motion(int k, const MotionBounds& bounds, const Vector& x) const {
    return system.gap_motion(k, bounds, x.data(), e);
  }

  /// Chooses the mode from the contacts that touch without relative normal speed. An empty text, or why it cannot be chosen.
  std::string choose(const Vector& x, double t, const std::vector<int>& candidates) {
    return choice_.choose(*this, motion_, x, t, candidates);
  }
  /// Friction admits no force on what slides, by the last choice or the last evaluation; this is proved.
  bool jammed() const { return choice_.jammed() || motion_.behind_pole(); }
  bool jam_proved() const { return choice_.jam_proved() || motion_.behind_pole(); }
  double torn_back(const Vector& x, double t) { return ModeChoice::torn_back(*this, motion_, x, t); }

  /// Impulses of an impact, added to v and to the impulses and works in x. An empty text, or why there are none.
  std::string strike(Vector& x, double t, const ImpactEquations::Impact& impact);
  const ImpactEquations& last_impact() const { return impact_; }
  void report_impact(const Vector& x, const std::vector<int>& struck, Forces& out) {
    impact_.report(*this, x, struck, out);
  }

  /// Moves x onto the constraints of the mode, positions then velocities, by the least mass-weighted change; adds
  /// the impulses of the latter to `book`, if there is one.
  void project(Vector& x, double t, Forces* book = nullptr) {
    stabilisation += projection_.project(*this, x, t, book);
  }

  /// Another one of the same scene, to look without touching this one's memory.
  std::unique_ptr<EventDynamics> twin() const;
  /// Takes another's mode.
  void take_mode(const EventDynamics& other);

  double contact_loss = 0, stabilisation = 0;  ///< J

  template <class M>
  void remember(M& m) {
    m.part("event dynamics");
    ModeEquations::remember(m);
    m(contact_loss, stabilisation, counts.undecided, counts.wedged, choice_.modes_left(),
      impact_.modes_left());
  }

 private:
  NonsmoothOptions options_;
  ModeMotion motion_;
  ModeChoice choice_;
  ImpactEquations impact_;
  ModeProjection projection_;
  struct Tangent;  // of jacobian()
  std::shared_ptr<Tangent> tangent_;
};

}  // namespace freeplay

// PenaltyVariation: derivatives of a penalty motion (varied_columns.hpp). The integrated vector has v₀ and
// the mass of each contact as constant states (extended_penalty.hpp). At an event
//
//     h(x, t; p) = 0:     dt = −(h_x S⁻ + h_p)/ḣ⁻,     S⁺ = S⁻ + (f⁻ − f⁺) dt,
//
// where h is the gap at contact onset and separation. Most laws have no force at zero depth, so that f is
// continuous and S does not jump. v₀ = −ġ of an onset has the derivative of −ġ along (S⁻ + f⁻ dt, dt, p).
// Where v₀ changes during a contact, it is w (contact_law.hpp).
//
// S is integrated by Dormand and Prince's stages over each step of the run, in as many equal parts as
// repeat that step within its tolerance, whatever the integrator of the run, and to the instant at which
// a contact force reaches its clamp at zero. Near zero depth, where forces
// such as δ^(3/2) are not smooth, the times change with p as well, by dt = −(dg/dp)/ġ of the gap g:
//
//     Y = S + f dt,     Ẏ = f_x Y + f_t dt + f_p.
//
// The depth then has no derivative there, and Y is as smooth as the motion.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formulations/penalty/extended_penalty.hpp"
#include "formulations/penalty/penalty.hpp"
#include "formulations/variation/varied_columns.hpp"

namespace freeplay {

class PenaltyVariation : public VariedColumns<ExtendedPenalty> {
 public:
  /// `run`: after its start at the time t. Other arguments as for VariedColumns.
  PenaltyVariation(const PenaltyParts& run, const Scene& scene, const State& start,
                   const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
                   double duration);

  /// See Variation::trace().
  void trace(TracedEquations& traced, const State& near);
  /// Keeps the mode before a step.
  void begin_step();
  /// After a step: advances S, and carries it across the event at its end, if there is one.
  void end_step();
  /// Also leaves out the impulses of the present contacts.
  void forget_onsets() override {
    VariedColumns::forget_onsets();
    for (auto& impulse : impulses_) impulse.reset();
  }
  /// The vector at the end, with the retained data.
  Vector x() const { return with_retained(run_.dynamics()); }

 private:
  struct Impulse {
    std::size_t onset = 0;
    double begin = 0;
    Vector slope;  // of `begin`
  };
  Vector with_retained(const PenaltyDynamics& d) const;
  void begin(const Scene& scene, double t, bool resumed);
  int part_count(const Vector& x, double t, double h, const Vector& end);
  std::optional<double> clamp_within(const Vector& x, double t, double h, const Vector& end);
  void advance(Vector& x, double t, double h, int count);
  bool choose_shifts(const Vector& x, double t, double h);
  /// Adds `sign` times f dt at a state to S, and to the integrals.
  void shift(const Vector& x, double t, double sign);
  void cross_events();
  void cross_limits();
  EventMap event_at(const Vector& x, double t, Side before, Side after);
  /// dt of each column for a root of a function.
  void set_times(EventMap& e, const Function& value);
  void begin_contact(int k, const EventMap& e);
  void end_contact(int k, const EventMap& e);
  void retain(int k, const EventMap& e, double speed, const Function& speed_of, bool squared, bool new_mass);
  void change_impact(int k, EventMap& e, bool jumps);
  void jump(const EventMap& e);

  const PenaltySteps& run_;
  ErrorNorm norm_;
  double v0_floor_;
  bool floor_given_ = false;
  std::unique_ptr<ExtendedPenalty> after_;        // of the nominal system, in the mode after an event
  Vector retained_;                               // before the step
  std::vector<std::optional<Impulse>> impulses_;  // of the present contacts
};

}  // namespace freeplay

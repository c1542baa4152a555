// Interface of observers of a run. An observer receives the start, each accepted step with its
// dense output, each event, each sample of an instrument, and the end.
//
// Usage:
//
//     struct Peak final : Observer {
//       double speed = 0;
//       void event(const Event& e) override { speed = std::max(speed, -e.v_n_minus); }
//     } peak;
//     simulation.run({.observers = {&peak}});
//
// The caller owns its observers. Observation does not influence stepping: an observed run takes the
// same steps, bit for bit. Without observers nothing is recorded.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "values/event.hpp"
#include "values/forces.hpp"
#include "values/ledger.hpp"
#include "values/memory.hpp"
#include "values/state.hpp"

namespace freeplay {

/// Geometry of a contact at one state.
struct ContactPlace {
  /// m, from the first body's point to the second's, in the world: the eccentricity of a journal
  double ex = 0, ey = 0;
  double gap = 0;  ///< m
};

/// The names and counts that the values of a run refer to; constant during a run.
/// Simulation::restore may bring another start, and the first run with forces finds which reactions
/// are determined.
struct Layout {
  /// names, in the mechanism's order
  std::vector<std::string> bodies;
  std::vector<std::string> contacts;  ///< indexed by ContactEvent::contact
  /// Families of pairs without index; ContactEvent::contact numbers them after the contacts.
  std::vector<std::string> families;
  std::vector<std::string> channels;  ///< instruments, in the scene's order
  /// the elements whose forces a step reports
  std::vector<ForceElement> forces;
  double duration = 0;     ///< s, of the scene's run
  double end = 0;          ///< s, end of the present run (RunRequest::until)
  double output_step = 0;  ///< s, between the rows that the scene requests
  /// rad, rad/s, of the drive whose revolutions are counted; 0 without one
  double crank_start = 0, crank_speed = 0;
  std::vector<ContactPlace> start;  ///< of the contacts, at the start of the simulation
};

/// One accepted step, valid only during the call of the observer.
class Step {
 public:
  double t0 = 0, t1 = 0;  ///< s
  /// m/s, rad/s: velocities just after an impact or projection at t0, and at t1.
  std::span<const double> v0, v1;

  /// The state at a time within the step, from the method's dense output. Each span has length
  /// Layout::bodies × 3.
  virtual void state(double t, std::span<double> q, std::span<double> v) const = 0;
  /// First-order states at t1.
  virtual std::span<const double> z() const = 0;
  /// Multipliers of the constraint rows at t1 (N, N m). For a time step: its impulses divided by
  /// its length.
  virtual std::span<const double> multipliers() const = 0;
  /// Geometry of the contacts at a state, one entry for each of Layout::contacts.
  virtual void contacts(double t, std::span<const double> q, std::span<ContactPlace> out) const = 0;
  /// Energies at t1 and work since the start of the simulation (J).
  virtual EnergyLedger ledger() const = 0;
  /// Change of the velocities by impacts within a time step.
  virtual StepImpacts in_impact() const { return {t1, {}}; }
  /// Whether the run has been requested to stop; a long computation on one step should then end.
  virtual bool stopped() const = 0;
  /// Whether stopped() has returned true during this step. The step has then been processed only in
  /// part.
  virtual bool cut() const = 0;

  /// @name Forces, for observers that request them; else std::logic_error
  ///@{
  /// Forces at a time within the step, one for each of Layout::forces; resizes `out`. For a time
  /// step: the mean forces of the whole step without impacts.
  virtual void forces(double t, Forces& out) const = 0;
  /// Adds the impulses of these forces from a to b, t0 ≤ a ≤ b ≤ t1.
  virtual void add_impulse(double a, double b, Forces& sum) const = 0;
  /// Impulses at t0 before the step: impacts and projections.
  virtual const Forces& before() const = 0;
  /// Impulses without an instant within the step: its own impacts (time stepping), a projection at
  /// t1.
  virtual const Forces& within() const = 0;
  ///@}

 protected:
  ~Step() = default;
};

/// The end of a run, as observers see it.
struct RunEnd {
  /// how the run ended
  const Ending& ending;
  double t = 0;  ///< s, time reached
  /// Events that are held back because an earlier contact onset is not yet classified as an impact
  /// or a lasting contact.
  std::span<const ContactEvent> held_back;
  std::span<const double> undecided_since;  ///< s, onset of each unclassified contact; else NaN
};

/// Data that an observer requests besides the start, the events and the end.
struct Wants {
  bool forces = false;   ///< Step::forces and the functions that follow it
  bool samples = false;  ///< samples of the instruments
  /// the accepted steps
  bool steps = true;
};

/// Base class of observers; each function does nothing unless it is overridden.
class Observer {
 public:
  virtual ~Observer() = default;
  /// The data that it requests during a run.
  virtual Wants wants() const { return {}; }
  /// Called before the first step of a run, also of a run that continues an earlier one.
  virtual void begin(const Layout&, const State&) {}
  /// Each accepted step, valid only during the call.
  virtual void step(const Step&) {}
  /// Final events in the order of t, before the step in which they become final.
  virtual void event(const Event&) {}
  /// `channel`: index into Layout::channels.
  virtual void sample(std::size_t channel, double t, double value) { (void)channel, (void)t, (void)value; }
  /// The end of a run, also of a failed or an interrupted one.
  virtual void end(const RunEnd&) {}
  /// @name State of the observer, for runs that are interrupted and resumed
  ///@{
  /// Writes its state into a snapshot of the run.
  virtual void save(MemoryWriter&) {}
  /// Reads its state; throws MemoryError if it does not match.
  virtual void load(MemoryReader&) {}
  ///@}
};

// Interface of observers that need few of the steps, such as those of rows of a table. Where all
// observers of a run have it, the steps that none of them needs can be made without showing them
// (formulations/time_stepping/lanes.hpp).

/// Second base of such observers.
class Occasional {
 public:
  /// Time (s) up to which steps change nothing for it, except the last one before it. Asked after
  /// begin(), and after each step that it has seen. Infinite: it needs no further steps.
  virtual double next() const = 0;

 protected:
  ~Occasional() = default;
};

}  // namespace freeplay

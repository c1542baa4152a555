// Who watches a run. An observer is shown the start, each accepted step with what lies within it, each event and
// each sample of an instrument, and the end. Watching is not stepping: a run that is watched takes the steps of
// one that is not, bit for bit, and one that nobody watches records nothing.
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

/// A contact at one state.
struct ContactPlace {
  double ex = 0, ey = 0;  ///< m, from the first body's point to the second's, world: a journal's eccentricity
  double gap = 0;         ///< m
};

/// What a run's numbers belong to; constant during a run. Simulation::restore may bring another start, the
/// first run with forces finds which are determined.
struct Layout {
  std::vector<std::string> bodies;
  std::vector<std::string> contacts;  ///< of ContactEvent::contact
  std::vector<std::string>
      families;  ///< of pairs that have no number; of ContactEvent::contact behind the contacts
  std::vector<std::string> channels;  ///< instruments, in the scene's order
  std::vector<ForceElement> forces;
  double duration = 0;                      ///< s, of the scene's run
  double end = 0;                           ///< s, where the present run ends (RunRequest::until)
  double output_step = 0;                   ///< s, between the rows that the scene asks for
  double crank_start = 0, crank_speed = 0;  ///< rad, rad/s: of the drive that counts turns; 0 without one
  std::vector<ContactPlace> start;          ///< of the contacts, where the simulation began
};

/// One accepted step, valid while the observer is called.
class Step {
 public:
  double t0 = 0, t1 = 0;  ///< s
  /// m/s, rad/s: just after what happened at t0 (an impact, a projection), and at t1.
  std::span<const double> v0, v1;

  /// The state at a time within the step, by the method's dense output; each of length Layout::bodies × 3.
  virtual void state(double t, std::span<double> q, std::span<double> v) const = 0;
  /// First-order states at t1.
  virtual std::span<const double> z() const = 0;
  /// Multipliers of the constraint rows at t1 (N, N m; of a time step its impulses over its length).
  virtual std::span<const double> multipliers() const = 0;
  /// Where the contacts are at a state, one of Layout::contacts each.
  virtual void contacts(double t, std::span<const double> q, std::span<ContactPlace> out) const = 0;
  virtual EnergyLedger ledger() const = 0;
  virtual Struck struck() const { return {t1, {}}; }
  /// Whether the run has been asked to stop: long work on one step should end.
  virtual bool stopped() const = 0;
  /// Whether stopped() has told anyone so during this step: then not all of it has been seen.
  virtual bool cut() const = 0;

  /// @name Forces, for observers that want them; std::logic_error where none does
  ///@{
  /// Those at a time within the step, one of Layout::forces each; `out` is given its shape. Of a time step
  /// those of the whole step, impacts left out.
  virtual void forces(double t, Forces& out) const = 0;
  /// Adds the impulses of these from a to b, t0 ≤ a ≤ b ≤ t1.
  virtual void add_impulse(double a, double b, Forces& sum) const = 0;
  /// Impulses at t0 before the step began: impacts and projections.
  virtual const Forces& before() const = 0;
  /// Impulses that belong to no instant within the step: its own impacts (time stepping), a projection at t1.
  virtual const Forces& within() const = 0;
  ///@}

 protected:
  ~Step() = default;
};

/// How a run ended, for observers.
struct RunEnd {
  const Ending& ending;
  double t = 0;  ///< s, reached
  /// Events that a touch before them holds back, which is not yet known to be an impact or a lasting contact.
  std::span<const ContactEvent> held_back;
  std::span<const double> undecided_since;  ///< s, first touch of each contact that is undecided, else NaN
};

/// What an observer asks to be shown besides the beginning, the events and the end.
struct Wants {
  bool forces = false;   ///< in its steps: Step::forces and what follows
  bool samples = false;  ///< of the instruments
  bool steps = true;
};

class Observer {
 public:
  virtual ~Observer() = default;
  virtual Wants wants() const { return {}; }
  /// Before the first step of a run, also of one that goes on from an earlier run.
  virtual void begin(const Layout&, const State&) {}
  virtual void step(const Step&) {}
  /// Settled events, in the order of t, before the step that settled them.
  virtual void event(const Event&) {}
  /// `channel`: index into Layout::channels.
  virtual void sample(std::size_t channel, double t, double value) { (void)channel, (void)t, (void)value; }
  virtual void end(const RunEnd&) {}
  /// @name Its own memory, for runs that are interrupted and resumed
  ///@{
  virtual void save(MemoryWriter&) {}
  virtual void load(MemoryReader&) {}
  ///@}
};

}  // namespace freeplay

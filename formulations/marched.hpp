// Marched<Stepper>: the part of the Formulation interface that all formulations share. It owns the
// stepper and the contact log, runs the stepper with March, keeps the energy ledger and
// serializes both for snapshots. Subclasses add the contact models and the notes to the user.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/integrators/crossing.hpp"
#include "simulation/formulation.hpp"
#include "simulation/march.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {

/// Adds a note if contacts could not be excluded within steps; `unseen` is their possible depth, in
/// clearances.
inline void unseen_note(double unseen, std::vector<std::string>& notes) {
  if (unseen > seen_depth) notes.push_back(diagnostic<Diagnostic::missed_contact>(unseen));
}

/// A Stepper provides the functions that March uses, and start(state, log), q(), work(),
/// extremes(), integrals() (the energy ledger without kinetic and gravitational energy) and
/// outside_work() (the work of drives and of loads). Each subclass defines its contact models and
/// its notes.
template <class Stepper>
class Marched : public Formulation {
 public:
  Marched(Family family, const System& system, const State& state, Stepper stepper)
      : system_(system),
        stepper_(std::move(stepper)),
        family_(family),
        log_(system.contacts(), system.reported()) {
    stepper_.start(state, log_);
    initial_ =
        system_.kinetic(state.v.data()) + system_.potential(state.q.data()) + stepper_.integrals().elastic;
  }
  Family family() const final { return family_; }
  using Steps = March<Marched, Stepper>;
  /// The loop of a run to t_end.
  Steps march(double t_end, Watch& watch) { return {*this, system_, stepper_, t_end, log_, watch}; }
  Ending finish(const Steps& steps, Watch& watch) {
    watch.drain(log_);
    return steps.ending();
  }
  Ending run(double t_end, Watch& watch) final {
    auto steps = march(t_end, watch);
    while (steps.step()) {
    }
    return finish(steps, watch);
  }
  /// For lanes, which make some steps in its place.
  Stepper& stepper() { return stepper_; }
  const System& system() const { return system_; }
  double& passed() { return passed_; }
  void save(MemoryWriter& m) final { serialize(m); }
  void load(MemoryReader& m) final { serialize(m); }
  State state() const final {
    const int n = system_.n();
    const double *q = stepper_.q(), *v = stepper_.v();
    return {stepper_.t(), {q, q + n}, {v, v + n}, {stepper_.z().begin(), stepper_.z().end()}};
  }
  EnergyLedger ledger() final {
    EnergyLedger l = stepper_.integrals();
    l.initial = initial_;
    l.passed = passed_;
    l.exchanged = exchanged_;
    l.kinetic = system_.kinetic(stepper_.v());
    l.potential = system_.potential(stepper_.q());
    return l;
  }
  /// Called after each step; see EnergyLedger::passed and exchanged.
  void keep_passed() {
    const auto [drive, load] = stepper_.outside_work();
    passed_ = std::max({passed_, system_.kinetic(stepper_.v()), std::abs(drive), std::abs(load)});
    exchanged_ += std::abs(drive - drive_) + std::abs(load - load_);
    drive_ = drive, load_ = load;
  }
  const Work& work() const final { return stepper_.work(); }
  const Extremes& extremes() const final { return stepper_.extremes(); }
  const ContactLog& log() const final { return log_; }

 protected:
  const System& system_;
  Stepper stepper_;

 private:
  template <class M>
  void serialize(M& m) {
    m.part(name_of(family_));
    m(stepper_, log_, initial_, passed_, exchanged_, drive_, load_);
  }
  Family family_;
  ContactLog log_;
  double initial_ = 0, passed_ = 0, exchanged_ = 0, drive_ = 0, load_ = 0;
};

}  // namespace freeplay

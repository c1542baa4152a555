// What a formulation is to the rest of the program: it advances a state and reports impulses, energies and
// work. Everything is decided when it is made; its stepping loop has no virtual call and, but for the
// event-driven scheme at its events and bulirsch_stoer within odeint, allocates nothing.
#pragma once

#include <string>
#include <vector>

#include "simulation/contact_log.hpp"
#include "values/family.hpp"
#include "values/ledger.hpp"
#include "values/memory.hpp"
#include "values/state.hpp"

namespace freeplay {

class Watch;

/// Below this share of its first value the least pivot of the constraint rows says that a singular position
/// was passed: (1e-3 rad)², where branches of the motion meet.
inline constexpr double singular_pivot = 1e-6;
inline constexpr const char* singular_note =
    "DOUBTFUL: the motion passed a singular position, where constraint rows depend on each other: it may "
    "have left its branch there";

class Formulation {
 public:
  virtual ~Formulation() = default;
  virtual Family family() const = 0;
  /// The stepping loop, from the present state to t_end.
  virtual Ending run(double t_end, Watch& watch) = 0;
  virtual State state() const = 0;
  /// At the present state, also during a run.
  virtual EnergyLedger ledger() = 0;
  virtual const Work& work() const = 0;
  virtual const Extremes& extremes() const = 0;
  virtual const ContactLog& log() const = 0;
  virtual std::vector<ContactModel> contact_models() const = 0;
  /// Sentences that a user must read: what was asked for outside its range, what was handled in a special
  /// way.
  virtual std::vector<std::string> notes() const = 0;
  /// All that its future depends on, between two steps.
  virtual void save(MemoryWriter& m) = 0;
  virtual void load(MemoryReader& m) = 0;
};

}  // namespace freeplay

// Interface of a formulation (penalty or nonsmooth): it advances a state in time and reports
// impulses, energies and work.
//
// formulations/make.hpp makes a formulation of a scene; Simulation owns it and calls run(). All
// choices are made at construction. The stepping loop has no virtual call. It does not allocate,
// except in the event-driven scheme at events and within odeint's bulirsch_stoer. A formulation
// owns its state, its energy ledger and its contact log; it refers to the scene and the System,
// which must outlive it.
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

/// Threshold of the least pivot of the constraint rows relative to its first value. Below it the
/// motion has passed a singular position, where branches of the motion meet: (1e-3 rad)².
inline constexpr double singular_pivot = 1e-6;

class Formulation {
 public:
  virtual ~Formulation() = default;
  virtual Family family() const = 0;
  /// Runs the stepping loop from the present state to t_end.
  virtual Ending run(double t_end, Watch& watch) = 0;
  virtual State state() const = 0;
  /// The energies at the present state; also valid during a run.
  virtual EnergyLedger ledger() = 0;
  virtual const Work& work() const = 0;
  virtual const Extremes& extremes() const = 0;
  virtual const ContactLog& log() const = 0;
  virtual std::vector<ContactModel> contact_models() const = 0;
  /// Messages for the user: requests outside their valid range, and cases handled in a special way.
  virtual std::vector<std::string> notes() const = 0;
  /// Saves and restores the complete state between two steps: everything that the further run
  /// depends on.
  virtual void save(MemoryWriter& m) = 0;
  virtual void load(MemoryReader& m) = 0;
};

}  // namespace freeplay

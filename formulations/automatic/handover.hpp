// Data that one nonsmooth scheme passes to another in the middle of a run.
#pragma once

#include <vector>

#include "values/ledger.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Handover {
  struct Contact {
    bool closed = false;  // closed in the last mode or step
    bool logged = false;  // the log has its onset, but not its separation
    // s, N s: onset and impulses that the log has so far
    double t_onset = 0, impulse_n = 0, impulse_t = 0;
  };
  State state;
  std::vector<Contact> contacts;
  EnergyLedger integrals;
  Extremes extremes;
  Work work;
};

}  // namespace freeplay

// What one nonsmooth scheme hands to another in the middle of a run.
#pragma once

#include <vector>

#include "values/ledger.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Handover {
  struct Contact {
    bool closed = false;                               // held to last
    bool logged = false;                               // its touch is in the log, its loss is not
    double t_touch = 0, impulse_n = 0, impulse_t = 0;  // s, N s: of what the log holds
  };
  State state;
  std::vector<Contact> contacts;
  EnergyLedger integrals;
  Extremes extremes;
  Work work;
};

}  // namespace freeplay

// What a reader of the results must know of an event-driven run's contacts: counted while it goes on, worded by notes().
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/system.hpp"

namespace freeplay {

struct EventFindings {
  /// Impacts that a rule other than the impact law decided.
  struct Exceptions {
    long count = 0;
    double energy = 0;  ///< J: the greatest that one lost
    void take(double lost) {
      ++count;
      energy = std::max(energy, lost);
    }
    template <class M>
    void remember(M& m) {
      m(count, energy);
    }
  };
  /// Contacts closed to rounding, without load and without approach, that took part in the first impact that has any.
  struct Unloaded {
    int count = 0, contact = -1;  ///< contact: one of them
    double t = 0, gap = 0;        ///< s, m: the greatest of them
    template <class M>
    void remember(M& m) {
      m(count, contact, t, gap);
    }
  };

  Exceptions lockups;    ///< friction admitted no finite force on what slid (Painlevé)
  Exceptions unsolved;   ///< no solver found forces that friction admits
  Exceptions inelastic;  ///< no impulses were found that keep the restitution of several contacts
  Unloaded unloaded;
  double merged = 0;        ///< m, the greatest gap of a contact in an impact of another
  double most_kinetic = 0;  ///< J, before any impact so far

  /// `rounding`: m, that the gaps are known to.
  void tell(const System& system, double rounding, std::vector<std::string>& notes) const;

  template <class M>
  void remember(M& m) {
    m(lockups, unsolved, inelastic, unloaded, merged, most_kinetic);
  }
};

}  // namespace freeplay

// EventFindings: diagnostics of an event-driven run's contacts for the reader of the results,
// counted during the run and turned into notes by add_notes().
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/system.hpp"

namespace freeplay {

struct EventFindings {
  /// Impacts decided by a rule other than the impact law.
  struct Exceptions {
    long count = 0;
    double energy = 0;  ///< J: the greatest energy lost in one
    void take(double lost) {
      ++count;
      energy = std::max(energy, lost);
    }
    template <class M>
    void serialize(M& m) {
      m(count, energy);
    }
  };
  /// Contacts closed to rounding, without load and without approach, that took part in an impact;
  /// only the first impact with such contacts.
  struct Unloaded {
    int count = 0, contact = -1;  ///< contact: one of them
    double t = 0, gap = 0;        ///< s, m: the greatest of their gaps
    template <class M>
    void serialize(M& m) {
      m(count, contact, t, gap);
    }
  };

  Exceptions lockups;    ///< friction admitted no finite force on a sliding contact (Painlevé)
  Exceptions unsolved;   ///< no solver found forces that friction admits
  Exceptions inelastic;  ///< no impulses with the restitution of several contacts were found
  Unloaded unloaded;
  /// m, the greatest gap of a contact that took part in an impact of another
  double merged = 0;
  double most_kinetic = 0;  ///< J, the greatest kinetic energy before an impact

  /// `rounding`: accuracy of the gaps (m).
  void add_notes(const System& system, double rounding, std::vector<std::string>& notes) const;

  template <class M>
  void serialize(M& m) {
    m(lockups, unsolved, inelastic, unloaded, merged, most_kinetic);
  }
};

}  // namespace freeplay

// PenaltyMode: what the force of a contact depends on besides the state (q, v, z). v₀ and the mass are
// retained from the onset of the contact or from the last impact on it
// (formulations/contact/contact_law.hpp).
#pragma once

namespace freeplay {

/// Data besides the state on which the force of a contact depends.
struct PenaltyMode {
  bool closed = false;
  int zone = 0;   ///< of the friction law, while closed
  double v0 = 1;  ///< m/s: δ̇ at the onset of the present contact, or w of its last impact
  /// an impact on the closed contact with a greater speed than v₀ is in progress: w takes the place
  /// of v₀ (see contact_law.hpp)
  bool in_impact = false;
  double mass = 1;  ///< kg, effective mass of that impact
  /// closed without an impact, or has expanded since its onset: a further compression is a new
  /// impact
  bool eased = false;

  template <class M>
  void serialize(M& m) {
    m(closed, zone, v0, in_impact, mass, eased);
  }
};

}  // namespace freeplay

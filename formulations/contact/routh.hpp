// Impact of a single contact, integrated along its normal impulse (Routh, Dynamics of a System of
// Rigid Bodies, 1905). By Poisson's law it ends when the impulse of expansion is e times the
// impulse of compression (Wang and Mason, J. Appl. Mech. 59 (1992) 635); by the energetic law, when
// the work of expansion is e² times the work of compression (Stronge).
#pragma once

#include "mechanism/options.hpp"

namespace freeplay {

struct RouthImpact {
  double impulse_n = 0, impulse_t = 0;  ///< N s
  /// J, of the impulses on the rates during the impact; negative: lost
  double normal_work = 0, tangential_work = 0;
  /// False if no impulse ends the approach: the only freedom of the contact cannot change its
  /// approach rate.
  bool ended = true;
};

/// D and the rates before the impact, of one contact; D_TT = 0 without friction. Both rows of D may
/// depend on one freedom (a lever on a stop): sliding then stops at the very end of compression.
RouthImpact routh_impact(ImpactLaw law, double Dnn, double Dnt, double Dtt, double u_n, double u_t, double mu,
                         double e);

}  // namespace freeplay

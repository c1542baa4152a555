// One contact's impact integrated along its normal impulse (Routh, Dynamics of a System of Rigid Bodies, 1905). It ends by
// Poisson's law, when expansion has given e times the impulse of compression (Wang and Mason, J. Appl. Mech. 59 (1992) 635), or
// by the energetic one, when it has given e² of its work (Stronge).
#pragma once

#include "mechanism/options.hpp"

namespace freeplay {

struct RouthImpact {
  double impulse_n = 0, impulse_t = 0;  ///< N s
  double normal_work = 0,
         tangential_work = 0;  ///< J, of the impulses on the rates as they were; negative: lost
  /// False where no impulse ends the approach: a rate of approach that its only freedom cannot give.
  bool ended = true;
};

/// D and u before, of one contact; D_TT = 0 without friction. A D whose rows see one freedom (a lever on a stop) is no
/// exception: what slides then stops at the very end of compression.
RouthImpact routh_impact(ImpactLaw law, double Dnn, double Dnt, double Dtt, double u_n, double u_t, double mu,
                         double e);

}  // namespace freeplay

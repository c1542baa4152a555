// Alignment of a measured mean turn with a computed one: sign, gain and phase, from the harmonics
// of their turns. (A turn is one revolution of the crank.) With M and X the harmonics of the two
// means, x(φ − α) the computed curve shifted by α, and weights w, the correlation
//
//     C(α) = Re Σ_{k≥1} w_k M_k X̄_k e^{ikα}
//
// gives the weighted least-squares fit: the phase α maximises ±C, the gain is g = ±C(α)/Σ w_k
// |X_k|², and the residual of g x(φ − α) is χ² = Σ w|M|² − C²/Σ w|X|².
//
// The weights are 1/σ_k², where σ_k² is the variance of M_k and X_k from the scatter of the turns,
// averaged over five neighbouring harmonics because a single one is known from a few turns only.
// Repeatable harmonics thus dominate over the ringing of impacts. Without scatter (one turn) all
// weights are equal. The mean of the signal, k = 0, is excluded: accelerometers differ in their
// response to it.
//
// The sign is decided if the opposite one raises χ² by more than 15 times its mean share (a
// likelihood ratio of 1,800), or, without scatter, if it leaves four times the residual. Standard
// errors follow from the scatter of the turns of both signals, to first order.
//
// Use: compute the harmonics of each turn (measure/harmonics.hpp), then call align(). The functions
// keep no state.
#pragma once

#include <vector>

#include "measure/harmonics.hpp"

namespace freeplay {

/// Result of align().
struct Alignment {
  int sign = 1;          ///< −1: the measured curve is reversed
  bool decided = false;  ///< the sign is beyond doubt, as above
  double gain = 0;       ///< measured over computed, > 0
  /// Rad, in [−π, π): forward shift of the computed curve onto the measured one.
  double phase = 0;
  double gain_error = NAN;  ///< standard error; NaN with fewer than two turns of either signal
  /// Standard error of the phase, rad; NaN as above.
  double phase_error = NAN;
  /// ‖dM/dφ‖/‖M‖, 1/rad, of root mean squares: a relative error of the signal divided by it is an
  /// error of the phase.
  double slope = 0;
};

/// Aligns the turns of a measurement with those of a run.
Alignment align(const std::vector<Harmonics>& measured, const std::vector<Harmonics>& model);

/// Mean of the harmonics of several turns. Turns may have different numbers of harmonics; missing
/// ones count as 0.
Harmonics mean_of(const std::vector<Harmonics>& turns);

/// The harmonics of x(φ − α).
Harmonics moved(Harmonics x, double alpha);

}  // namespace freeplay

// How a measured mean turn lies to a model's, from the harmonics of their turns. With M and X the means over turns
// and x(φ − α) the model's curve moved by α, the weighted correlation
//
//     C(α) = Re Σ_{k≥1} w_k M_k X̄_k e^{ikα},      phase α: where ±C is greatest,      gain g = ±C(α)/Σ w_k |X_k|²,
//
// is of least squares: g x(φ − α) with its sign is the nearest to the measured curve, and leaves χ² = Σ w|M|² − C²/Σ w|X|².
// Weights are 1/σ_k², the variance of M_k and X_k by the scatter of turns (of five neighbouring harmonics, one alone is
// known from a few turns only): what repeats from turn to turn decides, and not the ringing of impacts that does not.
// Without turns to scatter they are equal. The mean of the curve is left out: accelerometers differ in what they make
// of it.
//
// A measurement is taken for reversed only beyond doubt: the sign is decided when the other one raises χ² by more than
// 15 of its mean share (a likelihood ratio of 1,800), or without scatter when it leaves four times as much. Standard
// errors are of the scatter of turns, of both, to first order in it.
#pragma once

#include <vector>

#include "measure/harmonics.hpp"

namespace freeplay {

struct Alignment {
  int sign = 1;          ///< −1: the measured curve is reversed
  bool decided = false;  ///< beyond doubt
  double gain = 0;       ///< measured over model, greater than 0
  double phase = 0;      ///< rad, in [−π, π): the model is moved forward by it to lie on the measurement
  double gain_error = NAN;  ///< standard errors; NaN with fewer than two turns of either
  double phase_error = NAN;
  /// Standard error of the difference of the two mean turns, root mean square over the turn, in their unit; NaN as
  /// above.
  double difference_error = NAN;
  /// ‖dM/dφ‖ over ‖M‖, root mean squares: what an error of the signal, relative, is divided by for one of phase.
  double slope = 0;
};

Alignment align(const std::vector<Harmonics>& measured, const std::vector<Harmonics>& model);

/// Mean of turns; they may differ in length, what is missing is 0.
Harmonics mean_of(const std::vector<Harmonics>& turns);

/// x(φ − α).
Harmonics moved(Harmonics x, double alpha);

}  // namespace freeplay

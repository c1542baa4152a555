// Agreement of a model with a measured acceleration, from the turns (revolutions of the crank) of
// both. Five properties are compared, each a mean over the turns of a vector:
//
//     waveform      harmonics c_k, k ≥ 1          spectrum   power P_b of each octave of harmonics
//     offset        c_0                           peaks      ln of the greatest |a| of a turn
//     peak angles   (cos φ, sin φ) of that peak
//
// with its error from the scatter of both samples and the file's uncertainty
// (measure/waveform.hpp). A property differs if its difference exceeds both the limit that a
// right model exceeds with a probability of 1 %, and a least size. Peaks are those of the
// band-limited signal, so that they do not depend on the instants of the samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "measure/turns.hpp"
#include "measure/waveform.hpp"
#include "study/store/results.hpp"
#include "study/verdicts/verdicts.hpp"
#include "values/result.hpp"

namespace freeplay {

// Check of the unit of a measured acceleration. The lowest harmonics of a turn follow the crank and
// depend little on the clearance, so they are compared with those of the ideal mechanism.

/// Question to the user if the first three harmonics of a measurement (m/s²) agree within a third
/// with those of the ideal mechanism in another unit, g, cm/s² or mm/s²; else empty.
std::string unit_plausibility(const TurnMetrics& measured, const TurnMetrics& ideal);

/// Statistic of a measured file, computed like that of a run, with the sampling rate of the file;
/// and questions about its units.
double measured_statistic(const Study& study, Target& target, const Conduct& conduct,
                          std::vector<std::string>& plausibility_checks);

/// Quiet interval of a mean turn: the longest interval with |a| at most 5 % of the greatest ideal
/// acceleration. A slider without contact and friction produces it, in measurements and in runs.
/// Degrees; NaN if there is none.
struct Quiet {
  double from = 0, to = 0;
};
/// The quiet interval of a mean turn, given in equal parts from crank angle 0.
Quiet quiet_stretch(const std::vector<double>& mean_turn, double ideal_maximum);

/// Probability that a property of a right model is found to differ; 5 % for all five.
inline constexpr double property_error = 0.01;
/// Least sizes of a reported difference: relative for amplitudes (gain, peaks, and of the signal's
/// rms), degrees for phases and peak angles.
inline constexpr double least_amplitude = 0.02, least_angle = 1;

/// Offsets below this share of the signal's rms are rounding.
inline constexpr double offset_rounding = 1e-6;

/// Comparison of one formulation with the measurement. Differences that are beyond doubt are
/// reported, not corrected: a reversed, shifted or scaled curve is not changed. Only if the file gives
/// times, and thus no datum of the crank angle, is the computed curve moved by the best-fitting
/// phase. Angles of a file are used unchanged.
struct Agreement {
  std::string formulation;
  int sign = 1;               ///< −1: the measured curve is reversed relative to the computed one
  bool sign_decided = false;  ///< beyond doubt (measure/alignment.hpp)
  /// Measured over computed mean turn; 95 % if turns scatter or the file has an uncertainty.
  Interval gain;
  /// Degrees of the computed crank angle behind the measured one, in [−180, 180).
  Interval phase;
  double moved = 0;  ///< degrees, applied shift: the phase without a datum, else 0

  /// A compared property. Waveform, offset and spectrum in m/s², as root mean square; peaks as a
  /// logarithm; peak angles as a chord of the unit circle.
  struct Property {
    MeanDifference difference;
    double least = 0;  ///< least size of a reported difference
    bool differs() const { return difference.size > std::max(difference.limit, least); }
  };
  enum Name { waveform, offset, peaks, peak_angles, spectrum, count };
  static constexpr std::array<const char*, count> names{"waveform", "offset", "peaks", "peak_angles",
                                                        "spectrum"};
  std::array<Property, count> properties;

  double shift = 0;  ///< m/s², mean of the measured signal less that of the computed one
  /// An offset beyond its uncertainty that is too small, against the signal, to be judged.
  bool small_offset() const {
    const auto& p = properties[offset];
    return !p.differs() && p.difference.size > std::max(p.difference.limit, offset_rounding * rms_measured);
  }
  double peak_ratio = 0;      ///< median peak of a turn, computed over measured
  double greatest_ratio = 0;  ///< greatest peak, computed over measured; not judged
  double rms_measured = 0;    ///< m/s², of the measured mean turn without its mean
  /// ‖A − B‖/‖B‖ over harmonics of the crank below 0.4 of the file's sampling rate.
  double spectral_distance = 0;
  /// Degrees, of the computed contact, in the measurement's datum.
  double loss_angle = 0, return_angle = 0;
  Quiet quiet;                        ///< of the computed curve, in the measurement's datum
  std::vector<double> mean_turn;      ///< computed, in the measurement's datum
  std::vector<std::string> findings;  ///< differences beyond doubt, as text
  std::vector<std::string> remarks;   ///< observations that do not decide
  TurnMetrics metrics;
  Ending ending;
  bool faulty_signal = false;  ///< the measured signal is reversed or has an offset
  /// `agrees`: no difference beyond doubt. `undecided`: the uncertainty is unknown, or the limit of
  /// the waveform exceeds the measured signal, so that zero would agree too, or the test has no
  /// power (validate.hpp).
  using Verdict = SignalAgreement::Outcome;
  Verdict verdict = Verdict::undecided;
  int starts = 1;     ///< number of starts that were run, until one did not differ
  std::string power;  ///< which wrong clearances the same test finds, or why it decides nothing
};

/// Constant offset of a measured signal from a given mean, estimated from its revolutions.
struct SignalOffset {
  double value = 0;    ///< m/s²
  double error = NAN;  ///< m/s², standard: scatter of the revolutions and uncertainty of the file
  double limit = NAN;  ///< m/s², exceeded with the probability property_error without an offset
  bool beyond() const { return std::abs(value) > limit; }
};
/// `mean`: m/s², of the computed signal, without error. `uncertainty`: as for assess().
SignalOffset offset_from(double mean, const TurnMetrics& measured, double uncertainty);

/// Compares the turns of a run with those of a measurement; sets the members of `a` that depend on
/// the signals. `datum`: the file gives angles. `uncertainty`: m/s², standard deviation, assumed
/// not to average out.
void assess(const TurnMetrics& measured, double uncertainty, bool datum, Agreement& a);
/// Difference of the waveforms of the first and the second half of the turns, if it is beyond doubt
/// and at least least_amplitude of their rms; m/s², else 0. The motion is then not stationary.
double unsteadiness(const TurnMetrics& turns, double uncertainty);

/// Revolutions of a measured signal that deviate from all others. One such revolution raises the scatter
/// of the n revolutions as much as it moves their mean, so that any difference would be explained. The
/// distance of a revolution is the root mean square of its difference from the median revolution
/// (harmonic by harmonic); it is outlying above outlying_median times the median distance of the others
/// and outlying_greatest times the greatest.
struct OutlyingTurns {
  std::size_t start = 0;    ///< number at the start, at most a quarter of all
  double ratio = 0;         ///< least distance of these over the median of the others
  int single = -1;          ///< index of a later one; −1: none
  double single_ratio = 0;  ///< its distance over the median of the others
};
inline constexpr double outlying_median = 3, outlying_greatest = 2;
/// Empty for fewer than eight revolutions.
OutlyingTurns outlying_turns(const TurnMetrics& measured);

/// Name of a verdict: "agrees", "differs", "undecided" or "stopped".
const char* text_of(Agreement::Verdict verdict);

}  // namespace freeplay

// Spectrum of the signals of a run: amplitudes with a Hann window w,
//
//     A(k f_s/N) = 2 |Σ w_n (s_n − s̄) exp(−2πi kn/N)| / Σ w_n,    w_n = sin²(πn/N)
//
// A sine of amplitude a at a multiple of f_s/N has amplitude a there, a/2 at the two neighbours and
// 0 elsewhere.
#pragma once

#include <vector>

namespace freeplay::plots {

struct Spectrum {
  std::vector<double> frequency;  ///< Hz, from 0 to half the sampling rate
  std::vector<double> amplitude;  ///< in the unit of the signal
};

/// Spectrum of the last samples. Their number is chosen for a fast transform (no prime factor above
/// 5). Empty for fewer than 16 samples.
Spectrum spectrum_of(const std::vector<double>& samples, double sampling);

}  // namespace freeplay::plots

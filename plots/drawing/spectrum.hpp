// Amplitudes of a sampled signal over frequency, by a Hann window w:
//
//     A(k f_s/N) = 2 |Σ w_n (s_n − s̄) exp(−2πi kn/N)| / Σ w_n,    w_n = sin²(πn/N)
//
// so that a sine of amplitude a at a multiple of f_s/N stands at a there, at a/2 at its neighbours and at 0 elsewhere.
#pragma once

#include <vector>

namespace freeplay::plots {

struct Spectrum {
  std::vector<double> frequency;  ///< Hz, from 0 to half the sampling
  std::vector<double> amplitude;  ///< in the signal's unit
};

/// Of the last samples, as many as a fast transform takes easily (their number has no prime factor beyond 5); empty for
/// fewer than 16.
Spectrum spectrum_of(const std::vector<double>& samples, double sampling);

}  // namespace freeplay::plots

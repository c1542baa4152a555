#include "plots/drawing/spectrum.hpp"

#include <unsupported/Eigen/FFT>

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

namespace freeplay::plots {
namespace {

bool is_easy(std::size_t n) {
  for (const std::size_t p : {2, 3, 5})
    while (n % p == 0) n /= p;
  return n == 1;
}

}  // namespace

Spectrum spectrum_of(const std::vector<double>& samples, double sampling) {
  if (samples.size() < 16) return {};
  auto n = samples.size();
  while (n % 2 != 0 || !is_easy(n)) --n;
  std::vector<double> s(samples.end() - static_cast<std::ptrdiff_t>(n), samples.end());
  const double mean = std::accumulate(s.begin(), s.end(), 0.0) / static_cast<double>(n);
  double weight = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w =
        std::pow(std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(n)), 2);
    s[i] = w * (s[i] - mean);
    weight += w;
  }
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> lines;
  fft.fwd(lines, s);
  Spectrum out;
  for (std::size_t k = 0; k <= n / 2; ++k) {
    out.frequency.push_back(static_cast<double>(k) * sampling / static_cast<double>(n));
    out.amplitude.push_back(2 * std::abs(lines[k]) / weight);
  }
  return out;
}

}  // namespace freeplay::plots

#include "measure/alignment.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace freeplay {
namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;

/// C and its first two derivatives, of any turn against X.
struct Correlation {
  double value = 0, first = 0, second = 0;
};
Correlation correlation(const Harmonics& m, const Harmonics& x, double alpha) {
  Correlation c;
  for (std::size_t k = 1; k < std::min(m.size(), x.size()); ++k) {
    const auto n = static_cast<double>(k);
    const auto term = m[k] * std::conj(x[k]) * std::polar(1.0, std::fmod(n * alpha, 2 * pi));
    c.value += term.real();
    c.first -= n * term.imag();
    c.second -= n * n * term.real();
  }
  return c;
}

/// Where C is greatest and least: from a grid that its highest harmonic cannot slip through, then by Newton's method.
std::pair<double, double> extremes(const Harmonics& m, const Harmonics& x) {
  const auto size = std::bit_ceil(4 * std::max(m.size(), x.size()));
  std::vector<Complex> terms(size), grid;
  for (std::size_t k = 1; k < std::min(m.size(), x.size()); ++k) terms[k] = m[k] * std::conj(x[k]);
  Eigen::FFT<double> fft;
  fft.inv(grid, terms);
  const auto refined = [&](auto best) {
    const double cell = 2 * pi / static_cast<double>(size),
                 start = cell * static_cast<double>(best - grid.begin());
    double alpha = start;
    for (int i = 0; i < 20; ++i) {
      const auto c = correlation(m, x, alpha);
      if (c.second != 0) alpha -= std::clamp(c.first / c.second, -0.5 * cell, 0.5 * cell);
    }
    return std::abs(alpha - start) <= cell ? alpha : start;
  };
  const auto real = [](const Complex& z) { return z.real(); };
  return {refined(std::ranges::max_element(grid, {}, real)),
          refined(std::ranges::min_element(grid, {}, real))};
}

double power(const Harmonics& x) {
  double sum = 0;
  for (std::size_t k = 1; k < x.size(); ++k) sum += std::norm(x[k]);
  return sum;
}

/// Variance of the mean of some numbers.
double variance_of_mean(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  double mean = 0, sum = 0;
  for (const double value : x) mean += value / n;
  for (const double value : x) sum += (value - mean) * (value - mean);
  return n > 1 ? sum / (n * (n - 1)) : NAN;
}

/// Variances of what turns give as gain and phase against x moved by α, and of their mean as a curve.
struct Scatter {
  double gain, phase, curve;
};
Scatter scatter(const std::vector<Harmonics>& turns, const Harmonics& mean, const Harmonics& x,
                double alpha) {
  const double size = power(x), bend = correlation(mean, x, alpha).second;
  std::vector<double> gains, phases;
  double squares = 0;
  for (const auto& turn : turns) {
    const auto c = correlation(turn, x, alpha);
    gains.push_back(c.value / size);
    phases.push_back(c.first / bend);
    for (std::size_t k = 0; k < mean.size(); ++k)
      squares += (k == 0 ? 1 : 2) * std::norm((k < turn.size() ? turn[k] : 0) - mean[k]);
  }
  const auto n = static_cast<double>(turns.size());
  return {variance_of_mean(gains), variance_of_mean(phases), n > 1 ? squares / (n * (n - 1)) : NAN};
}

}  // namespace

Harmonics mean_of(const std::vector<Harmonics>& turns) {
  Harmonics mean;
  for (const auto& turn : turns) {
    mean.resize(std::max(mean.size(), turn.size()));
    for (std::size_t k = 0; k < turn.size(); ++k) mean[k] += turn[k] / static_cast<double>(turns.size());
  }
  return mean;
}

Harmonics moved(Harmonics x, double alpha) {
  for (std::size_t k = 0; k < x.size(); ++k)
    x[k] *= std::polar(1.0, -std::fmod(static_cast<double>(k) * alpha, 2 * pi));
  return x;
}

Alignment align(const std::vector<Harmonics>& measured, const std::vector<Harmonics>& model) {
  const auto M = mean_of(measured), X = mean_of(model);
  const auto [greatest, least] = extremes(M, X);
  const double up = correlation(M, X, greatest).value, down = -correlation(M, X, least).value;
  const double size = power(X), whole = power(M);
  const auto left = [&](double c) { return std::max(0.0, whole - c * c / size); };
  Alignment a;
  a.sign = down > up ? -1 : 1;
  a.decided = left(std::min(up, down)) > 4 * left(std::max(up, down));
  const double alpha = a.sign > 0 ? greatest : least;
  a.phase = std::remainder(alpha, 2 * pi);
  a.gain = std::max(up, down) / size;
  const auto of_measured = scatter(measured, M, X, alpha), of_model = scatter(model, X, X, 0);
  a.gain_error = std::sqrt(of_measured.gain + a.gain * a.gain * of_model.gain);
  a.phase_error = std::sqrt(of_measured.phase + of_model.phase);
  a.difference_error = std::sqrt(of_measured.curve + of_model.curve);
  double slope = 0;
  for (std::size_t k = 1; k < M.size(); ++k) slope += static_cast<double>(k * k) * std::norm(M[k]);
  a.slope = std::sqrt(slope / whole);
  return a;
}

}  // namespace freeplay

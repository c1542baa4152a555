#include "measure/alignment.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace freeplay {
namespace {

using Complex = std::complex<double>;

using Weights = std::vector<double>;  // of harmonics, from 0 on

/// C and its first two derivatives, of one turn against X.
struct Correlation {
  double value = 0, first = 0, second = 0;
};
Correlation correlation(const Weights& w, const Harmonics& m, const Harmonics& x, double alpha) {
  Correlation c;
  for (std::size_t k = 1; k < std::min({w.size(), m.size(), x.size()}); ++k) {
    const auto n = static_cast<double>(k);
    const auto term =
        w[k] * m[k] * std::conj(x[k]) * std::polar(1.0, std::fmod(n * alpha, 2 * std::numbers::pi));
    c.value += term.real();
    c.first -= n * term.imag();
    c.second -= n * n * term.real();
  }
  return c;
}

/// Phases of the maximum and minimum of C: from a grid finer than its highest harmonic, then by
/// Newton's method.
std::pair<double, double> extremes(const Weights& w, const Harmonics& m, const Harmonics& x) {
  const auto size = std::bit_ceil(4 * w.size());
  std::vector<Complex> terms(size), grid;
  for (std::size_t k = 1; k < w.size(); ++k) terms[k] = w[k] * m[k] * std::conj(x[k]);
  Eigen::FFT<double> fft;
  fft.inv(grid, terms);
  const auto refined = [&](auto best) {
    const double cell = 2 * std::numbers::pi / static_cast<double>(size),
                 start = cell * static_cast<double>(best - grid.begin());
    double alpha = start;
    for (int i = 0; i < 20; ++i) {
      const auto c = correlation(w, m, x, alpha);
      if (c.second != 0) alpha -= std::clamp(c.first / c.second, -0.5 * cell, 0.5 * cell);
    }
    return std::abs(alpha - start) <= cell ? alpha : start;
  };
  const auto real = [](const Complex& z) { return z.real(); };
  return {refined(std::ranges::max_element(grid, {}, real)),
          refined(std::ranges::min_element(grid, {}, real))};
}

double power(const Weights& w, const Harmonics& x) {
  double sum = 0;
  for (std::size_t k = 1; k < w.size(); ++k) sum += w[k] * std::norm(x[k]);
  return sum;
}

/// Adds the variance of each harmonic of the mean of some turns; NaN for a single turn.
void add_variances(const std::vector<Harmonics>& turns, const Harmonics& mean, std::vector<double>& sum) {
  const auto n = static_cast<double>(turns.size());
  for (const auto& turn : turns)
    for (std::size_t k = 0; k < sum.size(); ++k)
      sum[k] += std::norm((k < turn.size() ? turn[k] : 0) - mean[k]) / (n > 1 ? n * (n - 1) : NAN);
}

/// Variance of the mean of some numbers.
double variance_of_mean(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  double mean = 0, sum = 0;
  for (const double value : x) mean += value / n;
  for (const double value : x) sum += (value - mean) * (value - mean);
  return n > 1 ? sum / (n * (n - 1)) : NAN;
}

/// Variances of the gain and the phase that single turns have against x shifted by α.
struct Scatter {
  double gain, phase;
};
Scatter scatter(const Weights& w, const std::vector<Harmonics>& turns, const Harmonics& mean,
                const Harmonics& x, double alpha) {
  const double size = power(w, x), bend = correlation(w, mean, x, alpha).second;
  std::vector<double> gains, phases;
  for (const auto& turn : turns) {
    const auto c = correlation(w, turn, x, alpha);
    gains.push_back(c.value / size);
    phases.push_back(c.first / bend);
  }
  return {variance_of_mean(gains), variance_of_mean(phases)};
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
    x[k] *= std::polar(1.0, -std::fmod(static_cast<double>(k) * alpha, 2 * std::numbers::pi));
  return x;
}

Alignment align(const std::vector<Harmonics>& measured, const std::vector<Harmonics>& model) {
  const auto M = mean_of(measured), X = mean_of(model);
  const auto count = std::min(M.size(), X.size());
  std::vector<double> variances(count);
  add_variances(measured, M, variances);
  add_variances(model, X, variances);
  const bool scattered = !std::isnan(variances[0]);
  Weights w(count, 1);
  const double whole = power(w, M) / static_cast<double>(count);
  if (scattered)
    for (std::size_t k = 1; k < count; ++k) {
      const auto from = k > 2 ? k - 2 : 1, to = std::min(count, k + 3);
      double sum = 1e-9 * whole;  // where nothing scatters, all weights are equal
      for (auto i = from; i < to; ++i) sum += variances[i] / static_cast<double>(to - from);
      w[k] = 1 / sum;
    }
  const auto [greatest, least] = extremes(w, M, X);
  const double up = correlation(w, M, X, greatest).value, down = -correlation(w, M, X, least).value;
  const double size = power(w, X), all = power(w, M);
  const auto left = [&](double c) { return std::max(0.0, all - c * c / size); };
  const double best = left(std::max(up, down)), other = left(std::min(up, down));
  Alignment a;
  a.decided = scattered ? other - best > 15 * best / static_cast<double>(2 * count) : other > 4 * best;
  a.sign = a.decided && down > up ? -1 : 1;
  const double alpha = a.sign > 0 ? greatest : least;
  a.phase = std::remainder(alpha, 2 * std::numbers::pi);
  a.gain = (a.sign > 0 ? up : down) / size;
  const auto of_measured = scatter(w, measured, M, X, alpha), of_model = scatter(w, model, X, X, 0);
  a.gain_error = std::sqrt(of_measured.gain + a.gain * a.gain * of_model.gain);
  a.phase_error = std::sqrt(of_measured.phase + of_model.phase);
  double slope = 0, square = 0;
  for (std::size_t k = 1; k < M.size(); ++k) {
    slope += static_cast<double>(k * k) * std::norm(M[k]);
    square += std::norm(M[k]);
  }
  a.slope = std::sqrt(slope / square);
  return a;
}

}  // namespace freeplay

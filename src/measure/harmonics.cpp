#include "measure/harmonics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace freeplay {
namespace {

using Complex = std::complex<double>;

/// The least number from n on with prime factors 2, 3 and 5 only, for which the FFT is fast.
std::size_t smooth(std::size_t n) {
  for (;; ++n) {
    auto rest = n;
    for (const std::size_t p : {2, 3, 5})
      while (rest % p == 0) rest /= p;
    if (rest == 1) return n;
  }
}

double norm2(const std::vector<Complex>& x) {
  double sum = 0;
  for (const auto& z : x) sum += std::norm(z);
  return sum;
}

}  // namespace

const TurnTransform::Chirp& TurnTransform::chirp_of(double step, std::size_t n, std::size_t m) {
  if (step != step_) {
    products_.clear();
    chirps_.clear();
  }
  step_ = step;
  for (const auto& known : chirps_)
    if (known.n == n && known.m == m) return known;
  Chirp c{.n = n, .m = m, .size = smooth(n + m), .phase = {}, .transform = {}};
  for (std::size_t k = 0; k < std::max(n, m); ++k) {  // reduced modulo 2π before it loses digits
    const auto square = static_cast<double>(k) * static_cast<double>(k);
    c.phase.push_back(std::polar(1.0, std::fmod(0.5 * step * square, 2 * std::numbers::pi)));
  }
  List w(c.size);
  std::copy_n(c.phase.begin(), m, w.begin());
  for (std::size_t k = 1; k < n; ++k) w[c.size - k] = c.phase[k];
  forward(c.transform, w);
  return chirps_.emplace_back(std::move(c));
}

TurnTransform::List TurnTransform::chirp(double step, std::span<const double> values, int most) {
  // kj = (k² + j² − (k − j)²)/2.
  const auto n = values.size(), m = static_cast<std::size_t>(most) + 1;
  const auto& c = chirp_of(step, n, m);
  List a(c.size), A;
  for (std::size_t j = 0; j < n; ++j) a[j] = values[j] * std::conj(c.phase[j]);
  forward(A, a);
  for (std::size_t i = 0; i < c.size; ++i) A[i] *= c.transform[i];
  fft_.inv(a, A);
  a.resize(m);
  for (std::size_t k = 0; k < m; ++k) a[k] *= std::conj(c.phase[k]);
  return a;
}

TurnTransform::List TurnTransform::product_of(const List& g) {
  const auto most = 2 * static_cast<std::size_t>(highest_);
  List circulant(smooth(2 * most + 1)), transform;
  for (std::size_t m = 0; m <= most; ++m) {
    circulant[m] = g[m];
    if (m > 0) circulant[circulant.size() - m] = std::conj(g[m]);
  }
  forward(transform, circulant);
  return transform;
}

Harmonics TurnTransform::solve(const List& b, const List& product) const {
  const auto K = static_cast<std::size_t>(highest_), n = 2 * K + 1;
  List r(n), x(n), p, q(n), padded(product.size()), transform;
  for (std::size_t k = 0; k <= K; ++k) r[K + k] = b[k], r[K - k] = std::conj(b[k]);
  p = r;
  const double requested = 1e-26 * norm2(r);
  double rr = norm2(r);
  for (int iteration = 0; iteration < 200 && rr > requested; ++iteration) {
    std::ranges::fill(padded, Complex());
    std::ranges::copy(p, padded.begin());
    forward(transform, padded);
    for (std::size_t i = 0; i < transform.size(); ++i) transform[i] *= product[i];
    fft_.inv(padded, transform);
    std::copy_n(padded.begin(), n, q.begin());
    double pq = 0;
    for (std::size_t i = 0; i < n; ++i) pq += std::real(std::conj(p[i]) * q[i]);
    const double alpha = rr / pq, before = rr;
    for (std::size_t i = 0; i < n; ++i) x[i] += alpha * p[i], r[i] -= alpha * q[i];
    rr = norm2(r);
    for (std::size_t i = 0; i < n; ++i) p[i] = r[i] + rr / before * p[i];
  }
  return {x.begin() + static_cast<long>(K), x.end()};
}

Harmonics TurnTransform::even(double start, double step, std::span<const double> values) {
  const auto sums = chirp(step, values, highest_);
  auto& product = products_[values.size()];
  if (product.empty()) product = product_of(chirp(step, std::vector<double>(values.size(), 1), 2 * highest_));
  auto c = solve(sums, product);
  for (std::size_t k = 0; k < c.size(); ++k)
    c[k] *= std::polar(1.0, -std::fmod(static_cast<double>(k) * start, 2 * std::numbers::pi));
  return c;
}

TurnTransform::List TurnTransform::sums(std::span<const double> angles, std::span<const double> values,
                                        int most) {
  // Spread each sample by the kernel e^{β(√(1 − z²) − 1)}, |z| ≤ 1, on `width` points of a grid
  // with twice as many points as sums, then divide the transform by that of the kernel.
  constexpr int width = 16, nodes = 32;
  constexpr double beta = 2.3 * width;
  const auto n = smooth(std::max<std::size_t>(4 * static_cast<std::size_t>(most) + 2, 2 * width));
  const double spacing = 2 * std::numbers::pi / static_cast<double>(n), reach = 0.5 * width * spacing;
  List grid(n), transform;
  for (std::size_t j = 0; j < angles.size(); ++j) {
    double at = std::fmod(angles[j], 2 * std::numbers::pi);
    if (at < 0) at += 2 * std::numbers::pi;
    const auto first = static_cast<long>(std::ceil((at - reach) / spacing));
    for (long l = first; l < first + width; ++l) {
      const double z = (static_cast<double>(l) * spacing - at) / reach, left = 1 - z * z;
      const auto place = static_cast<std::size_t>(l + static_cast<long>(n)) % n;
      if (left > 0) grid[place] += values[j] * std::exp(beta * (std::sqrt(left) - 1));
    }
  }
  forward(transform, grid);
  transform.resize(static_cast<std::size_t>(most) + 1);
  for (std::size_t k = 0; k < transform.size(); ++k) {
    // Transform of the kernel with z = sin θ: the integrand is periodic to rounding, so equal steps
    // are exact.
    double hump = 0;
    for (int i = 0; i < nodes; ++i) {
      const double theta = std::numbers::pi / 2 * (i + 0.5) / nodes;
      hump += std::exp(beta * (std::cos(theta) - 1)) *
              std::cos(reach * static_cast<double>(k) * std::sin(theta)) * std::cos(theta);
    }
    transform[k] *= spacing / (reach * hump * std::numbers::pi / nodes);
  }
  return transform;
}

Harmonics TurnTransform::uneven(std::span<const double> angles, std::span<const double> values) {
  return solve(sums(angles, values, highest_),
               product_of(sums(angles, std::vector<double>(angles.size(), 1), 2 * highest_)));
}

std::vector<double> bin_means(const Harmonics& c, int bins) {
  const auto n = static_cast<std::size_t>(bins);
  std::vector<Complex> folded(n), values;
  for (std::size_t k = 0; k < c.size(); ++k) {
    // The mean of e^{ikφ} over a bin is its value at the centre times sin(x)/x, with x half the
    // bin's phase.
    const double x = static_cast<double>(k) * std::numbers::pi / bins;
    folded[k % n] +=
        c[k] * (k == 0 ? 0.5 : std::sin(x) / x) * std::polar(1.0, std::fmod(x, 2 * std::numbers::pi));
  }
  Eigen::FFT<double> fft;
  fft.inv(values, folded);
  std::vector<double> means;
  for (const auto& z : values) means.push_back(2 * static_cast<double>(bins) * z.real());
  return means;
}

}  // namespace freeplay

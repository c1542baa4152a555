#include "formulations/integrators/adams.hpp"

#include <cmath>
#include <cstring>
#include <utility>

#include "numerics/wide_registers.hpp"

namespace freeplay {

/// The arrays of a pass over all components (AdamsHistory).
struct AdamsSums {
  std::size_t n;
  double h;
  const double *beta, *g, *scale, *y;
  double* y_new;
  const double* before;
  double* now;
};

namespace {

/// Four components, as two or one register hold them.
using Pack = double __attribute__((vector_size(32), aligned(8), may_alias));
using PackBits = long long __attribute__((vector_size(32), aligned(8), may_alias));
constexpr std::size_t pack_size = 4, pack_entries = AdamsHistory::most_order + 2;

/// Calls f(i, in, out) for each pack, where i is its first component, `in` its part of `from` and `out`
/// that of `to`; behind the last component of `from` stand zeros. `to` may be null.
template <class F>
[[gnu::always_inline]] inline void over_packs(std::size_t n, const double* from, double* to, F f) {
  std::size_t i = 0;
  for (; i + pack_size <= n; i += pack_size) f(i, from + i, to + i);
  if (i == n) return;
  double in[pack_size] = {}, out[pack_size];
  std::memcpy(in, from + i, (n - i) * sizeof(double));
  f(i, in, out);
  if (to) std::memcpy(to + i, out, (n - i) * sizeof(double));
}

// NOLINTNEXTLINE(readability-non-const-parameter)
[[gnu::always_inline]] inline Pack& pack(double* x) { return *reinterpret_cast<Pack*>(x); }
[[gnu::always_inline]] inline const Pack& pack(const double* x) { return *reinterpret_cast<const Pack*>(x); }

template <int K>
struct Extrapolation {
  [[gnu::always_inline]] static void run(const AdamsSums& sums, const double*, double* x, double*) {
    const AdamsSums s = sums;
    Pack weight[K];
    for (int i = 0; i < K; ++i) weight[i] = Pack{} + s.h * s.g[i] * s.beta[i];
    over_packs(
        s.n, s.y, x, [&](std::size_t at, const double* y_in, double* out) __attribute__((always_inline)) {
          Pack y = pack(y_in);
          const double* phi = s.before + at * pack_entries;
          for (int i = 0; i < K; ++i) y += weight[i] * pack(phi + pack_size * i);
          pack(s.y_new + at) = y;
          pack(out) = y * pack(s.scale + at);
        });
  }
};

/// `greatest`: max |φ*_K|, and a sum that is NaN if any component is not finite.
template <int K>
struct Correction {
  [[gnu::always_inline]] static void run(const AdamsSums& sums, const double* dxdt, double* x,
                                         double* greatest) {
    const AdamsSums s = sums;
    Pack beta[K], most{}, undefined{};
    for (int i = 0; i < K; ++i) beta[i] = Pack{} + s.beta[i];
    const Pack weight = Pack{} + s.h * s.g[K];
    over_packs(
        s.n, dxdt, x, [&](std::size_t at, const double* slope, double* out) __attribute__((always_inline)) {
          const Pack scale = pack(s.scale + at);
          const double* phi = s.before + at * pack_entries;
          Pack d = pack(slope) / scale;
          for (int i = 0; i < K; ++i) d -= beta[i] * pack(phi + pack_size * i);
          const Pack size = reinterpret_cast<Pack>(reinterpret_cast<PackBits>(d) & 0x7fffffffffffffff);
          most = size > most ? size : most;
          undefined += d * 0.0;
          const Pack y = pack(s.y_new + at) + weight * d;
          pack(s.y_new + at) = y;
          pack(out) = y * scale;
        });
    greatest[0] = std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
    greatest[1] = undefined[0] + undefined[1] + undefined[2] + undefined[3];
  }
};

/// The differences of `More` orders above K are known as well. `greatest`: norms of the differences
/// of orders K − 2 to K + 1.
template <int K, int More>
struct Confirmation {
  [[gnu::always_inline]] static void run(const AdamsSums& sums, const double* dxdt, double*,
                                         double* greatest) {
    const AdamsSums s = sums;
    Pack beta[K + More], most[4] = {};
    for (int i = 0; i < K + More; ++i) beta[i] = Pack{} + s.beta[i];
    over_packs(
        s.n, dxdt, static_cast<double*>(nullptr),
        [&](std::size_t at, const double* slope, double*) __attribute__((always_inline)) {
          const double* old = s.before + at * pack_entries;
          double* phi = s.now + at * pack_entries;
          Pack d = pack(slope) / pack(s.scale + at);
          pack(phi) = d;
          for (int i = 1; i <= K + More; ++i) {
            d -= beta[i - 1] * pack(old + pack_size * (i - 1));
            pack(phi + pack_size * i) = d;
            if (i < K - 2 || i > K + 1) continue;
            const Pack size = reinterpret_cast<Pack>(reinterpret_cast<PackBits>(d) & 0x7fffffffffffffff);
            most[i - K + 2] = size > most[i - K + 2] ? size : most[i - K + 2];
          }
        });
    for (int i = 0; i < 4; ++i)
      greatest[i] = std::max(std::max(most[i][0], most[i][1]), std::max(most[i][2], most[i][3]));
  }
};
template <int K>
using FullConfirmation = Confirmation<K, (K < AdamsHistory::most_order) ? 2 : 1>;
template <int K>
using FirstConfirmation = Confirmation<K, 1>;

using AdamsPass = void (*)(const AdamsSums&, const double* in, double* out, double* greatest);

template <class Pass>
void plain_pass(const AdamsSums& s, const double* in, double* out, double* greatest) {
  Pass::run(s, in, out, greatest);
}
template <class Pass>
FREEPLAY_WIDE void wide_pass(const AdamsSums& s, const double* in, double* out, double* greatest) {
  Pass::run(s, in, out, greatest);
}

/// The passes of all orders.
template <template <int> class Pass, int... K>
std::array<AdamsPass, sizeof...(K)> passes_of(std::integer_sequence<int, K...>) {
  if (has_wide_registers) return {wide_pass<Pass<K + 1>>...};
  return {plain_pass<Pass<K + 1>>...};
}
template <template <int> class Pass>
AdamsPass pass_of(int order) {
  static const auto list = passes_of<Pass>(std::make_integer_sequence<int, AdamsHistory::most_order>());
  return list[static_cast<std::size_t>(order - 1)];
}

}  // namespace

AdamsSums AdamsHistory::sums() {
  return {n_,         h_, beta_[0].data(), g_.data(), scale_.data(), y_.data(), y_new_.data(), before_.data(),
          now_.data()};
}

void AdamsHistory::resize(std::size_t n) {
  n_ = n;
  const std::size_t room = (n + width - 1) / width * width;
  for (auto* x : {&y_, &y_new_}) x->assign(room, 0);
  for (auto* x : {&now_, &before_}) x->assign(room * entries, 0);
  scale_.assign(room, 1);
}

void AdamsHistory::restart(const Vector& x, const Vector& scale) {
  std::ranges::copy(scale, scale_.begin());
  order_ = steps_ = 1;
  for (std::size_t i = 0; i < n_; ++i) y_[i] = x[i] / scale_[i];
}

void AdamsHistory::state(Vector& x) const {
  for (std::size_t i = 0; i < n_; ++i) x[i] = y_[i] * scale_[i];
}

void AdamsHistory::predict(double t, double h) {
  h_ = h;
  times_[0] = t;
  auto& beta = beta_[0];
  beta[0] = 1;
  for (int i = 1; i <= order_ && i < steps_; ++i)
    beta[i] = beta[i - 1] * (t + h - times_[i - 1]) / (t - times_[i]);
  // Row i of the triangle c, whose first entry is gᵢ, overwrites row i − 1; row 1 is 1/((j + 1)(j + 2)).
  std::array c{1.0 / 2, 1.0 / 6, 1.0 / 12, 1.0 / 20, 1.0 / 30, 1.0 / 42, 1.0 / 56, 1.0 / 72, 1.0 / 90};
  g_[0] = 1;
  g_[1] = c[0];
  for (int i = 2; i <= order_; ++i) {
    const double reach = t + h - times_[i - 1];
    for (int j = 0; j <= order_ - i; ++j) c[j] = c[j] - c[j + 1] * h / reach;
    g_[i] = c[0];
  }
}

void AdamsHistory::begin(const Vector& dxdt) {
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      before_[(i - i % width) * entries + width * k + i % width] = dxdt[i] / scale_[i];
}

void AdamsHistory::extrapolate(Vector& x) {
  pass_of<Extrapolation>(order_)(sums(), nullptr, x.data(), nullptr);
}

double AdamsHistory::correct(const Vector& dxdt, Vector& x) {
  double greatest[2];
  pass_of<Correction>(order_)(sums(), dxdt.data(), x.data(), greatest);
  return std::abs(h_ * g_[order_]) * (greatest[0] + greatest[1]);
}

void AdamsHistory::confirm(const Vector& dxdt) {
  const bool full = order_ < most_order && order_ < steps_;
  (full ? pass_of<FullConfirmation>(order_) : pass_of<FirstConfirmation>(order_))(sums(), dxdt.data(),
                                                                                  nullptr, greatest_.data());
  std::swap(beta_[0], beta_[1]);
  now_.swap(before_);
  std::copy_backward(times_.begin(), times_.end() - 1, times_.end());
  if (steps_ < most_order + 1) ++steps_;
}

void AdamsHistory::choose_order(double h) {
  // Coefficients of the error of each order with equal steps.
  constexpr std::array gs{1.0,        -1.0 / 2,       -1.0 / 12,      -1.0 / 24,          -19.0 / 720,
                          -3.0 / 160, -863.0 / 60480, -275.0 / 24192, -33953.0 / 3628800, 35.0 / 4436};
  const auto error = [&](int order) {
    return std::abs(h * gs[static_cast<std::size_t>(order)]) * greatest_[order - order_ + 2];
  };
  const int known = steps_ - 1;
  const double here = error(order_);
  const double below = order_ >= 2 ? error(order_ - 1) : 3 * here,
               further = order_ > 2 ? error(order_ - 2) : 3 * here;
  if (order_ < most_order && order_ < known) error_above_ = error(order_ + 1);
  const bool lower = (order_ == 2 && below <= 0.5 * here) || (order_ > 2 && further < here && below < here) ||
                     (order_ > 1 && below < here && error_above_ != 0);
  const bool higher = order_ < most_order && error_above_ < (0.5 - 0.25 * order_ / most_order) * here;
  if (known < order_ || (higher && !lower))
    ++order_;
  else if (lower)
    --order_;
}

}  // namespace freeplay

#include "mechanism/piecewise.hpp"

#include <numbers>

namespace freeplay {
namespace {

/// Thomas algorithm for a_i x_{i−1} + b_i x_i + c_i x_{i+1} = r_i; the matrix is diagonally
/// dominant.
std::vector<double> tridiagonal(const std::vector<double>& a, std::vector<double> b,
                                const std::vector<double>& c, std::vector<double> r) {
  const std::size_t n = b.size();
  for (std::size_t i = 1; i < n; ++i) {
    const double w = a[i] / b[i - 1];
    b[i] -= w * c[i - 1];
    r[i] -= w * r[i - 1];
  }
  r[n - 1] /= b[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) r[i] = (r[i] - c[i] * r[i + 1]) / b[i];
  return r;
}

/// The tridiagonal system with corners c_n x_1 in the last row and a_1 x_n in the first, by the
/// Sherman–Morrison formula.
std::vector<double> cyclic(const std::vector<double>& a, std::vector<double> b, const std::vector<double>& c,
                           const std::vector<double>& r) {
  const std::size_t n = b.size(), last = n - 1;
  const double gamma = -b[0];
  std::vector<double> u(n, 0.0);
  u[0] = gamma;
  u[last] = c[last];
  b[0] -= gamma;
  b[last] -= a[0] * c[last] / gamma;
  auto x = tridiagonal(a, b, c, r);
  const auto z = tridiagonal(a, b, c, u);
  const double factor = (x[0] + a[0] / gamma * x[last]) / (1 + z[0] + a[0] / gamma * z[last]);
  for (std::size_t i = 0; i < n; ++i) x[i] -= factor * z[i];
  return x;
}

}  // namespace

std::vector<double> spline_slopes(const std::vector<std::pair<double, double>>& knots, SplineEnds ends) {
  const std::size_t pieces = knots.size() - 1;
  std::vector<double> inverse(pieces), bent(pieces);  // 1/h and 3 d/h²
  for (std::size_t i = 0; i < pieces; ++i) {
    inverse[i] = 1 / (knots[i + 1].first - knots[i].first);
    bent[i] = 3 * (knots[i + 1].second - knots[i].second) * inverse[i] * inverse[i];
  }
  if (ends == SplineEnds::periodic) {
    if (pieces == 1) return std::vector<double>(2, bent[0] / (3 * inverse[0]));
    if (pieces == 2) {  // both neighbours of a knot are the other one
      const double sum = inverse[0] + inverse[1], m = (bent[0] + bent[1]) / (3 * sum);
      return {m, m, m};
    }
    std::vector<double> a(pieces), b(pieces), c(pieces), r(pieces);
    for (std::size_t i = 0; i < pieces; ++i) {
      const std::size_t before = (i + pieces - 1) % pieces;
      a[i] = inverse[before];
      c[i] = inverse[i];
      b[i] = 2 * (a[i] + c[i]);
      r[i] = bent[before] + bent[i];
    }
    auto m = cyclic(a, b, c, r);
    m.push_back(m[0]);
    return m;
  }
  const std::size_t n = pieces + 1;
  std::vector<double> a(n, 0.0), b(n), c(n, 0.0), r(n);
  for (std::size_t i = 1; i < pieces; ++i) {
    a[i] = inverse[i - 1];
    c[i] = inverse[i];
    b[i] = 2 * (a[i] + c[i]);
    r[i] = bent[i - 1] + bent[i];
  }
  b[0] = b[pieces] = 1;
  r[0] = r[pieces] = 0;
  if (ends == SplineEnds::natural) {
    b[0] = 2 * inverse[0];
    c[0] = inverse[0];
    r[0] = bent[0];
    b[pieces] = 2 * inverse[pieces - 1];
    a[pieces] = inverse[pieces - 1];
    r[pieces] = bent[pieces - 1];
  }
  return tridiagonal(a, b, c, r);
}

Piecewise Piecewise::antiderivative(double at, double value) const {
  auto list = stretches_;
  for (auto& s : list) {
    for (int n = terms - 1; n > 0; --n) s.c[n] = s.c[n - 1] / n;
    s.c[0] = 0;
    if (s.amplitude != 0) {  // ∫ sin = −cos = sin(· − π/2)
      s.amplitude /= s.rate;
      s.phase -= std::numbers::pi / 2;
    }
  }
  // Constants of integration make the stretches continuous.
  const auto level = [](const Stretch& s, double x) {
    double y = 0;
    for (int n = terms - 1; n >= 0; --n) y = y * (x - s.origin) + s.c[n];
    return y + (s.amplitude != 0 ? s.amplitude * std::sin(s.rate * (x - s.origin) + s.phase) : 0);
  };
  for (std::size_t k = 1; k < list.size(); ++k)
    list[k].c[0] += level(list[k - 1], list[k].begin) - level(list[k], list[k].begin);
  const auto& last = list.back();
  const double begin = list.front().begin;
  Piecewise F(list, period_, period_ > 0 ? level(last, begin + period_) - level(list.front(), begin) : 0);
  const double lift = value - F.value(at);
  for (auto& s : F.stretches_) s.c[0] += lift;
  return F;
}

Piecewise::StretchOf<Traced> Piecewise::stretch(const Traced& index) const {
  const auto entry = [&](auto member) {
    return entry_of(stretches_.size(), index, [&](std::size_t k) { return member(stretches_[k]); });
  };
  StretchOf<Traced> s;
  for (std::size_t n = 0; n < terms; ++n) s.c[n] = entry([n](const Stretch& x) { return x.c[n]; });
  s.amplitude = entry([](const Stretch& x) { return x.amplitude; });
  s.rate = entry([](const Stretch& x) { return x.rate; });
  s.phase = entry([](const Stretch& x) { return x.phase; });
  s.origin = entry([](const Stretch& x) { return x.origin; });
  return s;
}

Traced Piecewise::mean(const Traced& a, const Traced& b) const {
  const auto back = is_below(b, a);
  const Traced low = select(back, b, a), high = select(back, a, b), width = high - low;
  const Traced rounding = 1e-12 * max(Traced(1), max(abs(low), abs(high)));
  require(is_below(rounding, width));
  if (period_ > 0) require(is_below(width, period_));
  // A distance from the knots that exceeds their rounding errors.
  const auto p = find(low);
  const auto count = stretches_.size();
  const auto end = [&](bool upper) {
    return entry_of(count, p.index, [&](std::size_t k) {
      if (upper)
        return k + 1 < count ? stretches_[k + 1].begin
               : period_ > 0 ? stretches_[0].begin + period_
                             : INFINITY;
      return k > 0 || period_ > 0 ? stretches_[k].begin : -INFINITY;
    });
  };
  if (count > 1 || period_ > 0) {
    require(is_below(end(false) + p.shift + rounding, low));
    require(is_below(high + rounding, end(true) + p.shift));
  }
  const Traced half = 0.5 * width;
  return width * level(low + half, half) / width;
}

Jet<double> Piecewise::greatest() const {
  constexpr int samples = 64;
  Jet<double> most;
  const auto look = [&](double x, double within) {
    const auto j = jet(x, within);
    most.value = std::max(most.value, std::abs(j.value));
    most.slope = std::max(most.slope, std::abs(j.slope));
    most.bend = std::max(most.bend, std::abs(j.bend));
  };
  const auto& first = stretches_.front();
  if (stretches_.size() == 1 && period_ == 0) {
    const double reach = first.amplitude != 0 ? 2 * std::numbers::pi / std::abs(first.rate) : 1;
    for (int i = 0; i < samples; ++i) look(first.origin + reach * i / samples, first.origin);
    return most;
  }
  const auto ends = knots();
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const double from = ends[k];
    const double to = k + 1 < ends.size() ? ends[k + 1] : period_ > 0 ? ends[0] + period_ : from;
    const double middle = to > from ? 0.5 * (from + to) : from + 1;
    for (int i = 0; i <= samples; ++i) look(from + (to - from) * i / samples, middle);
  }
  return most;
}

}  // namespace freeplay

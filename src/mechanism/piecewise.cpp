#include "mechanism/piecewise.hpp"

#include <numbers>

namespace freeplay {

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

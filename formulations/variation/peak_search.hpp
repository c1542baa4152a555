// Search for peaks of signals along the steps of VariedColumns (varied_peaks.hpp). A step is divided into
// parts that the low-passes need. Where the rate of a signal changes its sign within a part and the peak may
// be the greatest, the part is repeated to end there.
#pragma once

#include "formulations/integrators/crossing.hpp"
#include "formulations/variation/varied_columns.hpp"

namespace freeplay {

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::advance_watched(double t, const Vector& x_old, double h) {
  if (!peaks_.any()) return advance_stages(t, x_old, h);
  const double parts = std::max(2.0, std::ceil(std::abs(h) / peaks_.longest()));
  auto x = x_old;
  for (double i = 0; i < parts; ++i) x = advance_part(t + i / parts * h, x, h / parts);
  return x;
}

template <class Dynamics>
std::vector<double> VariedColumns<Dynamics>::advance_part(double t, const Vector& x, double h) {
  Vector slope(size_);
  const auto rate_at = [&](std::size_t i, const Vector& y, double at) {
    (*probe_)(y, slope, at);
    return peaks_.rate(i, y, slope);
  };
  const auto begin = place();
  const auto y = advance_stages(t, x, h);
  const auto end = place();
  const Vector still(keys_.size());
  for (std::size_t i = 0; i < peaks_.size(); ++i) {
    const double after = rate_at(i, y, t + h);
    go_back(begin);
    const double before = peaks_.begins(i) ? 0 : rate_at(i, x, t), value = peaks_.value(i, x),
                 side = value < 0 ? -1 : 1;
    const double last = std::exchange(peaks_.last_rates[i], after);
    const bool possible = h > 0 && peaks_.counts(i, std::abs(value) + std::abs(before * h));
    if (possible && side * before < 0 && !(side * last < 0)) add_peak(i, t, x, 0, still);
    if (possible && side * before > 0 && side * after < 0) {
      const double root = bracketed_root(
          [&](double length) {
            go_back(begin);
            const auto at = advance_stages(t, x, length);
            return rate_at(i, at, t + length);
          },
          0.0, h, before, after);
      go_back(begin);
      const auto at = advance_stages(t, x, root);
      add_peak(i, t + root, at, 0, still);
    }
    go_back(end);
  }
  return y;
}

template <class Dynamics>
void VariedColumns<Dynamics>::add_peak(std::size_t i, double t, const Vector& x, double rate,
                                       const Vector& dt) {
  VariedPeaks::Peak peak{t, peaks_.value(i, x), {}, reasons_};
  for (std::size_t c = 0; c < keys_.size(); ++c)
    peak.slope.push_back(open(c) ? peaks_.slope(i, c, S_[c]) + rate * dt[c] : NAN);
  peaks_.add(i, std::move(peak));
}

template <class Dynamics>
void VariedColumns<Dynamics>::add_event_peaks(double t, const Vector& x, const Vector& f, const Vector& after,
                                              const Vector& f_after, const Vector& dt) {
  const auto modes = peaks_.modes;
  for (std::size_t i = 0; i < peaks_.size(); ++i) {
    const double before = peaks_.rate(i, x, f), side = peaks_.value(i, x) < 0 ? -1 : 1;
    peaks_.jump(x, after);
    const double rate = peaks_.rate(i, after, f_after);
    peaks_.modes = modes;
    peaks_.last_rates[i] = rate;
    if (side * before > 0 && side * rate <= 0) add_peak(i, t, x, before, dt);
  }
}

template <class Dynamics>
template <class Present>
VariedPeaks::Peak VariedColumns<Dynamics>::peak(std::size_t i, const Present& d, const Vector& x, double t) {
  take_mode(d);
  Vector f(size_), end_rates;
  (*probe_)(x, f, t);
  for (const auto& key : keys_) end_rates.push_back(key.end_rate);
  const double rate = peaks_.rate(i, x, f);
  if (rate * peaks_.value(i, x) >= 0) add_peak(i, t, x, rate, end_rates);
  return peaks_.greatest(i);
}

}  // namespace freeplay

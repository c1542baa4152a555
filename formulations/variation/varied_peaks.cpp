#include "formulations/variation/varied_peaks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "formulations/integrators/methods.hpp"

namespace freeplay {
namespace {

/// Longest part of a step over the time constant of the fastest low-pass: the weights of Dormand and Prince
/// have an error of about 1e-9 then.
constexpr double share_of_constant = 0.1;
/// Relative difference of the derivatives of two equal peaks that is none.
constexpr double same_slope = 1e-6;

}  // namespace

void VariedPeaks::watch(std::vector<PeakChannel> channels, std::size_t keys) {
  channels_ = std::move(channels);
  peaks_.resize(size());
  greatest_.assign(size(), 0);
  last_rates.assign(size(), NAN);
  for (const auto& channel : channels_) {
    const auto poles = channel.poles.size();
    modes.push_back({std::vector<Complex>(poles), {keys, std::vector<Complex>(poles)}, false});
    for (const auto& p : channel.poles) longest_ = std::min(longest_, share_of_constant / std::abs(p));
  }
}

double VariedPeaks::along(std::size_t i, const double* values) const {
  const auto& weights = channels_[i].weights;
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * values[k];
  return sum;
}

void VariedPeaks::advance(double h, const std::array<Vector, 6>& f,
                          const std::array<std::vector<Vector>, 6>& slopes) {
  for (std::size_t i = 0; i < size(); ++i) {
    const auto& channel = channels_[i];
    if (!channel.filtered) continue;
    const auto n = channel.weights.size();
    auto& m = modes[i];
    const auto advance_modes = [&](std::vector<Complex>& z, auto input) {
      for (std::size_t k = 0; k < z.size(); ++k) {
        const auto p = channel.poles[k];
        if (!m.started) z[k] -= input(0) / p;  // in equilibrium, with the jumps before
        z[k] *= std::exp(p * h);
        for (std::size_t s = 0; s < 6; ++s)
          z[k] += h * DormandPrince::b[s] * std::exp(p * (h * (1 - DormandPrince::c[s]))) * input(s);
      }
    };
    for (std::size_t c = 0; c < m.S.size(); ++c)
      advance_modes(m.S[c], [&](std::size_t s) { return along(i, slopes[s][c].data() + n); });
    advance_modes(m.z, [&](std::size_t s) { return along(i, f[s].data() + n); });
    m.started = true;
  }
}

void VariedPeaks::jump(const Vector& x, const Vector& after) {
  for (std::size_t i = 0; i < size(); ++i) {
    const auto n = channels_[i].weights.size();
    const double change = along(i, after.data() + n) - along(i, x.data() + n);
    for (auto& z : modes[i].z) z += change;
  }
}

/// Before the jump of the value.
void VariedPeaks::jump(std::size_t c, const Move& e) {
  for (std::size_t i = 0; i < size(); ++i) {
    const auto& channel = channels_[i];
    const auto n = channel.weights.size();
    const double change = along(i, e.after.data() + n) - along(i, e.x.data() + n),
                 slope = along(i, e.dafter.data() + n) - along(i, e.dx.data() + n),
                 a = along(i, e.f.data() + n) - along(i, e.f_after.data() + n);
    for (std::size_t k = 0; k < channel.poles.size(); ++k)
      modes[i].S[c][k] += slope + e.dt * (a - channel.poles[k] * change);
  }
}

void VariedPeaks::change(std::size_t c, const Vector& before, const Vector& after) {
  for (std::size_t i = 0; i < size(); ++i) {
    const auto n = channels_[i].weights.size();
    const double slope = along(i, after.data() + n) - along(i, before.data() + n);
    for (auto& z : modes[i].S[c]) z += slope;
  }
}

void VariedPeaks::shift(std::size_t c, double time, const Vector& f) {
  for (std::size_t i = 0; i < size(); ++i) {
    if (!modes[i].started) continue;
    const auto& channel = channels_[i];
    const double a = along(i, f.data() + channel.weights.size());
    for (std::size_t k = 0; k < channel.poles.size(); ++k)
      modes[i].S[c][k] += time * (channel.poles[k] * modes[i].z[k] + a);
  }
}

double VariedPeaks::value(std::size_t i, const Vector& x) const {
  const auto& channel = channels_[i];
  if (!channel.filtered) return along(i, x.data());
  double y = 0;
  for (std::size_t k = 0; k < channel.poles.size(); ++k) y += (channel.residues[k] * modes[i].z[k]).real();
  return y;
}

double VariedPeaks::rate(std::size_t i, const Vector& x, const Vector& f) const {
  const auto& channel = channels_[i];
  const auto n = channel.weights.size();
  if (!channel.filtered) return along(i, x.data() + n);
  const double a = along(i, f.data() + n);
  double y = 0;
  for (std::size_t k = 0; k < channel.poles.size(); ++k)
    y += (channel.residues[k] * (channel.poles[k] * modes[i].z[k] + a)).real();
  return y;
}

double VariedPeaks::slope(std::size_t i, std::size_t c, const Vector& S) const {
  const auto& channel = channels_[i];
  if (!channel.filtered) return along(i, S.data());
  double y = 0;
  for (std::size_t k = 0; k < channel.poles.size(); ++k) y += (channel.residues[k] * modes[i].S[c][k]).real();
  return y;
}

void VariedPeaks::add(std::size_t i, Peak peak) {
  if (!counts(i, peak.y)) return;
  greatest_[i] = std::max(greatest_[i], std::abs(peak.y));
  auto& list = peaks_[i];
  std::erase_if(list, [&](const Peak& p) { return !counts(i, p.y); });
  if (peak.y < 0)
    for (double& s : peak.slope) s = -s;
  list.push_back(std::move(peak));
}

VariedPeaks::Peak VariedPeaks::greatest(std::size_t i) const {
  auto found = *std::ranges::max_element(peaks_[i], {}, [](const Peak& p) { return std::abs(p.y); });
  found.y = std::abs(found.y);
  const auto& range = channels_[i].range;
  for (std::size_t c = 0; c < found.slope.size(); ++c) {
    auto& reason = found.reasons[c];
    if (range && found.y >= *range && reason.empty())
      reason = fmt::format("the peak exceeds the range {:g} of instrument {}", *range, channels_[i].name);
    for (const auto& other : peaks_[i])
      if (reason.empty() &&
          !(std::abs(other.slope[c] - found.slope[c]) <= same_slope * std::abs(found.slope[c])))
        reason = fmt::format(
            "t = {:.9g} s and {:.9g} s: two peaks of {} are equal, so that there is only a "
            "one-sided derivative",
            found.t, other.t, channels_[i].name);
    if (!reason.empty()) found.slope[c] = NAN;
  }
  return found;
}

}  // namespace freeplay

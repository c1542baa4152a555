#include "formulations/least_forces.hpp"

#include <algorithm>
#include <array>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <functional>

namespace freeplay {
namespace {

constexpr std::size_t parts = 4;  // of a step
/// A minimum is known to half the digits of the force in its time, thus to all digits in its value.
constexpr int bits = 26;

}  // namespace

void LeastForces::add_step(double t0, double h, const std::function<bool(int)>& closed,
                           const std::function<double(int, double)>& force) {
  if (!(h > 0)) return;
  if (!begun_)
    for (int k = 0; k < contacts_; ++k)
      if (closed(k)) list_.push_back({.contact = k});
  begun_ = true;
  std::erase_if(list_, [&](const auto& one) { return !closed(one.contact); });
  for (auto& one : list_) {
    const auto at = [&](double t) { return force(one.contact, t); };
    const auto take = [&](double t, double value) {
      if (value < one.least) one.least = value, one.t = t;
      one.greatest = std::max(one.greatest, value);
    };
    std::array<double, parts + 1> f{};
    for (std::size_t i = 0; i <= parts; ++i) {
      const double t = t0 + static_cast<double>(i) / parts * h;
      take(t, f[i] = at(t));
    }
    // Around the least samples; at an end of the step, the minimum may be on either side of it.
    const double width = h / parts;
    for (std::size_t i = 0; i <= parts; ++i) {
      const std::size_t middle = std::clamp<std::size_t>(i, 1, parts - 1);
      if ((i > 0 && f[i - 1] < f[i]) || (i < parts && f[i + 1] < f[i])) continue;
      const double bend = std::abs(f[middle - 1] - 2 * f[middle] + f[middle + 1]);
      if (f[i] - bend > one.least) continue;
      const double t = t0 + static_cast<double>(i) * width;
      const auto [share, value] = boost::math::tools::brent_find_minima(
          [&](double s) { return at(t + s * width); }, i > 0 ? -1.0 : 0.0, i < parts ? 1.0 : 0.0, bits);
      take(t + share * width, value);
    }
  }
}

}  // namespace freeplay

#include "formulations/contact/friction_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "formulations/contact/friction_law.hpp"
#include "mechanism/options.hpp"

namespace freeplay {
namespace {

/// c/μ of steady sliding.
double share_at(const FrictionLawFacts& law, PenaltyOptions o, double speed) {
  o.friction = law.law;
  return make_friction(o, 1).steady(speed);
}

/// The least x > 0 with f(x) ≥ `level`, from 2⁻⁶⁰ to 2⁶⁰ times `scale`, on a grid of 32 points an
/// octave that bisection refines to rounding; infinite if there is none.
double first_reach(const auto& f, double scale, double level) {
  constexpr int octaves = 60, points = 32;
  const auto x = [&](int n) { return scale * std::exp2(static_cast<double>(n) / points); };
  for (int n = -octaves * points; n <= octaves * points; ++n) {
    if (!(f(x(n)) >= level)) continue;
    double low = x(n - 1), high = x(n);
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (f(middle) >= level ? high : low) = middle;
    }
    return high;
  }
  return INFINITY;
}

}  // namespace

std::optional<PenaltyOptions> regularised(const FrictionLawFacts& law, const PenaltyOptions& options,
                                          double speed) {
  if (law.bristle || law.compliant) return {};
  auto o = options;
  o.friction = law.law;
  o.friction_viscous = 0;  // not part of the regularisation
  if (law.v1_above_v0) o.friction_v0 = 0;
  double& key = law.v1_above_v0 ? o.friction_v1 : o.friction_v0;
  // The steeper the law, the smaller its speed: the least 1/key that reaches the share.
  const double inverse = first_reach(
      [&](double x) {
        key = 1 / x;
        return share_at(law, o, speed);
      },
      1 / speed, regularised_share);
  if (!std::isfinite(inverse)) return {};
  key = 1 / inverse;
  o.friction_viscous = options.friction_viscous;
  return o;
}

std::optional<double> regularisation_speed(const FrictionLawFacts& law, const PenaltyOptions& options) {
  if (law.bristle || law.compliant) return {};
  auto o = options;
  o.friction_viscous = 0;
  const double scale = std::max(o.friction_v0, law.v1_above_v0 ? o.friction_v1 : 0);
  const double speed = first_reach([&](double v) { return share_at(law, o, v); }, scale, regularised_share);
  return std::isfinite(speed) ? std::optional(speed) : std::nullopt;
}

double creep_speed(const FrictionLawFacts& law, const PenaltyOptions& options, double share) {
  if (law.bristle || law.compliant) return 0;
  const double scale = std::max(options.friction_v0, law.v1_above_v0 ? options.friction_v1 : 0);
  return first_reach([&](double v) { return share_at(law, options, v); }, scale, share);
}

}  // namespace freeplay

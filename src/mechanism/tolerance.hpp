// A tolerance: how far a number of the scene may be from its stated value in a manufactured mechanism. Only
// statistics of output play use it (analysis/play/play_statistics.hpp); runs have the stated value.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include "mechanism/keys.hpp"

namespace freeplay {

struct Tolerance {
  enum class Distribution { uniform, normal, truncated };
  static constexpr std::string_view what = "a tolerance";

  std::string name;
  std::string key;                   ///< of the number
  double upper = 0;                  ///< upper deviation from the stated value, in the unit of the key
  std::optional<double> lower = {};  ///< default −upper
  Distribution distribution = Distribution::uniform;
  double sigmas = 3;  ///< standard deviations from the middle to each limit; not used by uniform

  double least() const { return lower.value_or(-upper); }
  double middle() const { return 0.5 * (least() + upper); }
  double half() const { return 0.5 * (upper - least()); }

  /// Variance of the deviation, relative to half() squared. Of the truncated normal distribution: Johnson, Kotz and
  /// Balakrishnan, Continuous Univariate Distributions 1, 2nd ed. 1994, ch. 13.
  double variance() const {
    if (distribution == Distribution::uniform) return 1.0 / 3;
    const double normal = 1 / (sigmas * sigmas);
    if (distribution == Distribution::normal) return normal;
    const double density = std::exp(-0.5 * sigmas * sigmas) / std::sqrt(2 * std::numbers::pi);
    return normal * (1 - 2 * sigmas * density / std::erf(sigmas / std::numbers::sqrt2));
  }

  static void keys(auto& k, auto& x);
};

inline constexpr auto tolerance_distribution_names = complete<Tolerance::Distribution>(
    {{Tolerance::Distribution::uniform, "uniform", "each value between the limits is equally likely"},
     {Tolerance::Distribution::normal, "normal",
      "the limits are `sigmas` standard deviations from the middle"},
     {Tolerance::Distribution::truncated, "truncated", "normal, without the values beyond the limits"}});
constexpr const auto& choices(Tolerance::Distribution) { return tolerance_distribution_names; }

void Tolerance::keys(auto& k, auto& x) {
  k.need({"key", "", "key of a number of the scene; KEY[i] within a list"}, x.key);
  k.deviation({"upper", "", "upper deviation from the stated value, in the unit of the key"}, x.upper, x.key);
  k.deviation({"lower", "", "lower deviation from the stated value", "-upper"}, x.lower, x.key);
  k.check(x.upper > x.least(), "upper", "must be greater than the lower deviation ", x.least());
  k.choose({"distribution", "", ""}, x.distribution);
  k.take({"sigmas", "", "standard deviations from the middle to a limit; not used by uniform"}, x.sigmas,
         positive);
}

}  // namespace freeplay

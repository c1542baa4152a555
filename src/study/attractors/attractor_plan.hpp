// The tables [bifurcation] and [basin] of a study. docs/reference/study.md lists their keys.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mechanism/keys.hpp"
#include "study/settings/setting_values.hpp"

namespace freeplay {

/// Common parameters: how a run is made, and how attractors are distinguished.
struct AttractorPlan {
  std::string formulation = "nonsmooth";
  std::vector<std::string> overrides;  ///< keys of the scene, KEY=VALUE
  std::string section = "every period";
  std::optional<double> period;     ///< s, instead of the drive's period
  double discard = 200, keep = 60;  ///< periods
  /// Columns that distinguish attractors; empty: the default ones of the section.
  std::vector<std::string> columns;
  double tolerance = 1e-3;
  int most_period = 16;
  bool exponents = false;  ///< whether the largest Lyapunov exponents are computed
  /// Periods over which they are averaged, at least; without it `keep`.
  std::optional<double> exponent_periods;
  double averaged() const { return exponent_periods.value_or(keep); }

  static constexpr Range periods{
      [](double x) { return x >= 0 && x <= 1e7 && x == static_cast<double>(static_cast<long>(x)); },
      "a whole number from 0"};
  static constexpr Range some_periods{
      [](double x) { return x >= 1 && x <= 1e7 && x == static_cast<double>(static_cast<long>(x)); },
      "a whole number from 1"};
  static constexpr Range below_half{[](double x) { return x > 0 && x < 0.5; },
                                    "greater than 0 and below 0.5"};

  static void common_keys(auto& k, auto& x) {
    k.other({"formulation", "", "which runs", "\"nonsmooth\""}, "text", x.formulation, read_family);
    k.names({"set", "", "keys of the scene, KEY=VALUE"}, x.overrides);
    k.take({"section", "", "section at which the motion is recorded: docs/how-to/attractors.md"}, x.section);
    k.take({"period", "s", "period unit of discard and keep", "of the drive"}, x.period, positive);
    k.take({"discard", "", "discarded periods before the recorded points"}, x.discard, periods);
    k.take({"keep", "", "recorded periods"}, x.keep, some_periods);
    k.names({"columns", "", "columns that distinguish attractors; the first is plotted", "of the section"},
            x.columns);
    k.take({"tolerance", "", "tolerance for equal points, relative to a column's scale", "0.001"},
           x.tolerance, below_half);
    k.take({"most_period", "", "longest period of the search"}, x.most_period, some_periods);
    k.take({"exponents", "", "largest Lyapunov exponent of each attractor: docs/how-to/attractors.md"},
           x.exponents);
    k.take({"exponent_periods", "", "least number of periods over which it is averaged", "keep"},
           x.exponent_periods, some_periods);
    k.check(!x.exponent_periods || x.exponents, "exponent_periods", "needs exponents = true");
  }
};

/// Parameters of a bifurcation diagram.
struct BifurcationPlan : AttractorPlan {
  std::size_t axis = 0;  ///< index in the axes of the study
  /// Neighbours from whose final states runs start.
  enum class Sweeps { up, down, both, none } sweeps = Sweeps::both;
  int starts = 0;  ///< number of additional drawn starts of each value
  bool up() const { return sweeps == Sweeps::up || sweeps == Sweeps::both; }
  bool down() const { return sweeps == Sweeps::down || sweeps == Sweeps::both; }

  static void keys(auto& k, auto& x) {
    k.axis_of({"axis", "", "swept axis of the study", "the first"}, x.axis, 0);
    k.other(
        {"direction", "",
         "\"up\", \"down\" or \"both\": each value starts from the final state of its neighbour; \"none\"",
         "\"both\""},
        "text", x.sweeps, [](auto& s, auto key) {
          return static_cast<Sweeps>(s.choice(key, {"up", "down", "both", "none"}));
        });
    k.take({"starts", "", "additional random starts of each value"}, x.starts, periods);
    k.check(x.sweeps != Sweeps::none || x.starts > 0, "starts",
            "with direction = \"none\" there must be at least one start");
    common_keys(k, x);
  }
};

/// Parameters of basins of attraction.
struct BasinPlan : AttractorPlan {
  std::size_t x = 0, y = 1;  ///< indices in the axes of the study

  static void keys(auto& k, auto& x) {
    k.axis_of({"x", "", "horizontal axis of the study", "the first"}, x.x, 0);
    k.axis_of({"y", "", "vertical axis of the study", "the second"}, x.y, 1);
    k.check(x.x != x.y, "y", "must differ from axis x");
    common_keys(k, x);
  }
};

}  // namespace freeplay

// The table [continue] of a study. docs/reference/study.md lists its keys.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/scene/schema.hpp"
#include "mechanism/keys.hpp"
#include "study/settings/setting_values.hpp"
#include "values/branch.hpp"

namespace freeplay {

/// A second key, over which bifurcations are followed.
struct SecondKeyPlan {
  std::string key;
  double from = 0, to = 0;             ///< SI
  std::optional<double> step;          ///< SI
  std::vector<BifurcationKind> kinds;  ///< empty: all
  double scale = 1;                    ///< displayed value = value · scale
  std::string unit;                    ///< of the displayed value

  static void keys(auto& k, auto& x) {
    k.need({"second", "",
            "second key, over which the bifurcations are followed: curves of both keys; its value in the "
            "scene is the start",
            "–"},
           x.key);
    const auto unit = unit_of(x.key);
    k.need({"second_from", unit, "with second: one end of its range"}, x.from, any_number);
    k.need({"second_to", unit, "with second: other end of its range"}, x.to, any_number);
    k.take({"second_step", unit,
            "with second: greatest step; that of the first key has the same share of its range",
            "a fiftieth of the range"},
           x.step, positive);
    k.take({"second_scale", "", "with second: factor of its values in the figure"}, x.scale, positive);
    k.take({"second_unit", "", "with second: unit of the scaled values"}, x.unit);
    k.other({"curves", "",
             "with second: kinds that are followed: \"fold\", \"flip\", \"torus\", \"grazing\", \"liftoff\"",
             "all"},
            "names", x.kinds, read_curve_kinds);
  }
};

/// Parameters of a continuation (facade/continuation.hpp).
struct ContinuationPlan {
  std::string key;
  std::string formulation = "nonsmooth";
  double from = 0, to = 0;             ///< SI
  std::optional<double> start, step;   ///< SI
  std::vector<std::string> overrides;  ///< keys of the scene, KEY=VALUE
  int periods = 1;
  double settle = 10;
  std::optional<double> period;  ///< s
  int follow_doubled = 1, most_points = 2000;
  double scale = 1;                 ///< displayed value = value · scale
  std::string unit;                 ///< of the displayed value
  std::vector<std::string> events;  ///< expressions of the columns of branch.csv
  std::optional<SecondKeyPlan> second;

  static constexpr Range doublings{
      [](double x) { return x >= 0 && x <= 10 && x == static_cast<double>(static_cast<int>(x)); },
      "a whole number from 0 to 10"};

  static void keys(auto& k, auto& x) {
    k.need({"key", "", "key of the scene with one number; KEY[i] within a list"}, x.key);
    const auto unit = unit_of(x.key);
    k.need({"from", unit, "value of the key at which the branch begins; units as in scenes"}, x.from,
           any_number);
    k.need({"to", unit, "other end of the range of the key"}, x.to, any_number);
    k.take({"start", unit, "value within the range at which the branch begins; it is followed to both sides",
            "from"},
           x.start, any_number);
    k.take({"step", unit, "greatest step of the key", "a fiftieth of the range"}, x.step, positive);
    k.names({"set", "", "keys of the scene, KEY=VALUE"}, x.overrides);
    k.other({"formulation", "", "\"penalty\" or \"nonsmooth\"", "\"nonsmooth\""}, "text", x.formulation,
            read_family);
    k.take({"periods", "", "periods of the drive after which the motion repeats"}, x.periods, study_count);
    k.take({"settle", "", "periods of the drive before the first guess"}, x.settle, non_negative);
    k.take({"period", "s", "period of the drives; without a drive, an estimate of that of the motion",
            "of the drive"},
           x.period, positive);
    k.take({"follow_doubled", "", "number of successive period doublings whose branches are followed"},
           x.follow_doubled, doublings);
    k.take({"most_points", "", "most motions of a branch"}, x.most_points, study_count);
    k.take({"scale", "", "factor of the values of the key in the figure"}, x.scale, positive);
    k.take({"unit", "", "unit of the scaled values"}, x.unit);
    k.names(
        {"events", "", "expressions of the columns of branch.csv whose zeros are located on the branches"},
        x.events);
    if (auto* second = k.given("second", x.second)) SecondKeyPlan::keys(k, *second);
  }
};

}  // namespace freeplay

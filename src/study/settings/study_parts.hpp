// The tables [measure], [bifurcation], [basin], [continue] and [wear] of a study, and the readers of values that are
// neither numbers nor plain texts, for the verb `other` of the `keys()` visitors (io/scene/section.hpp).
// Each function reads a key that is given and throws SceneError with its position.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/continuation.hpp"
#include "io/scene/schema.hpp"
#include "mechanism/keys.hpp"

namespace freeplay {

class Section;
struct Axis;

inline constexpr Range study_count{
    [](double x) { return x >= 1 && x <= 1e6 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 1"};

std::string read_family(Section& s, std::string_view key);
std::vector<std::string> read_families(Section& s, std::string_view key);
inline constexpr auto read_logarithmic = [](auto& s, std::string_view key) {
  return s.choice(key, {"linear", "log"}) == 1;
};
std::vector<BifurcationKind> read_curve_kinds(Section& s, std::string_view key);
/// The keys of the scene that an axis varies.
void read_varied(Section& s, Axis& axis);
/// The values of an axis: a list, or a range.
void read_values(Section& s, Axis& axis);

// Measure: one column of a run's result tables, reduced to a number over the window from the
// discarded time to the end, by
//
//     mean, rms, std   over time, by the trapezoidal rule between rows:
//                      (1/T)∫x dt, √((1/T)∫x² dt), √((1/T)∫(x − mean)² dt)
//     min, max, peak   of the rows and the ends of all steps; peak is the greatest |x|
//     quantile         of the rows, linear between sorted values
//     first, last, count   of the rows
//
// The reduction is taken over the whole window; or over each whole period in it, then averaged over
// the periods; or over the points of a Poincaré section (simulation/section.hpp), all with equal
// weight. Rows are those of trajectory.csv in the window, with an additional row at its beginning
// and at the beginning of each period. For signals, rows are the samples, with equal weight.

/// Reductions of a column to a number, as defined above.
enum class Reduce { mean, rms, min, max, peak, first, last, std, quantile, count };
inline constexpr auto reduce_names = complete<Reduce>({{Reduce::mean, "mean"},
                                                       {Reduce::rms, "rms"},
                                                       {Reduce::min, "min"},
                                                       {Reduce::max, "max"},
                                                       {Reduce::peak, "peak"},
                                                       {Reduce::first, "first"},
                                                       {Reduce::last, "last"},
                                                       {Reduce::std, "std"},
                                                       {Reduce::quantile, "quantile"},
                                                       {Reduce::count, "count"}});

constexpr const auto& choices(Reduce) { return reduce_names; }

/// A measure as the study states it. It is evaluated by study/runs/measurer.hpp.
struct Measure {
  std::string name;
  /// A column of trajectory.csv or forces.csv, an instrument, or a path in run.json.
  std::string column;
  Reduce reduce = Reduce::mean;
  double q = 0.5;  ///< probability of the quantile
  bool each_period = false;
  std::string at;  ///< text of the section; empty: none
  /// @name Difference of the mean turn from that of a measured file (measure/waveform.hpp), instead
  /// of a reduced column
  ///@{
  std::filesystem::path waveform = {};
  std::string digest = {};                  ///< of the file
  double tolerance = 0;                     ///< relative uncertainty of the file
  std::vector<std::string> overrides = {};  ///< keys of the scene with which the file was measured
  ///@}

  static void keys(auto& k, auto& x) {
    k.need({"column", "", "column of trajectory.csv or forces.csv, an instrument, or a number of run.json"},
           x.column);
    k.need({"reduce", "", ""}, x.reduce);
    if (k.when(x.reduce == Reduce::quantile, {"q"}, "applies only to reduce = \"quantile\""))
      k.need({"q", "", "probability of the quantile, from 0 to 1"}, x.q, zero_to_one);
    k.other({"each", "", "\"period\": reduced over each period, then their mean"}, "text", x.each_period,
            [](auto& s, auto key) { return s.choice(key, {"period"}) == 0; });
    k.take({"at", "",
            "section: only its points are evaluated; \"every period\", \"JOINT.angle crosses VALUE "
            "upwards\", \"each touch\"",
            "–"},
           x.at);
    k.check(!x.each_period || x.at.empty(), "each",
            "and at both select parts of the window; give one of them");
  }
};

/// One line that states all of the measure, for identities.
std::string said(const Measure& measure);

// The tables [bifurcation] and [basin] of a study. docs/reference/study.md lists their keys.

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

// The table [continue] of a study. docs/reference/study.md lists its keys.

/// A continuation without its events, and the display of its keys.
struct ContinuationPlan : ContinuationRequest {
  std::vector<std::string> overrides;    ///< keys of the scene, KEY=VALUE
  double scale = 1, second_scale = 1;    ///< displayed value = value · scale
  std::string unit, second_unit;         ///< of the displayed values
  std::vector<std::string> expressions;  ///< of the columns of branch.csv, for `events`

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
        x.expressions);
    if (auto* second = k.given("second", x.second)) {
      k.need({"second", "",
              "second key, over which the bifurcations are followed: curves of both keys; its value in the "
              "scene is the start",
              "–"},
             second->key);
      const auto second_unit = unit_of(second->key);
      k.need({"second_from", second_unit, "with second: one end of its range"}, second->from, any_number);
      k.need({"second_to", second_unit, "with second: other end of its range"}, second->to, any_number);
      k.take({"second_step", second_unit,
              "with second: greatest step; that of the first key has the same share of its range",
              "a fiftieth of the range"},
             second->step, positive);
      k.take({"second_scale", "", "with second: factor of its values in the figure"}, x.second_scale,
             positive);
      k.take({"second_unit", "", "with second: unit of the scaled values"}, x.second_unit);
      k.other(
          {"curves", "",
           "with second: kinds that are followed: \"fold\", \"flip\", \"torus\", \"grazing\", \"liftoff\"",
           "all"},
          "names", second->kinds, read_curve_kinds);
    }
  }
};

// The table [wear] of a study. docs/reference/study.md lists its keys.

/// Where the wear of a scene's bearings ends, and how its cycles are chosen (study/wear/wear_cycles.hpp).
struct WearPlan {
  std::vector<std::string> overrides;  ///< keys of the scene, KEY=VALUE
  /// Ends: number of turns; m, depth of one surface; m, measured clearance of a joint. At least one.
  std::optional<double> turns, depth, clearance;
  double share = 0.05;                   ///< greatest relative change of clearance and rates in a cycle
  std::optional<double> longest;         ///< turns of a cycle, at most
  int points = 720;                      ///< angles of each surface
  std::optional<double> life_clearance;  ///< m, for the verdict

  static constexpr Range angles{
      [](double x) { return x >= 90 && x <= 7200 && x == static_cast<double>(static_cast<int>(x)); },
      "a whole number from 90 to 7200"};
  static constexpr Range of_change{[](double x) { return x >= 1e-4 && x <= 0.5; }, "from 0.0001 to 0.5"};

  static void keys(auto& k, auto& x) {
    k.names({"set", "", "keys of the scene, KEY=VALUE"}, x.overrides);
    k.take({"turns", "", "wear ends after this number of turns: periods of the study", "–"}, x.turns,
           one_or_more);
    k.take({"depth", "m", "wear ends at this depth of a surface", "–"}, x.depth, positive);
    k.take(
        {"clearance", "m",
         "wear ends at this measured radial clearance of a joint: half of the greatest free movement", "–"},
        x.clearance, positive);
    k.check(x.turns || x.depth || x.clearance, "turns", "is missing: give turns, depth or clearance");
    k.take({"share", "",
            "greatest relative change of the clearance and of the rates of wear in a cycle of extrapolation"},
           x.share, of_change);
    k.take({"longest", "", "greatest number of turns of a cycle; that of a run: no extrapolation", "–"},
           x.longest, one_or_more);
    k.take({"points", "", "number of angles of each worn surface"}, x.points, angles);
    k.take(
        {"life_clearance", "m", "measured radial clearance whose number of turns is the life", "clearance"},
        x.life_clearance, positive);
  }
};

/// continue.json, without provenance. The lists: of an earlier result whose branches go on.
nlohmann::json to_json(const ContinuationPlan& plan, const Branches& found, std::vector<BranchEnd> ends,
                       nlohmann::json bifurcations);

}  // namespace freeplay

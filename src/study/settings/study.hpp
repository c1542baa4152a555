// Study: a scene, the parameters that are varied, the number of runs, and the evaluation of their
// results, as read from a study file. docs/reference/study.md lists the keys. A Study is a plain
// value, which the other folders of src/study evaluate.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/files/access.hpp"
#include "io/scene/schema.hpp"
#include "measure/turns.hpp"
#include "mechanism/error.hpp"
#include "mechanism/keys.hpp"
#include "study/runs/perturb.hpp"
#include "study/settings/measured_rows.hpp"
#include "study/settings/study_parts.hpp"
#include "values/family.hpp"

namespace freeplay {

/// Range of the drawn values of an axis (Design::method).
struct DrawnRange {
  double low = 0, high = 0;
  bool logarithmic = false;
};

/// A parameter of the study: one key of the scene, or several that vary together, and their values.
struct Axis {
  std::string name, key;
  std::vector<double> values;  ///< empty if the values are drawn
  double scale = 1;            ///< displayed value = value · scale
  std::string unit;            ///< of the displayed value
  /// Keys that vary with it, and their values at the same positions.
  std::vector<std::string> others = {};
  std::vector<std::vector<double>> other_values = {};
  using Drawn = DrawnRange;
  std::optional<Drawn> drawn = {};

  static void keys(auto& k, auto& x) {
    k.together({{{"key", "", "scene key that varies; or keys"}, "text"},
                {{"keys", "", "several keys that vary together"}, "names"}},
               x, read_varied);
    k.together({{{"values", "",
                  "values, as texts with units if needed; for several keys also one list per point, [[a, b], "
                  "...]"},
                 "numbers"},
                {{"range", "", "[low, high, n]: n evenly spaced values, in place of a list"}, "numbers"},
                {{"log_range", "", "[low, high, n]: n values with equal ratios"}, "numbers"}},
               x, read_values);
    if (auto* drawn = k.given("low", x.drawn)) {
      const auto unit = unit_of(x.key);
      k.need({"low", unit, "least value of an axis with random values", "–"}, drawn->low, any_number);
      k.need({"high", unit, "greatest value of an axis with random values", "–"}, drawn->high, any_number);
      k.other({"spacing", "", "distribution of random values; or \"log\"", "\"linear\""}, "text",
              drawn->logarithmic, read_logarithmic);
    }
    k.take({"unit", "", "as shown"}, x.unit);
    k.take({"scale", "", "displayed value / value of the key"}, x.scale, positive);
  }
};

/// Choice of the points of drawn axes (unit_points()).
enum class DrawMethod { random, latin_hypercube, sobol };
inline constexpr auto draw_names = complete<DrawMethod>({{DrawMethod::random, "random"},
                                                         {DrawMethod::latin_hypercube, "latin-hypercube"},
                                                         {DrawMethod::sobol, "sobol"}});
constexpr const auto& choices(DrawMethod) { return draw_names; }

/// The points of drawn axes, and the cells that run.
struct Design {
  std::optional<DrawMethod> method;
  int samples = 0;    ///< number of drawn points
  std::string where;  ///< condition for the cells of the axes; empty: none
};

/// A derived column: an expression of the other columns of a run and of columns derived before it.
struct Derived {
  std::string name, expression;
};

/// The scene with some keys set. It may be another scene file, and may have fewer runs than the
/// study.
struct Variant {
  std::string name, title;
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::vector<std::string> formulations;
  int starts = 1;
  double revolutions = 0;
  /// Hz, sampling rate of the measurement its runs are compared with; 0: the instruments' own.
  double sampling = 0;
  double noise = 0;  ///< m/s², standard deviation of the noise of that measurement's samples
  std::vector<std::string> unknowns = {};  ///< names of those of MeasuredRows that are fitted in it

  static void keys(auto& k, auto& x) {
    k.take({"title", "", "what the variant changes", "its name"}, x.title);
    k.take({"scene", "", "another scene file", "the study's"}, x.scene);
    k.names({"set", "", "keys of the scene, KEY=VALUE"}, x.overrides);
    k.other({"formulations", "", "as in the study", "the study's"}, "names", x.formulations, read_families);
    k.take({"starts", "", "as in the study", "the study's"}, x.starts, study_count);
    k.take({"revolutions", "", "as in the study", "the study's"}, x.revolutions, one_or_more);
    k.names({"unknowns", "", "unknowns of [rows] that are fitted in this variant", "all"}, x.unknowns);
  }
};

/// Segments of a measured file, each as long as a run; calibration fits to the mean of their
/// statistics. A motion may stay in one of several states for the whole file. Then its segments
/// agree better with each other than runs from different starts do, and their mean is as uncertain
/// as the choice of the state. With W the variance of one run and w the variance between segments,
/// the mean has the variance
///
///     W share(W) = max(W − w, 0) + min(w, W)/count        (between states, and within one).
struct Stretches {
  int count = 1;
  double spread = 0;   ///< w, of the logarithms; 0 for a single segment
  bool known = false;  ///< the target's tolerance includes the scatter
  double share(double scatter) const {
    if (known) return 0;
    if (count < 2 || !(scatter > 0)) return 1.0 / count;
    const double within = std::min(1.0, spread / scatter);
    return 1 - within + within / count;
  }
};

/// A measured value that calibration fits: of the scene with some keys set.
struct Target {
  std::string name;
  std::vector<std::string> overrides;
  /// One of TurnMetrics, a measure of the study, or a quantity of analysis/sensitivity.hpp such as
  /// event.1.t, whose name contains a dot.
  std::string statistic;
  double value = 0;            ///< measured value; computed from `data` if that is given
  double tolerance = 0;        ///< relative standard uncertainty
  double deviation = 0;        ///< standard uncertainty in SI units of a quantity; 0: by `tolerance`
  std::filesystem::path data;  ///< signals file from which the statistic is computed
  /// Properties of that file, set when it is read.
  double sampling = 0;  ///< Hz
  double noise = 0;     ///< m/s², standard deviation of the noise of each sample
  int turns = 0;        ///< number of turns of a run and of each segment of the file
  Stretches stretches;  ///< segments whose mean statistic is `value`
  /// @name A measured time series, which is compared sample by sample (study/calibration/series_fit.hpp)
  ///@{
  std::string channel;                ///< column of trajectory.csv or forces.csv, or instrument
  std::vector<std::string> columns;   ///< of `data`: time (s) and value; empty: the first two
  std::string against;                ///< a further column of `data`, over which flanks are compared
  std::string unit;                   ///< SI unit of `against`, for figures
  std::vector<double> levels;         ///< of |value| on the flanks, increasing; empty: none are compared
  std::optional<double> from, until;  ///< s, the compared time
  bool hold_out = false;              ///< predicted, not fitted
  ///@}
  bool is_quantity() const { return statistic.find('.') != std::string::npos; }
  /// Whether the mean turn of runs is compared with that of `data`, by a measure of the study.
  bool is_waveform() const { return statistic == "waveform"; }
  /// Whether a column of one run is compared with the samples of `data`.
  bool is_series() const { return statistic == "series"; }
  /// Name of the measure that provides the statistic; for others its own name.
  std::string measure() const { return is_waveform() ? "waveform_" + name : statistic; }

  static void keys(auto& k, auto& x) {
    k.names({"set", "", "keys of the scene for this target, KEY=VALUE"}, x.overrides);
    k.need({"statistic", "",
            "statistic of a run (docs/reference/study.md lists them), measure of the study, \"waveform\", "
            "\"series\", or quantity such as event.1.t"},
           x.statistic);
    if (k.when(!x.is_waveform() && !x.is_series())) k.take({"value", "", "as measured", "–"}, x.value);
    if (k.when(!x.is_quantity()))
      k.take({"data", "", "measured file for computing the statistic, in place of value"}, x.data);
    if (k.when(!x.is_series()))
      k.take({"tolerance", "", "relative standard uncertainty of the value; of a waveform 0.01", "0.1"},
             x.tolerance, positive);
    if (k.when(x.is_series())) {
      k.need({"channel", "", "series: column of trajectory.csv or forces.csv, or instrument"}, x.channel);
      k.names({"columns", "", "series: columns of data for time (s) and value", "the first two"}, x.columns);
      k.take({"from", "s", "series: beginning of the compared time", "that of data"}, x.from, any_number);
      k.take({"until", "s", "series: end of the compared time", "that of data"}, x.until, any_number);
      k.take({"against", "", "series: column of data over which flanks are compared, such as a displacement",
              "–"},
             x.against);
      k.take({"unit", "", "series: SI unit of that column, for figures"}, x.unit);
      k.other(
          {"levels", "",
           "series: |value|, increasing, at which flanks after a change of sign are compared; with against",
           "–"},
          "numbers", x.levels, [](auto& s, auto key) { return s.numbers(key); });
      k.take({"hold_out", "", "series: true: predicted with the fitted unknowns, not fitted"}, x.hold_out);
    }
    if (k.when(x.is_quantity()))
      k.take({"deviation", "", "standard uncertainty of a quantity in SI units, in place of tolerance", "–"},
             x.deviation, positive);
  }
};

/// Parameters of a calibration (study/calibration/calibrate.hpp).
struct Calibration {
  std::string formulation = "nonsmooth";
  int points = 64, starts = 2, refinements = 8;
  double revolutions = 20;
  bool leave_out = true;  ///< also fit without each target
  std::vector<Unknown> unknowns;
  std::vector<Target> targets;

  static void keys(auto& k, auto& x) {
    k.other({"formulation", "", "which is fitted", "\"nonsmooth\""}, "text", x.formulation, read_family);
    k.take({"points", "", "number of points of the space-filling design for the response surface"}, x.points,
           study_count);
    k.take({"starts", "", "perturbed starts for each point and target"}, x.starts, study_count);
    k.take({"revolutions", "",
            "evaluated revolutions of each run; at most the complete revolutions of a target's file"},
           x.revolutions, one_or_more);
    k.take({"refinements", "", "greatest number of refinements where the misfit is small; a whole number"},
           x.refinements, whole);
    k.take({"leave_out", "", "also fit without each target and predict it"}, x.leave_out);
    k.tables("unknowns", "an unknown", x.unknowns);
    k.tables("targets", "a target", x.targets);
    k.check(!x.unknowns.empty(), "unknowns", "must name at least one unknown");
    k.check(!x.targets.empty(), "targets", "must name at least one target");
  }
};

/// Length of the runs of a study, in periods or in seconds.
struct RunLength {
  double revolutions = 0, discard = 0;  ///< periods
  bool in_periods = false;              ///< whether the study states one of these two
  std::optional<double> period;         ///< s, used instead of the drive's period
  std::optional<double> duration;       ///< s, evaluated time of each run, instead of `revolutions`
  std::optional<double> discard_time;   ///< s, instead of `discard`
};

/// Perturbed starts of the cases of a study.
struct StudyStarts {
  int count = 1;
  bool given = false;      ///< whether the study or a variant states the number
  std::uint64_t seed = 1;  ///< also of the points of drawn axes
  Perturbation perturbation;
};

/// Contents of a study file.
struct Study {
  std::filesystem::path file;
  Reach reach = Reach::anywhere;  ///< permitted location of named files
  std::string text, title;
  std::filesystem::path scene;
  /// Study whose calibration defines the variant "calibrated"; may be empty.
  std::filesystem::path fit;
  /// Name of a list of published findings to verify; may be empty.
  std::string claims;
  /// Measured values at points of the axes, a CSV file; may be empty.
  std::filesystem::path points;
  /// Contacts whose flights and impacts are counted; empty: all.
  std::vector<std::string> joints;
  std::vector<std::string> formulations = family_names();
  std::string accelerometer, position;  ///< instruments; may be empty
  /// Whether the impact law takes the restitution that the penalty law delivers.
  bool matched = true;
  RunLength length;
  StudyStarts starts;
  TurnThresholds thresholds;
  std::vector<Axis> axes;
  Design design;
  std::vector<Measure> measures;
  std::vector<Derived> derived;
  /// Units of measures and derived columns, as figures show them.
  std::vector<std::pair<std::string, std::string>> units;
  std::optional<MeasuredRows> rows;
  std::vector<Variant> variants;
  std::optional<Calibration> calibration;
  std::optional<BifurcationPlan> bifurcation;
  std::optional<BasinPlan> basin;
  std::optional<ContinuationPlan> continuation;
  std::optional<WearPlan> wear;

  static constexpr Range below_one{[](double x) { return x >= 0 && x < 1; }, "at least 0 and below 1"};

  /// A visitor with a member type `OfRuns` visits only the settings that affect the results of single
  /// runs: neither their number nor their evaluation.
  static void keys(auto& k, auto& x) {
    constexpr bool all = !requires { typename std::decay_t<decltype(k)>::OfRuns; };
    if constexpr (all) {
      k.take({"title", "", "title of the study"}, x.title);
      k.need({"scene", "", "scene file, relative to the study's"}, x.scene);
      k.take({"claims", "",
              "what `validate` compares with: \"flores2011\" (published findings), \"points\" (measured "
              "values) or \"rows\" (measured runs of [rows])",
              "–"},
             x.claims);
      k.take({"points", "",
              "CSV file with the measured values of claims = \"points\": columns quantity, value, "
              "uncertainty and the axes"},
             x.points);
      k.take(
          {"fit", "", "study with a calibration that `validate` runs first; adds a variant \"calibrated\""},
          x.fit);
    }
    k.other({"joint", "",
             "joints and contacts for the statistics of flights and impacts; `validate` and `calibrate` need "
             "one",
             "all"},
            "text or names", x.joints, [](auto& s, auto key) { return s.name_or_names(key); });
    k.take(
        {"accelerometer", "", "instrument of the evaluated signal; `validate` and `calibrate` need it", "–"},
        x.accelerometer);
    k.take({"position", "", "LVDT with the same sampling", "–"}, x.position);
    if constexpr (all)
      k.other({"formulations", "", "\"penalty\", \"nonsmooth\"", "both"}, "names", x.formulations,
              read_families);
    k.other({"restitution", "",
             "restitution of the impact law: \"delivered\" (effective value of the penalty law), or "
             "\"as-given\" (input)",
             "\"delivered\""},
            "text", x.matched, [](auto& s, auto key) {
              return s.choice(key, {"delivered", "as-given"}) == 0;
            });
    if constexpr (all) {
      k.take({"period", "s",
              "duration of one revolution; default: that of the drive of prescribed speed, or the period of "
              "the curves",
              "the drive's"},
             x.length.period, positive);
      k.take({"revolutions", "", "evaluated periods of each run", "50"}, x.length.revolutions, one_or_more);
    }
    k.take({"discard", "", "discarded periods before those", "2"}, x.length.discard, non_negative);
    if constexpr (all) {
      k.take({"duration", "s", "evaluated duration of each run, in place of revolutions and discard"},
             x.length.duration, positive);
      k.take({"discard_time", "s", "before that", "0"}, x.length.discard_time, non_negative);
      k.take({"starts", "", "perturbed starts of each case; 1 if a scene has none", "8"}, x.starts.count,
             study_count);
    }
    k.take({"seed", "", "seed of the starts and random points; a whole number"}, x.starts.seed, whole);
    k.take({"turn", "", "range of the random initial crank angle, as a share of a revolution"},
           x.starts.perturbation.turn, zero_to_one);
    k.take({"play", "", "range of the random initial offsets, as a share of the clearance"},
           x.starts.perturbation.play, below_one);
    k.take({"flight_angle", "degrees", "shortest counted flight, as crank angle"}, x.thresholds.flight_angle,
           non_negative);
    k.take({"impact_speed", "m/s", "least approach speed of counted impacts"}, x.thresholds.impact_speed,
           non_negative);
    k.take({"line_share", "",
            "least amplitude of dominant spectral lines, as a share of the greatest ideal acceleration"},
           x.thresholds.line_share, positive);
    if constexpr (all) {
      k.choose({"sample", "", "design of the random values of axes with low and high: "}, x.design.method);
      if (k.when(x.design.method.has_value(), {"samples"}, "needs sample, the design of the random values"))
        k.need({"samples", "", "number of random points", "–"}, x.design.samples, study_count);
      k.take({"where", "", "condition for running a cell, an expression of the axes", "–"}, x.design.where);
      k.tables("axes", "an axis", x.axes);
      k.tables("measure", "a measure", x.measures);
      k.texts({"derived", "", "NAME = \"expression of axes, statistics and measures\", any number of them"},
              x.derived);
      k.texts({"units", "",
               "NAME = \"unit\" of measures and derived quantities, as figures show it; default of a "
               "measure: that of its column"},
              x.units);
      k.part("rows", "[rows]", x.rows);
      k.tables("variants", "a variant", x.variants);
      k.part("calibrate", "[calibrate]", x.calibration);
      k.part("bifurcation", "[bifurcation]", x.bifurcation);
      k.part("basin", "[basin]", x.basin);
      k.part("continue", "[continue]", x.continuation);
      k.part("wear", "[wear]", x.wear);
    }
  }
};

/// The settings that affect every run, with the values in force, one line KEY = VALUE each.
std::string settings_text(const Study& study);

/// Names that expressions of a study may contain, in the order of a run's values: axes, and with
/// `results` also statistics and measures.
std::vector<std::string> names_of(const Study& study, bool results);

/// An error at a key of the study, `path` from its root, as "FILE:LINE:COL: path: message".
SceneError error_at(const Study& study, const std::vector<std::string>& path, const std::string& message);

/// Moves an error about a scene key to the position in the study that sets this key; returns other
/// errors unchanged.
SceneError in_study(const Study& study, const SceneError& error);

/// The schema of studies.
const Schema& study_schema();

/// Reads a study. Throws SceneError, also for a named file outside `reach`.
Study read_study(const std::filesystem::path& file, Reach reach = Reach::anywhere);

// Design of experiments: points in the unit cube and the parameter combinations (cells) of a study.
// The points are chosen by one of
//
// - random: all coordinates uniform and independent
// - latin-hypercube: for n points, each of n equal intervals of every coordinate contains one point
//   at a random position; the intervals are combined by random permutations (McKay, Beckman and
//   Conover, Technometrics 21 (1979) 239)
// - sobol: the first n points after the origin of Sobol's sequence in Gray-code order, with the
//   direction numbers of Joe and Kuo (SIAM J. Sci. Comput. 30 (2008) 2635); deterministic
//
// Equal arguments give equal bits on every machine. The functions keep no state.

/// `count` points of `dimensions` coordinates in [0, 1). Sobol's sequence ignores `seed`.
std::vector<std::vector<double>> unit_points(DrawMethod how, std::size_t dimensions, int count,
                                             std::uint64_t seed);

/// One combination of the axes' values.
struct Cell {
  std::vector<double> values;          ///< one for each axis: the value of its first key
  std::vector<std::string> overrides;  ///< KEY=VALUE of every key
};

/// Number of cells before study.design.where excludes some.
std::size_t unfiltered(const Study& study);

/// All cells: each drawn point with every combination of the other axes, the first axis varying
/// fastest, without those that study.design.where excludes. Throws SceneError if it excludes all.
std::vector<Cell> cells(const Study& study);

// Provenance of results that were made from a whole study.

/// The provenance of the study's scene, and the study's text for users. The identity contains the
/// scene, the statements of the study, and a digest of each file that the study names: of scenes by
/// their canonical text, of studies by their statements, of measured files by their bytes. Throws
/// SceneError.
nlohmann::json provenance(const Study& study);

}  // namespace freeplay

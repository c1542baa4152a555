// Study: a scene, the parameters that are varied, the number of runs, and the evaluation of their
// results, as read from a study file. docs/reference/study.md lists the keys. A Study is a plain
// value, which the other folders of src/study evaluate.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/scene/named_file.hpp"
#include "mechanism/error.hpp"
#include "mechanism/keys.hpp"
#include "study/attractors/attractor_plan.hpp"
#include "study/runs/perturb.hpp"
#include "study/settings/continuation_plan.hpp"
#include "study/settings/measure.hpp"

namespace freeplay {

/// A parameter of the study: one key of the scene, or several that vary together, and their values.
struct Axis {
  std::string name, key;
  std::vector<double> values;  ///< empty if the values are drawn
  double scale = 1;            ///< displayed value = value · scale
  std::string unit;            ///< of the displayed value
  /// Keys that vary with it, and their values at the same positions.
  std::vector<std::string> others = {};
  std::vector<std::vector<double>> other_values = {};
  /// Range of drawn values (Study::sampling).
  struct Drawn {
    double low = 0, high = 0;
    bool logarithmic = false;
  };
  std::optional<Drawn> drawn = {};
};

/// Choice of the points of drawn axes (study/settings/design.hpp).
enum class DrawMethod { random, latin_hypercube, sobol };
inline constexpr auto draw_names = complete<DrawMethod>({{DrawMethod::random, "random"},
                                                         {DrawMethod::latin_hypercube, "latin-hypercube"},
                                                         {DrawMethod::sobol, "sobol"}});

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
};

/// A parameter that calibration identifies.
struct Unknown {
  std::string name, key, unit;
  double low = 0, high = 0;
  bool logarithmic = false;
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
  /// One of TurnMetrics, a measure of the study, or a quantity of facade/sensitivity.hpp such as
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
  bool is_quantity() const { return statistic.find('.') != std::string::npos; }
  /// Whether the mean turn of runs is compared with that of `data`, by a measure of the study.
  bool is_waveform() const { return statistic == "waveform"; }
  /// Name of the measure that provides the statistic; for others its own name.
  std::string measure() const { return is_waveform() ? "waveform_" + name : statistic; }
};

/// Parameters of a calibration (study/calibration/calibrate.hpp).
struct Calibration {
  std::string formulation = "nonsmooth";
  int points = 64, starts = 2, refinements = 8;
  double revolutions = 20;
  bool leave_out = true;  ///< also fit without each target
  std::vector<Unknown> unknowns;
  std::vector<Target> targets;
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
  std::string accelerometer, position;  ///< instruments; may be empty
  /// Whether the impact law takes the restitution that the penalty law delivers.
  bool matched = true;
  double revolutions = 0, discard = 0;  ///< periods
  bool in_periods = false;              ///< whether the study states one of these two
  std::optional<double> period;         ///< s, used instead of the drive's period
  std::optional<double> duration;       ///< s, evaluated time of each run, instead of `revolutions`
  std::optional<double> discard_time;   ///< s, instead of `discard`
  int starts = 1;
  bool starts_given = false;
  std::uint64_t seed = 1;
  Perturbation perturbation;
  double flight_angle = 2, impact_speed = 0.01, line_share = 0.05;
  std::vector<Axis> axes;
  std::optional<DrawMethod> sampling;
  int samples = 0;
  std::string where;  ///< condition for the cells of the axes; empty: none
  std::vector<Measure> measures;
  std::vector<Derived> derived;
  /// Units of measures and derived columns, as figures show them.
  std::vector<std::pair<std::string, std::string>> units;
  std::vector<Variant> variants;
  std::optional<Calibration> calibration;
  std::optional<BifurcationPlan> bifurcation;
  std::optional<BasinPlan> basin;
  std::optional<ContinuationPlan> continuation;
};

/// The settings that affect every run, with the values in force, one line KEY = VALUE each.
std::string settings_text(Study study);

/// Names that expressions of a study may contain, in the order of a run's values: axes, and with
/// `results` also statistics and measures.
std::vector<std::string> names_of(const Study& study, bool results);

/// An error at a key of the study, `path` from its root, as "FILE:LINE:COL: path: message".
SceneError error_at(const Study& study, const std::vector<std::string>& path, const std::string& message);

/// Moves an error about a scene key to the position in the study that sets this key; returns other
/// errors unchanged.
SceneError in_study(const Study& study, const SceneError& error);

/// Reads a study. Throws SceneError, also for a named file outside `reach`.
Study read_study(const std::filesystem::path& file, Reach reach = Reach::anywhere);

}  // namespace freeplay

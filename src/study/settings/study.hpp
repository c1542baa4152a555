// A study: one scene, what is varied in it, and how often. Keys are listed in docs/reference/study.md.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/scene/named_file.hpp"
#include "mechanism/error.hpp"
#include "mechanism/keys.hpp"
#include "study/attractors/attractor_plan.hpp"
#include "study/runs/perturb.hpp"
#include "study/settings/measure.hpp"

namespace freeplay {

/// A scene key, or several that vary together, and the values it takes.
struct Axis {
  std::string name, key;
  std::vector<double> values;  ///< none where they are drawn
  double scale = 1;            ///< shown value = value · scale
  std::string unit;            ///< of the shown value
  /// Keys that vary with it, and each one's values at the same places.
  std::vector<std::string> others = {};
  std::vector<std::vector<double>> other_values = {};
  /// Values are drawn from here (Study::sampling).
  struct Drawn {
    double low = 0, high = 0;
    bool logarithmic = false;
  };
  std::optional<Drawn> drawn = {};
};

/// How the points of the axes that are drawn are chosen (study/settings/design.hpp).
enum class Draw { random, latin_hypercube, sobol };
inline constexpr auto draw_names = complete<Draw>(
    {{Draw::random, "random"}, {Draw::latin_hypercube, "latin-hypercube"}, {Draw::sobol, "sobol"}});

/// A column of results that is computed from the others of a run and those derived before it.
struct Derived {
  std::string name, expression;
};

/// The scene with some keys set; it may be another scene file, and may run less than the whole study.
struct Variant {
  std::string name, title;
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::vector<std::string> formulations;
  int starts = 1;
  double revolutions = 0;
  double sampling = 0;  ///< Hz, of the measurement that its runs are held against; 0: the instruments' own
  double noise = 0;     ///< m/s², standard, of each of that measurement's samples
};

/// What calibration may change.
struct Unknown {
  std::string name, key, unit;
  double low = 0, high = 0;
  bool logarithmic = false;
};

/// The stretches of a measured file, each as long as a run, whose mean statistic is fitted to. A motion may keep to one of several
/// states for the whole file: its stretches then agree better with each other than runs from other starts do, and their mean is
/// as uncertain as the choice of state. With W the scatter of one run and w the variance between stretches, the mean has
///
///     W share(W) = max(W − w, 0) + min(w, W)/count        (between states, and within one).
struct Stretches {
  int count = 1;
  double spread = 0;  ///< w, of the logarithms; 0 of a single one
  double share(double scatter) const {
    if (count < 2 || !(scatter > 0)) return 1.0 / count;
    const double within = std::min(1.0, spread / scatter);
    return 1 - within + within / count;
  }
};

/// What calibration shall meet: a statistic of the scene with some keys set, as measured.
struct Target {
  std::string name;
  std::vector<std::string> overrides;
  std::string statistic;       ///< of TurnMetrics, or a measure of the study
  double value = 0;            ///< measured; from `data` when that is given
  double tolerance = 0;        ///< relative standard uncertainty
  std::filesystem::path data;  ///< a signals file that the statistic is computed from
  /// Of that file, once it is read.
  double sampling = 0;  ///< Hz
  double noise = 0;     ///< m/s², standard, of each sample
  int turns = 0;        ///< that a run counts, and each stretch of the file
  Stretches stretches;  ///< whose mean statistic `value` is
};

struct Calibration {
  std::string formulation = "nonsmooth";
  int points = 64, starts = 2, refinements = 3;
  double revolutions = 20;
  std::vector<Unknown> unknowns;
  std::vector<Target> targets;
};

struct Study {
  std::filesystem::path file;
  Reach reach = Reach::anywhere;  ///< what it may name
  std::string text, title;
  std::filesystem::path scene;
  std::filesystem::path fit;        ///< study whose calibration adds the variant "calibrated"; may be empty
  std::string claims;               ///< name of a list of published findings to judge
  std::vector<std::string> joints;  ///< whose contacts flights and impacts are taken from; none: all
  std::string accelerometer, position;  ///< instruments; may be empty
  bool matched = true;  ///< the impact law takes the restitution that the penalty law delivers
  double revolutions = 0, discard = 0;  ///< periods
  bool in_periods = false;              ///< the study states one of these two
  std::optional<double> period;         ///< s, given in place of the drive's
  std::optional<double> duration;       ///< s, counted in each run, in place of `revolutions`
  std::optional<double> discard_time;   ///< s, in place of `discard`
  int starts = 1;
  bool starts_given = false;
  std::uint64_t seed = 1;
  Perturbation perturbation;
  double flight_angle = 2, impact_speed = 0.01, line_share = 0.05;
  std::vector<Axis> axes;
  std::optional<Draw> sampling;
  int samples = 0;
  std::string where;  ///< what a cell of the axes must satisfy; empty: nothing
  std::vector<Measure> measures;
  std::vector<Derived> derived;
  std::vector<Variant> variants;
  std::optional<Calibration> calibration;
  std::optional<BifurcationPlan> bifurcation;
  std::optional<BasinPlan> basin;
};

/// The settings that every run of the study depends on, with the value in force, a line KEY = VALUE each.
std::string settings_text(Study study);

/// What expressions of a study may speak of, in the order of a run's values: axes, and with `results` statistics and measures.
std::vector<std::string> names_of(const Study& study, bool results);

/// An error at a key of the study, `path` from its root: FILE:LINE:COL: path: message.
SceneError error_at(const Study& study, const std::vector<std::string>& path, const std::string& message);

/// An error of a key of the scene that the study itself sets, at the place in the study that sets it; others as they are.
SceneError in_study(const Study& study, const SceneError& error);

/// Throws SceneError, also for a file that it names beyond its `reach`.
Study read_study(const std::filesystem::path& file, Reach reach = Reach::anywhere);

}  // namespace freeplay

// Measurer: evaluates the measures of a study (study/settings/measure.hpp) during one run, by
// observers. It stores sums, and all values only for quantiles.
//
// Use: construct with the scene and layout, attach observers() to the run, then call finish(). Owns
// its observers; refers to the study.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "simulation/observer.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

struct Result;
struct Scene;
class Simulation;

/// The evaluated part of a run.
struct CountedTime {
  double from = 0, to = 0;  ///< s
  double period = 0;        ///< s; 0 if unknown
};

/// Value of one measure.
struct MeasureValue {
  double value = 0;  ///< NaN if absent
  /// The value of one period or section point.
  struct Part {
    double t = 0, value = 0;  ///< s, beginning of a period, or time of a section point
  };
  std::vector<Part> parts;  ///< values of the periods or section points
};

/// Evaluates all measures of a study in one run.
class Measurer {
 public:
  /// Throws SceneError, with the position in the study, for a measure that the scene cannot
  /// provide.
  Measurer(const Study& study, const Scene& scene, const Layout& layout, CountedTime time);
  ~Measurer();
  Measurer(const Measurer&) = delete;
  Measurer& operator=(const Measurer&) = delete;

  /// Observers for all runs of the simulation up to the end of the window.
  std::vector<Observer*> observers() const;
  /// Time (s) before which these need no step, except the last one before it and the steps of events.
  double next_shown() const;
  /// Those that need the states of all steps.
  std::vector<Observer*> followers() const;
  /// Measures whose column is in no table, and may be a number of run.json.
  std::vector<Measure> numbers_of_runs() const;
  /// The values after the last run, in the order of the study. `result`: of that run.
  std::vector<MeasureValue> finish(Result result) const;

 private:
  class Statistics;
  class Track;
  class Rows;
  class Points;
  std::vector<std::unique_ptr<Track>> tracks_;  // one for each measure
  std::unique_ptr<Rows> rows_;
  std::vector<std::unique_ptr<Points>> points_;
  std::unique_ptr<Statistics> statistics_;
};

/// All numbers in run.json, by path. Paths of numbers of a contact begin with the contact's name.
std::map<std::string, double> numbers_of(const Result& result);

/// Throws SceneError if the column of a measure does not exist, with suggestions and a list of the
/// columns. `simulation` must be at its start; it is run for zero time.
void require_columns(const Study& study, const Scene& scene, Simulation& simulation, CountedTime time);

}  // namespace freeplay

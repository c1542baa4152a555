// Makes a study's measures (study/settings/measure.hpp) of one run, as an observer: nothing is kept but sums, and what a quantile needs.
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

/// What is counted of a run.
struct CountedTime {
  double from = 0, to = 0;  ///< s
  double period = 0;        ///< s, 0: none is known
};

/// What became of one measure.
struct MeasureValue {
  double value = 0;  ///< NaN: absent
  struct Part {
    double t = 0, value = 0;  ///< s: a period's beginning, or the instant of a point
  };
  std::vector<Part> parts;  ///< of periods or points
};

class Measurer {
 public:
  /// Throws SceneError, at the study's key, for a measure that the scene cannot give.
  Measurer(const Study& study, const Scene& scene, const Layout& layout, CountedTime time);
  ~Measurer();
  Measurer(const Measurer&) = delete;
  Measurer& operator=(const Measurer&) = delete;

  /// To watch every run up to the end of the window.
  std::vector<Observer*> observers() const;
  /// Those whose column is none of a table: a number of run.json, if anything.
  std::vector<Measure> numbers_of_runs() const;
  /// After that, of the last run's result: in the order of the study.
  std::vector<MeasureValue> finish(Result result) const;

 private:
  class Statistics;
  class Track;
  class Rows;
  class Points;
  std::vector<std::unique_ptr<Track>> tracks_;  // of each measure
  std::unique_ptr<Rows> rows_;
  std::vector<std::unique_ptr<Points>> points_;
  std::unique_ptr<Statistics> statistics_;
};

/// Every number that run.json says of a run, by its path; those of a contact begin with its name.
std::map<std::string, double> numbers_of(const Result& result);

/// Throws SceneError where a measure's column is none: "NAME is no column", what is like it, and on three lines what there is.
/// `simulation` stands at its start, and is run for no time.
void require_columns(const Study& study, const Scene& scene, Simulation& simulation, CountedTime time);

}  // namespace freeplay

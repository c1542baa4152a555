// Measures how the cost of a step grows with the size of a mechanism: scenes of growing size, each
// measured in its own process.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mechanism/scene.hpp"
#include "simulation/formulation.hpp"
#include "values/stop.hpp"

namespace freeplay::verification {

/// A scene that grows.
struct Growth {
  std::string name;     ///< in scaling.csv
  std::string what;     ///< of the page
  std::string counted;  ///< what there are so many of
  Family family = Family::nonsmooth;
  std::vector<int> counts;
  std::function<Scene(int)> scene;
  int fit_from = 1;         ///< the smallest count that the exponent is taken over
  double predicted = 1;     ///< the exponent that the algorithm has, drawn into the figure
  std::string reason = {};  ///< why
};

/// What one size costs. A unit of work is a step of the nonsmooth formulation, a right-hand side of penalty.
struct Cost {
  int count = 0, bodies = 0;
  double setup_s = 0;       ///< from the scene's values to what can step, processor time
  double megabytes = 0;     ///< the most that the process held
  double microseconds = 0;  ///< a unit of work, processor time, least of the repetitions
  long units = 0;           ///< of work
  double solves = 0;        ///< contact problems a unit
  double pivots = 0;        ///< a problem
  double lasting = 0;       ///< how many of the contacts last, share of the time
  std::string ending;       ///< why the run did not finish, or nothing
};

/// The scenes: a row of loose four-bars in both formulations, and a hanging chain of loose links.
std::vector<Growth> growths();

/// A chain of `links` of 0.1 m and 0.1 kg that hangs from the ground in pins with 1 mm of play, each
/// at the bottom of its bearing, and swings at 1 rad/s.
Scene loose_chain(int links);

/// Measures one size, `repetitions` times.
Cost measure(const Growth& growth, int count, int repetitions);

/// Slope of log cost over log count from growth.fit_from on, least squares; NaN with fewer than two sizes.
double exponent(const Growth& growth, const std::vector<Cost>& costs);

}  // namespace freeplay::verification

// Measures how the cost of a step grows with the size of a mechanism: scenes of growing size, each
// measured in its own process.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mechanism/scene.hpp"
#include "simulation/formulation.hpp"
#include "values/stop.hpp"
#include "values/table.hpp"

namespace freeplay::verification {

/// A family of scenes of growing size.
struct Growth {
  std::string name;     ///< in scaling.csv
  std::string what;     ///< description on the page
  std::string counted;  ///< the counted elements
  Family family = Family::nonsmooth;
  std::vector<int> counts;
  std::function<Scene(int)> scene;
  int fit_from = 1;         ///< the smallest count in the fit of the exponent
  double predicted = 1;     ///< the exponent of the algorithm, drawn into the figure
  std::string reason = {};  ///< justification of the exponent
};

/// Cost of one size. A unit of work is a step of the nonsmooth formulation, a right-hand side of
/// penalty.
struct Cost {
  int count = 0, bodies = 0;
  double setup_s = 0;       ///< from the scene's values to a ready simulation, processor time
  double megabytes = 0;     ///< peak memory of the process
  double microseconds = 0;  ///< per unit of work, processor time, least of the repetitions
  long units = 0;           ///< of work
  double solves = 0;        ///< contact problems per unit
  double pivots = 0;        ///< per problem
  double lasting = 0;       ///< average number of lasting contacts over time
  std::string ending;       ///< why the run did not finish, or empty
};

/// The scenes: a row of four-bars with clearance in both formulations, and a hanging chain with
/// clearance in its links.
std::vector<Growth> growths();

/// A chain of `links` of 0.1 m and 0.1 kg that hangs from the ground in pins with 1 mm of
/// clearance, each at the bottom of its bearing, and swings at 1 rad/s.
Scene loose_chain(int links);

/// Measures one size, `repetitions` times.
Cost measure(const Growth& growth, int count, int repetitions);

/// Slope of log cost over log count from growth.fit_from on, least squares; NaN with fewer than two
/// sizes.
double exponent(const Growth& growth, const std::vector<Cost>& costs);

/// A family with the costs of its sizes.
struct Measured {
  Growth growth;
  std::vector<Cost> costs = {};
};

/// The costs of a family for a reader, and the exponent in words.
Table cost_table(const Measured& measured);
std::string conclusion(const Measured& measured);

/// scaling.json, without provenance.
nlohmann::json to_json(const std::vector<Measured>& all);
/// scaling.csv.
Table scaling_table(const std::vector<Measured>& all);
/// docs/verification/scaling.md. `repetitions`: of each measurement.
std::string scaling_page(const std::vector<Measured>& all, int repetitions);

}  // namespace freeplay::verification

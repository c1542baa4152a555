// Contents of the result files about contact laws and lubricant films. Documents are without their
// provenance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "formulations/contact/law_curves.hpp"
#include "formulations/contact/steady_film.hpp"
#include "values/table.hpp"

namespace freeplay {

/// film.json: the bearing, and its steady running if this is given.
nlohmann::json film_json(const std::string& joint, const Film& film, const SteadyFilm* running = nullptr);

/// Steady running at the eccentricity ratios 0.01, 0.02, ... up to the hand-over thickness. The
/// dimensionless quantities depend on the shape of the bearing only, not on the speed, here 1 rad/s.
std::vector<SteadyFilm> film_chart(const Film& film);
/// film.csv.
Table film_table(const Film& film, const std::vector<SteadyFilm>& chart);

/// laws.json.
nlohmann::json to_json(const LawCurves& curves, const ImpactSetting& setting);
/// impact_loops.csv, delivered.csv and friction.csv.
struct LawTables {
  explicit LawTables(const LawCurves& curves);
  Table impacts, delivered, friction;
};

}  // namespace freeplay

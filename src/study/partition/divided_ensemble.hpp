// Ensembles as many machines make them: a unit is a start (study/partition/division.hpp), kept in ensemble.db.
#pragma once

#include "study/ensemble/ensemble.hpp"
#include "study/partition/division.hpp"

namespace freeplay {

/// Of a scene that stays as it is. `arguments`: of the command line, scene and options.
Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments);

}  // namespace freeplay

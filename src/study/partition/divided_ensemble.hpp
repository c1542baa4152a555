// Division of an ensemble among machines. A unit is a start (study/partition/division.hpp); the
// results are in ensemble.db.
#pragma once

#include "study/ensemble/ensemble.hpp"
#include "study/partition/division.hpp"

namespace freeplay {

/// Refers to the scene, which must not change. `arguments`: scene and options of the command line.
Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments);

}  // namespace freeplay

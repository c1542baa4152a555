// Division of sweeps and ensembles among machines (study/partition/division.hpp). A unit of a sweep
// is a run. It is identified by its index in the cases of the study, so a shard reads the scenes of
// its own runs only. A unit of an ensemble is a start.
#pragma once

#include "study/ensemble/ensemble.hpp"
#include "study/partition/division.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {

/// Throws SceneError unless a run is the `same` as its unit in the plan. `file`: of the study.
void require_planned(bool same, const Unit& unit, const std::filesystem::path& file);

/// `verb`: the verb of the database, VERB.db.
Division divided_sweep(const Study& study, const Conduct& conduct, const char* verb,
                       std::vector<std::string> arguments, std::string subject);

/// Digest of a study's statements and of all files it names.
std::string subject_of(const Study& study);

/// Refers to the scene, which must not change. `arguments`: scene and options of the command line.
/// The results are in ensemble.db.
Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments);

}  // namespace freeplay

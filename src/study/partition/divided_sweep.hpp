// Division of a sweep among machines. A unit is a run (study/partition/division.hpp). It is
// identified by its index in the cases of the study, so a shard reads the scenes of its own runs
// only.
#pragma once

#include "study/partition/division.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {

/// `verb`: the verb of the database.
Division divided_sweep(const Study& study, const Conduct& conduct, const char* verb,
                       std::vector<std::string> arguments, std::string subject);

/// Digest of a study's statements and of all files it names.
std::string subject_of(const Study& study);

}  // namespace freeplay

// Sweeps as many machines make them: a unit is a run, found again by its place among the study's cases, so that a shard reads no
// scene but its own (study/partition/division.hpp).
#pragma once

#include "study/partition/division.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {

/// `verb`: whose database it is..
Division divided_sweep(const Study& study, const Conduct& conduct, const char* verb,
                       std::vector<std::string> arguments, std::string subject);

/// A digest of what a study states and of all files that it names.
std::string subject_of(const Study& study);

}  // namespace freeplay

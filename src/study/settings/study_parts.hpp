// Readers of parts of a study file, called by study.cpp: windows, axes, measures and derived
// columns.
#pragma once

#include "mechanism/keys.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

class Section;

inline constexpr Range study_count{
    [](double x) { return x >= 1 && x <= 1e6 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 1"};

/// Reads the evaluated part of a run: periods or times, discarded and counted.
void read_windows(Section& root, Study& study);
/// Reads the axes, the sampling of drawn axes, and the filter of cells.
void read_axes(Section& root, Study& study);
/// Adds a measure with a name that no other column has. Throws SceneError with the position of `s`.
void add_measure(Study& study, Measure measure, Section& s);
/// Reads the measures and the derived columns.
void read_measures(Section& root, Study& study);
/// Checks all expressions of the study. Throws SceneError for an invalid one.
void require_expressions(const Study& study);

}  // namespace freeplay

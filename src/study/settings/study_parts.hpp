// Parts of a study's file that study.cpp reads the whole of: windows, axes, measures and what is derived from them.
#pragma once

#include "mechanism/keys.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

class Section;

inline constexpr Range study_count{
    [](double x) { return x >= 1 && x <= 1e6 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 1"};

void read_windows(Section& root, Study& study);
/// And how they are drawn and filtered.
void read_axes(Section& root, Study& study);
/// And what is derived.
void read_measures(Section& root, Study& study);
/// Throws SceneError where an expression of the study is none.
void require_expressions(const Study& study);

}  // namespace freeplay

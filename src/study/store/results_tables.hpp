// The tables of a study's results. A run has a row in `runs`, by the digest of its identity; what it has many of has rows, or
// one row of blobs, by the whole number of its row there. Views give them the digest again:
//
//     turns, flights, impacts, measures, costs   a row for each, as ever
//     spectra (run, amplitude)                   blob: of harmonics 1, 2, …
//     traces  (run, angle, acceleration, position)   blobs: angle is its first and its last, even between, or all of them
//
// A blob holds numbers of single precision (IEEE 754 binary32), the lowest byte first, with nothing between.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "measure/turns.hpp"
#include "study/settings/study.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// Of a study's axes and measures; but for the view `named` and the table `derived`, which follow what the study derives.
StoreForm results_form(const Study& study);

/// The columns of `runs` as queries show them, from the table `runs`.
std::string shown_columns(const Study& study);

/// A trace as its blobs have it.
struct PackedTrace {
  std::vector<float> angle, acceleration, position;  ///< position: none where there is no sensor of it
};
PackedTrace packed(const std::vector<TracePoint>& trace);
std::vector<TracePoint> unpacked(const PackedTrace& trace);

}  // namespace freeplay

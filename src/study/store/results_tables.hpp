// Tables of a sweep's database. A run has one row in `runs`, with the digest of its identity as
// key. Its lists have several rows, or one row of blobs, in other tables, which refer to the run by
// the integer of its row. Views show them with the digest:
//
//     turns, flights, impacts, measures, costs       one row for each item
//     spectra (run, amplitude)                       blob: of harmonics 1, 2, …
//     traces  (run, angle, acceleration, position)   blobs: angle contains the first and last angle
//                                                    of uniform samples, or all angles
//
// A blob contains single-precision numbers (IEEE 754 binary32), little-endian, without padding.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "measure/turns.hpp"
#include "study/settings/study.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// Definitions for a study's axes and measures, without the views, and without the table `derived`,
/// which depends on the derived columns.
StoreForm results_form(const Study& study);

/// A trace in the form of its blobs.
struct PackedTrace {
  std::vector<float> angle, acceleration, position;  ///< position: empty without a position sensor
};
/// Conversion between a trace and its blobs. unpacked() returns an empty trace for inconsistent
/// blobs.
PackedTrace packed(const std::vector<TracePoint>& trace);
std::vector<TracePoint> unpacked(const PackedTrace& trace);

}  // namespace freeplay

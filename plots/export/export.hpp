// Result folders in the formats of other programs: HDF5 for large runs in Python, MATLAB or Julia, VTK for ParaView. Both
// read result files only, row by row: memory does not grow with the run.
#pragma once

#include <cstddef>
#include <filesystem>

#include "values/stop.hpp"

namespace freeplay {

/// What was written.
struct Exported {
  std::size_t tables = 0;  ///< of HDF5
  std::size_t rows = 0;    ///< of all tables, or frames of VTK
};

/// Throws SceneError unless this program was built with HDF5 and finds its library.
void require_hdf5();

/// Every table and JSON document of the folder, and of the runs of a comparison in it, as one HDF5 file:
///
///     /TABLE/COLUMN           a dataset of 64-bit numbers or of texts, with the attribute units
///     /TABLE                  attributes source, rows, columns (in the order of the file)
///     /statistics/FIELD       what run.json says of the contacts, in the order of /statistics/contact
///     /run/…                  run.json: an object is a group, a value an attribute
///     /                       attributes NAME.json: the documents as they stand
///
/// Written whole or not at all. Throws SceneError for what is no result file, OutputError, and Interrupted when asked to stop.
Exported export_hdf5(const std::filesystem::path& folder, const std::filesystem::path& path, StopToken stop);

/// The mechanism of a run at every k-th row of its trajectory, k = `every`: a file frame_N.vtp each, and mechanism.pvd, which ParaView
/// opens. They replace those that stand in `place` as a whole. Throws as export_hdf5.
Exported export_vtk(const std::filesystem::path& folder, const std::filesystem::path& place, int every,
                    StopToken stop);

/// Files of one series: what asks for more says how many rows to leave out.
inline constexpr std::size_t most_frames = 20'000;

}  // namespace freeplay

// Exports result folders to formats of other programs: HDF5 for large runs in Python, MATLAB or
// Julia, VTK for ParaView. Both exports read result files only, row by row, with constant memory.
#pragma once

#include <cstddef>
#include <filesystem>

#include "values/stop.hpp"

namespace freeplay {

/// Amount of data written.
struct Exported {
  std::size_t tables = 0;  ///< number of tables (HDF5)
  std::size_t rows = 0;    ///< rows of all tables (HDF5), or frames (VTK)
};

/// Throws SceneError unless this program was built with HDF5 and finds its library.
void require_hdf5();

/// Writes every table and JSON document of the folder, and of the runs of a comparison in it, to
/// one HDF5 file:
///
///     /TABLE/COLUMN           a dataset of 64-bit numbers or of texts, with the attribute units
///     /TABLE                  attributes source, rows, columns (in the order of the file)
///     /statistics/FIELD       statistics of contacts (run.json), ordered as /statistics/contact
///     /run/…                  run.json: an object is a group, a value an attribute
///     /                       attributes NAME.json: the unchanged documents
///
/// The file is written completely or not at all. Throws SceneError for files that are no result
/// files, OutputError, and Interrupted on a stop request.
Exported export_hdf5(const std::filesystem::path& folder, const std::filesystem::path& path, StopToken stop);

/// Writes the mechanism of a run at every k-th row of its trajectory, k = `every`: files
/// frame_N.vtp, and mechanism.pvd, which ParaView opens. They replace the files of an earlier
/// export in `place`. Throws as export_hdf5.
Exported export_vtk(const std::filesystem::path& folder, const std::filesystem::path& place, int every,
                    StopToken stop);

}  // namespace freeplay

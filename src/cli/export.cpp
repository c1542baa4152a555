// freeplay export: writes result folders in formats of other programs.
#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "mechanism/error.hpp"
#include "plots/export/export.hpp"

namespace freeplay::cli {
namespace {

struct ExportRequest : Request {
  std::string folder;
  std::optional<std::string> hdf5, vtk;
  int every = 1;
};

/// The named file, or the default file in the folder.
std::filesystem::path file_of(const std::string& named, const std::filesystem::path& folder) {
  if (named.empty()) return folder / "results.h5";
  const std::filesystem::path path = named;
  if (!path.has_filename() || std::filesystem::is_directory(path))
    throw SceneError(fmt::format("--hdf5 {}: is a folder; give a file's name", named));
  if (path.extension() == ".csv" || path.extension() == ".json" || path.extension() == ".toml")
    throw SceneError(fmt::format("--hdf5 {}: has the extension of another format; give NAME.h5", named));
  const auto parent = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(parent))
    throw SceneError(fmt::format("--hdf5 {}: folder {} does not exist", named, parent.string()));
  return real_folder(parent) / path.filename();
}

int export_results(const ExportRequest& request) {
  if (!request.hdf5 && !request.vtk) throw SceneError("give a format: --hdf5 [FILE], --vtk [FOLDER] or both");
  const auto folder = named_results(request.folder);
  const auto file = request.hdf5 ? file_of(*request.hdf5, folder) : std::filesystem::path();
  if (request.hdf5) require_hdf5();
  const auto lock = lock_results(folder, "export", false);
  if (request.hdf5) {
    const auto done = export_hdf5(folder, file, request.stop);
    fmt::print("{}: {} tables, {} rows\n", file.string(), done.tables, done.rows);
  }
  if (request.vtk) {
    const auto place = request.vtk->empty() ? folder / "vtk" : real_folder(*request.vtk);
    if (place == folder) throw SceneError("--vtk: the frames need a separate folder");
    const auto done = export_vtk(folder, place, request.every, request.stop);
    fmt::print("{}: {} frames\n", (place / "mechanism.pvd").string(), done.rows);
  }
  return 0;
}

}  // namespace

void export_verb(Program& program) {
  auto [options, request] =
      program.verb("export", "write a result folder as HDF5, or its motion for ParaView", export_results);
  options.add("folder", request.folder, "folder made by run, compare or another verb that writes tables")
      .required();
  options
      .maybe("--hdf5", request.hdf5,
             "write all tables to one HDF5 file; default results.h5 in the "
             "folder")
      .takes("[FILE]");
  const auto vtk = options
                       .maybe("--vtk", request.vtk,
                              "write the motion of a run as VTK files; default vtk/ in the "
                              "folder")
                       .takes("[FOLDER]");
  options.add("--every", request.every, "rows of the trajectory per frame; default 1")
      .between(1, 1'000'000'000)
      .takes("ROWS")
      .needs(vtk);
}

}  // namespace freeplay::cli

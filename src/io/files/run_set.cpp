#include "io/files/run_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "values/snapshot.hpp"

namespace freeplay {
namespace {

using Path = std::filesystem::path;

constexpr const char* summary_name = "run.json";
/// Files that a run may write beside run.json, in the order of their renaming.
constexpr std::array file_names{"trajectory.csv", "events.csv", "signals.csv", "forces.csv"};

Path half(const Path& folder, const std::string& name) { return folder / (name + ".partial"); }

bool is_file(const Path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(std::filesystem::symlink_status(path, ignored));
}

/// "finished", "failed" or "interrupted"; nullopt if the file is missing or incomplete.
std::optional<std::string> status_in(const Path& file) {
  if (!is_file(file)) return std::nullopt;
  try {
    return JsonFile(file).text("ending.status");
  } catch (const SceneError&) {
    return std::nullopt;
  }
}

[[noreturn]] void refuse(const Path& path, const std::error_code& error) {
  throw OutputError(fmt::format("{}: cannot be replaced: {}", path.string(), error.message()));
}

void clear(const Path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) refuse(path, error);
}

void put_in_place(const Path& folder, const std::string& name) {
  std::error_code error;
  std::filesystem::rename(half(folder, name), folder / name, error);
  if (error) refuse(folder / name, error);
}

void remove_figures_of_forces(const Path& folder) {
  std::error_code ignored;
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(folder / "figures", ignored))) return;
  std::vector<Path> stale;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "figures", ignored)) {
    const auto name = entry.path().filename().string();
    for (const auto* kind : {"reaction_", "bearing_load_", "drive_torque"})
      if (name.starts_with(kind)) stale.push_back(entry.path());
  }
  for (const auto& path : stale) std::filesystem::remove(path, ignored);
}

void remove_run(const Path& folder) {
  clear(folder / summary_name);
  for (const auto* name : file_names) clear(folder / name);
  remove_figures_of_forces(folder);
}

void remove_checkpoint(const Path& folder) {
  clear(folder / checkpoint_name);
  clear(half(folder, checkpoint_name));
}

}  // namespace

RunSet::RunSet(const Path& folder, std::vector<std::string> names)
    : folder_(folder), summary_(folder / summary_name) {
  // Remove partial files of another run, which would be mistaken for files of this one.
  for (const auto* name : file_names)
    if (std::ranges::find(names, name) == names.end()) clear(half(folder, name));
}

void RunSet::summarise(std::string_view text) {
  summary_.write(text);
  summary_.settle();
  summary_.keep();
}

void RunSet::remove_older() { remove_run(folder_); }

void RunSet::commit(bool later) {
  // Before run.json: a run that has ended has no checkpoint.
  if (!later) remove_checkpoint(folder_);
  summary_.commit();
}

void settle_run(const Path& folder) {
  const auto status = status_in(half(folder, summary_name));
  if (!status) return;
  if (is_file(half(folder, file_names.front()))) remove_run(folder);
  for (const auto* name : file_names)
    if (is_file(half(folder, name))) put_in_place(folder, name);
  if (*status != "interrupted") remove_checkpoint(folder);
  put_in_place(folder, summary_name);
}

bool holds_finished_run(const Path& folder) {
  const auto status = status_in(folder / summary_name);
  return status && *status != "interrupted";
}

void require_halves(const Path& folder, const std::vector<std::string>& names) {
  for (const auto& name : names)
    if (!is_file(half(folder, name)))
      throw SnapshotError(
          fmt::format("{} is missing; the run cannot be continued without it", half(folder, name).string()));
}

}  // namespace freeplay

#include "io/files/result_set.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "values/snapshot.hpp"

namespace freeplay {
namespace {

using Path = std::filesystem::path;

constexpr const char* summary_name = "run.json";
/// Files that a run may write beside run.json, in the order of their renaming.
constexpr std::array file_names{"trajectory.csv", "events.csv", "signals.csv", "forces.csv", "pressure.csv"};

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

[[noreturn]] void refuse(const Path& path, const std::error_code& error, const char* what) {
  throw OutputError(fmt::format("{}: cannot be {}: {}", path.string(), what, error.message()));
}

void clear(const Path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) refuse(path, error, "replaced");
}

void move(const Path& from, const Path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) refuse(to, error, "put in its place");
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
    if (is_file(half(folder, name))) move(half(folder, name), folder / name);
  if (*status != "interrupted") remove_checkpoint(folder);
  move(half(folder, summary_name), folder / summary_name);
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

namespace {

/// The results of a verb: patterns of files in its folder, or one folder below.
struct Members {
  const char* verb;
  std::vector<const char*> patterns;
};

/// The first file of each list marks the others as results.
const std::vector<Members>& all_members() {
  static const std::vector<Members> list = {
      {"compare",
       {"comparison.json", "comparison.md", "penalty/run.json", "penalty/*.csv", "nonsmooth/run.json",
        "nonsmooth/*.csv", "ideal/run.json", "ideal/*.csv", "figures/acceleration*", "figures/journal_orbit*",
        "figures/paired_impacts*", "figures/reaction_*", "figures/bearing_load_*", "figures/drive_torque*"}},
      {"laws",
       {"laws.json", "impact_loops.csv", "delivered.csv", "friction.csv", "figures/impact_loops*",
        "figures/delivered_restitution*", "figures/friction_laws*"}},
      {"film", {"film.json", "film.csv", "figures/film_coefficients*"}},
      {"modes", {"modes.json", "modes.csv", "equilibrium.csv", "static_forces.csv"}},
      {"play",
       {"play.json", "play.csv", "play_parts.csv", "play_loads.csv", "play_region.csv", "play_pose.csv",
        "allocation.csv", "figures/play*"}},
      {"drift", {"drift.json", "drift.csv", "figures/drift*"}},
      {"poincare", {"section.json", "section.csv", "figures/poincare*"}},
      {"sensitivity", {"sensitivity.json", "figures/sensitivity*"}},
      {"orbit", {"orbit.json", "motion/run.json", "motion/*.csv", "figures/orbit*", "figures/multipliers*"}},
      {"lyapunov", {"lyapunov.json", "lyapunov.csv", "figures/lyapunov*"}},
      {"continue",
       {"continue.json", "branch.csv", "branch_impacts.csv", "bifurcations.csv", "curves.csv",
        "figures/branch*", "figures/curves*"}},
      {"bifurcation", {"bifurcation.json", "bifurcation.csv", "figures/bifurcation*"}},
      {"basin", {"basin.json", "basin.csv", "figures/basin*"}},
      {"check", {"pose.json", "pose.csv", "figures/pose*"}},
      {"validate", {"validation.json", "overlay.csv", "figures/overlay*"}},
      {"validate-study",
       {"experiment.json", "experiment.md", "calibration.json", "cells.csv", "traces.csv", "spectra.csv",
        "figures/experiment_*"}},
      {"paper", {"paper.json", "cells.csv", "traces.csv", "spectra.csv", "figures/figure_*"}},
      {"validate-points", {"points.json", "points.csv", "curves.csv", "figures/points*"}},
      {"validate-rows", {"rows.json", "rows.csv"}},
      {"tradeoff", {"tradeoff.json", "tradeoff.csv", "figures/tradeoff_*"}},
      {"ensemble", {"ensemble.json", "statistics.csv", "starts.csv", "bands.csv", "figures/ensemble*"}},
      {"wear",
       {"wear.json", "wear.csv", "profiles.csv", "profile_bearing_*.csv", "profile_journal_*.csv", "wear.md",
        "figures/wear*"}},
      {"scaling", {"scaling.json", "scaling.csv", "figures/scaling*"}},
      {"export", {"mechanism.pvd", "frame_*.vtp"}},
      {"animate", {"animation.mp4", "animation.gif", "frame_*.svg"}},
      {"extremes", {"extremes.json", "extremes.csv", "limits.csv", "figures/extremes*"}},
  };
  return list;
}

const Members& members_of(const std::string& verb) {
  const auto members = std::ranges::find(all_members(), verb, &Members::verb);
  if (members == all_members().end()) throw std::logic_error(verb + " has no list of its results");
  return *members;
}

Path stage(const Path& folder, const std::string& verb, const char* name) {
  return folder / fmt::format(".{}.{}", verb, name);
}

/// Whether the path is a folder and not a symbolic link; throws for a link.
bool is_own_folder(const Path& path) {
  std::error_code error;
  const auto status = std::filesystem::symlink_status(path, error);
  if (std::filesystem::is_symlink(status))
    throw OutputError(fmt::format("{}: is a link; links are not followed to results", path.string()));
  return std::filesystem::is_directory(status);
}

bool is_folder(const std::filesystem::directory_entry& entry) {
  std::error_code error;
  return std::filesystem::is_directory(entry.symlink_status(error));
}

/// Throws unless the path is free or a folder that is not a link.
void require_folder(const Path& path) {
  std::error_code error;
  if (!is_own_folder(path) && std::filesystem::exists(std::filesystem::symlink_status(path, error)))
    throw OutputError(fmt::format("{}: is a file, but a folder is needed", path.string()));
}

/// Calls f for each existing entry that matches a pattern.
void each_member(const Path& folder, const Members& members, auto f) {
  for (const Path pattern : members.patterns) {
    const auto place = (folder / pattern).parent_path();
    if (pattern.has_parent_path() && !is_own_folder(place)) continue;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(place, error))
      if (fnmatch(pattern.filename().c_str(), entry.path().filename().c_str(), 0) == 0) f(pattern, entry);
  }
}

/// Throws OutputError, before any older result is removed, if the results could not be moved in: a
/// folder has the name of a file, or a file or link has the name of a folder.
void require_places(const Path& folder, const Members& members) {
  for (const Path pattern : members.patterns)
    if (pattern.has_parent_path()) require_folder(folder / pattern.parent_path());
  for (const auto* name : {"complete", "moving"}) require_folder(stage(folder, members.verb, name));
  each_member(folder, members, [](const Path& pattern, const auto& entry) {
    // A killed drawing leaves the folder figures/NAME.partial, which is not a result.
    if (is_folder(entry) && pattern.native().find('*') == std::string::npos)
      throw OutputError(fmt::format("{}: is a folder, but a result file is needed", entry.path().string()));
  });
}

void remove_older(const Path& folder, const Members& members) {
  std::vector<Path> found;
  each_member(folder, members, [&](const Path&, const auto& entry) {
    if (!is_folder(entry)) found.push_back(entry.path());
  });
  for (const auto& path : found) remove_file(path);
  std::error_code ignored;
  for (const Path pattern : members.patterns)
    if (pattern.has_parent_path())
      std::filesystem::remove(folder / pattern.parent_path(), ignored);  // if nothing else is in it
}

/// Moves the files of this verb only, and no links: the folder may contain files of the user.
void move_in(const Path& from, const Path& folder, const Members& members) {
  std::vector<Path> files;
  each_member(from, members, [&](const Path& pattern, const auto& entry) {
    std::error_code error;
    if (std::filesystem::is_regular_file(entry.symlink_status(error)))
      files.push_back(pattern.parent_path() / entry.path().filename());
  });
  // Files in subfolders first: the file that marks them as results is moved last.
  std::ranges::sort(files, {}, [](const Path& file) { return std::pair(!file.has_parent_path(), file); });
  for (const auto& file : files) {
    const auto place = (folder / file).parent_path();
    make_folder(place);
    move_file((from / file).parent_path(), place, file.filename().string());
  }
  std::error_code error;
  std::filesystem::remove_all(from, error);
}

void settle(const Path& folder, const Members& members) {
  const auto complete = stage(folder, members.verb, "complete"),
             moving = stage(folder, members.verb, "moving");
  if (is_own_folder(complete)) {
    require_places(folder, members);
    remove_older(folder, members);
    move(complete, moving);
  }
  if (is_own_folder(moving)) move_in(moving, folder, members);
}

}  // namespace

void settle_result_sets(const Path& folder) {
  for (const auto& members : all_members()) {
    settle(folder, members);
    std::error_code error;
    std::filesystem::remove_all(stage(folder, members.verb, "new"), error);
  }
}

ResultSet::Folder::Folder(const Path& where) : path(where), made(!std::filesystem::exists(where)) {
  make_folder(path);
}
ResultSet::Folder::~Folder() {
  std::error_code ignored;
  if (made && std::filesystem::is_empty(path, ignored)) std::filesystem::remove(path, ignored);
}

ResultSet::ResultSet(const Path& folder, const std::string& verb)
    : folder_(folder), lock_(folder, verb), verb_(verb), place_(stage(folder, verb, "new")) {
  require_places(folder, members_of(verb));
  settle_result_sets(folder);
  make_folder(place_);
}

ResultSet::~ResultSet() {
  std::error_code ignored;
  std::filesystem::remove_all(place_, ignored);
}

void ResultSet::commit() {
  const auto& members = members_of(verb_);
  require_places(lock_.folder(), members);
  move(place_, stage(lock_.folder(), verb_, "complete"));
  settle(lock_.folder(), members);
}

}  // namespace freeplay

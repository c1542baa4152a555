#include "io/result_set.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <system_error>
#include <vector>

#include "io/output_file.hpp"

namespace freeplay {
namespace {

using Path = std::filesystem::path;

/// The results of a verb: patterns of files in its folder, or one folder below.
struct Members {
  const char* verb;
  std::vector<const char*> patterns;
};

/// First the file that says that the others are results.
const std::vector<Members>& all_members() {
  static const std::vector<Members> list = {
      {"compare",
       {"comparison.json", "comparison.md", "penalty/run.json", "penalty/*.csv", "nonsmooth/run.json",
        "nonsmooth/*.csv", "ideal/run.json", "ideal/*.csv", "figures/acceleration.*",
        "figures/journal_orbit.*", "figures/paired_impacts.*", "figures/reaction_*", "figures/bearing_load_*",
        "figures/drive_torque*"}},
      {"laws",
       {"laws.json", "impact_loops.csv", "delivered.csv", "friction.csv", "figures/impact_loops.*",
        "figures/delivered_restitution.*", "figures/friction_laws.*"}},
      {"drift", {"drift.json", "drift.csv", "figures/drift.*"}},
      {"check", {"pose.json", "pose.csv", "figures/pose.*"}},
      {"validate", {"validation.json", "overlay.csv", "figures/overlay.*"}},
      {"validate-study",
       {"experiment.json", "experiment.md", "calibration.json", "cells.csv", "traces.csv", "spectra.csv",
        "figures/experiment_*"}},
      {"tradeoff", {"tradeoff.json", "tradeoff.csv", "figures/tradeoff_*"}},
      {"extremes", {"extremes.json", "extremes.csv", "limits.csv", "figures/extremes.*"}},
  };
  return list;
}

Path stage(const Path& folder, const std::string& verb, const char* name) {
  return folder / fmt::format(".{}.{}", verb, name);
}

[[noreturn]] void fail(const Path& path, const std::string& what, const std::error_code& error) {
  throw OutputError(fmt::format("{}: {}: {}", path.string(), what, error.message()));
}

void move(const Path& from, const Path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) fail(to, "cannot be put in its place", error);
}

/// A folder of its own, or nothing; not one that a link leads to.
bool is_own_folder(const Path& path) {
  std::error_code error;
  const auto status = std::filesystem::symlink_status(path, error);
  if (std::filesystem::is_symlink(status))
    throw OutputError(fmt::format("{}: is a link, and none is followed to where results go", path.string()));
  return std::filesystem::is_directory(status);
}

void remove_older(const Path& folder, const Members& members) {
  for (const Path pattern : members.patterns) {
    const auto place = (folder / pattern).parent_path();
    if (pattern.has_parent_path() && !is_own_folder(place)) continue;
    std::vector<Path> found;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(place, error))
      if (fnmatch(pattern.filename().c_str(), entry.path().filename().c_str(), 0) == 0)
        found.push_back(entry.path());
    for (const auto& path : found) {
      if (std::filesystem::is_directory(std::filesystem::symlink_status(path, error)))
        continue;  // none of ours
      std::filesystem::remove(path, error);
      if (error) fail(path, "cannot be replaced", error);
    }
    if (pattern.has_parent_path()) std::filesystem::remove(place, error);  // where nothing else is in it
  }
}

void move_in(const Path& from, const Path& folder) {
  std::vector<Path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(from))
    if (entry.is_regular_file()) files.push_back(entry.path().lexically_relative(from));
  // Those in folders first: the file that says that they are results stands beside these.
  std::ranges::sort(files, {}, [](const Path& file) { return std::pair(!file.has_parent_path(), file); });
  for (const auto& file : files) {
    if (file.has_parent_path() && !is_own_folder(folder / file.parent_path()))
      make_folder(folder / file.parent_path());
    move(from / file, folder / file);
  }
  std::error_code error;
  std::filesystem::remove_all(from, error);
}

void settle(const Path& folder, const Members& members) {
  const auto complete = stage(folder, members.verb, "complete"),
             moving = stage(folder, members.verb, "moving");
  if (is_own_folder(complete)) {
    remove_older(folder, members);
    move(complete, moving);
  }
  if (is_own_folder(moving)) move_in(moving, folder);
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
  settle_result_sets(folder);
  make_folder(place_);
}

ResultSet::~ResultSet() {
  std::error_code ignored;
  std::filesystem::remove_all(place_, ignored);
}

void ResultSet::commit() {
  const auto members = std::ranges::find(all_members(), verb_, &Members::verb);
  if (members == all_members().end()) throw std::logic_error(verb_ + " has no list of its results");
  move(place_, stage(lock_.folder(), verb_, "complete"));
  settle(lock_.folder(), *members);
}

}  // namespace freeplay

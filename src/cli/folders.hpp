// Folders of a verb: results that it reads or writes, and with the option --document a page of docs/ with its
// figures.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "mechanism/error.hpp"

namespace freeplay::cli {

/// out/NAME, with the name of the file, or of its folder for a file called scene.toml or
/// study.toml.
inline std::filesystem::path default_folder(const std::filesystem::path& file, const std::string& suffix) {
  auto name = file.stem().string();
  if (name == "scene" || name == "study")
    name = std::filesystem::absolute(file).lexically_normal().parent_path().filename().string();
  return std::filesystem::path("out") / (name + suffix);
}

/// The folder given by -o, or the default. Symbolic links in the path are the user's and are
/// resolved here; output below the folder follows no link.
inline std::filesystem::path result_folder(const std::string& requested,
                                           const std::filesystem::path& otherwise) {
  return real_folder(requested.empty() ? otherwise : std::filesystem::path(requested));
}

/// The folder with results that the user names. Throws SceneError if there is none.
inline std::filesystem::path named_results(const std::string& name) {
  auto folder = real_folder(name);
  if (!std::filesystem::is_directory(folder)) throw SceneError(name + ": is not a folder");
  return folder;
}

/// Locks a folder with results and completes replacements in it. If the verb does not write there, a folder
/// without write permission is read without a lock: no process of this user writes there meanwhile.
inline std::unique_ptr<FolderLock> lock_results(const std::filesystem::path& folder, std::string_view verb,
                                                bool writes = true) {
  if (!writes && access(folder.c_str(), W_OK) != 0) return nullptr;
  auto lock = std::make_unique<FolderLock>(folder, verb);
  settle_result_sets(folder);
  settle_run(folder);
  return lock;
}

/// Creates and locks the folder of a document. Returns null if it is the verb's `own` folder, which
/// is already locked.
inline std::unique_ptr<FolderLock> lock_document(const std::filesystem::path& place,
                                                 const std::filesystem::path& own, std::string_view verb) {
  make_folder(place);
  if (std::filesystem::equivalent(place, own)) return nullptr;
  return std::make_unique<FolderLock>(place, verb);
}

/// Copies the PNG of each figure to place/figures; returns their names.
inline std::vector<std::string> copy_figures(const std::vector<std::filesystem::path>& figures,
                                             const std::filesystem::path& place) {
  make_folder(place / "figures");
  std::vector<std::string> names;
  for (auto figure : figures) {
    figure.replace_extension(".png");
    write_file(place / "figures" / figure.filename(), read_file(figure, most_of_a_result));
    names.push_back(figure.filename().string());
  }
  return names;
}

/// Writes a page with its figures into the folder that --document names; nothing if that is empty. `own`: the
/// verb's folder, which is locked.
inline void write_page(const std::string& document, const std::filesystem::path& own, std::string_view verb,
                       const char* name, const std::string& text,
                       const std::vector<std::filesystem::path>& figures = {}) {
  if (document.empty()) return;
  const auto place = real_folder(document);
  const auto lock = lock_document(place, own, verb);
  write_file(place / name, text);
  if (!figures.empty()) copy_figures(figures, place);
}

}  // namespace freeplay::cli

// Files of run folders: their contents, the comparison of two folders, and a folder of compare.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "mechanism/scene.hpp"
#include "study/comparison/compare.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::test {

/// All files of a folder by their names, except the lock that a killed process leaves.
inline std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != ".freeplay.lock")
      files[entry.path().filename().string()] = file_text(entry.path());
  return files;
}

/// The same without the cost of the run.
inline std::map<std::string, std::string> results_of(const std::filesystem::path& folder) {
  auto files = files_of(folder);
  auto document = nlohmann::json::parse(files.at("run.json"));
  document.erase("cost");
  files["run.json"] = document.dump(2);
  return files;
}

inline void check_same(const std::filesystem::path& folder, const std::filesystem::path& reference) {
  const auto files = results_of(folder), expected = results_of(reference);
  for (const auto& [name, bytes] : expected) {
    INFO(name);
    REQUIRE(files.contains(name));
    if (files.at(name) == bytes) continue;
    const auto at =
        static_cast<std::size_t>(std::ranges::mismatch(bytes, files.at(name)).in1 - bytes.begin());
    FAIL_CHECK(name << " differs from byte " << at << " on, of " << bytes.size() << " and "
                    << files.at(name).size() << ":\n"
                    << bytes.substr(at, 200) << "\nexpected, and here\n"
                    << files.at(name).substr(at, 200));
  }
  for (const auto& [name, bytes] : files) {
    INFO(name);
    CHECK(expected.contains(name));  // no checkpoint, no incomplete file
  }
}

/// A comparison of the rig over a quarter of a revolution, made once.
inline const std::filesystem::path& comparison() {
  static const TemporaryFolder folder;
  static const auto place = folder.path() / "two";
  static const auto made =
      compare(read_scene(flores(), {"run.revolutions=0.25", "run.discard=0", "run.forces=true"}), {}, place);
  return place;
}

}  // namespace freeplay::test

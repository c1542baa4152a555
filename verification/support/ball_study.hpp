// A study of bouncing balls in its own folder, with runs of milliseconds, for tests of shards,
// clusters and hostile databases.
#pragma once

#include <sqlite3.h>
#include <catch2/catch.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "io/files/escaping.hpp"
#include "io/files/output_file.hpp"
#include "verification/support/support.hpp"

namespace freeplay::test {

/// Copies the scene and writes the study beside it, with the values of the restitution as `range`
/// or `values`.
inline void put_ball_study(const std::filesystem::path& folder, const std::string& values,
                           const std::string& more = {}) {
  std::filesystem::copy_file(source_folder() / "cases/bouncing-ball/scene.toml", folder / "scene.toml",
                             std::filesystem::copy_options::overwrite_existing);
  write_file(folder / "study.toml",
             "scene = \"scene.toml\"\nrestitution = \"as-given\"\ndiscard_time = \"0.33 s\"\n"
             "duration = \"0.3 s\"\n" +
                 more + "[axes.e]\nkey = \"surfaces.hard.restitution\"\n" + values + "\n");
}

struct BallStudy {
  TemporaryFolder folder;
  std::filesystem::path study = folder.path() / "study.toml", out = folder.path() / "out";
  explicit BallStudy(const std::string& values, const std::string& more = {}) {
    put_ball_study(folder.path(), values, more);
  }
  /// The program with unquoted words.
  static Outcome run(const std::vector<std::string>& words) { return freeplay(shell_words(words)); }
};

/// Executes SQL on a file, as an attacker may have done.
inline void execute(const std::filesystem::path& file, const std::string& sql, bool keep_log = false) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &db) == SQLITE_OK);
  if (keep_log) sqlite3_db_config(db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  const int code = sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr);
  INFO(sql << ": " << sqlite3_errmsg(db));
  CHECK(code == SQLITE_OK);
  sqlite3_close(db);
}

}  // namespace freeplay::test

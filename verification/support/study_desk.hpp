// A study of a case in its own folder, run by the program: its exported table, and queries of its
// database.
#pragma once

#include <fmt/format.h>
#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "io/files/output_file.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"

namespace freeplay::test {

using Rows = std::vector<std::vector<std::string>>;

/// Rows of a CSV file whose fields may be quoted, the header first.
inline Rows read_csv(const std::filesystem::path& file) {
  Rows rows(1, {""});
  bool quoted = false;
  for (const char c : file_text(file)) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted)
      rows.back().emplace_back();
    else if (c == '\n' && !quoted)
      rows.push_back({""});
    else
      rows.back().back() += c;
  }
  rows.pop_back();
  return rows;
}

/// Rows of a query of a database, absent values as "NULL".
inline Rows query(const std::filesystem::path& file, const std::string& sql) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READWRITE, nullptr) == SQLITE_OK);
  Rows rows;
  const auto row = [](void* to, int n, char** values, char**) {
    auto& list = static_cast<Rows*>(to)->emplace_back();
    for (int i = 0; i < n; ++i) list.emplace_back(values[i] ? values[i] : "NULL");
    return 0;
  };
  REQUIRE(sqlite3_exec(db, sql.c_str(), row, &rows, nullptr) == SQLITE_OK);
  sqlite3_close(db);
  return rows;
}

/// Values of a study for one run, by name, without absent ones.
using StudyRun = std::map<std::string, std::string>;
inline double value_of(const StudyRun& run, const std::string& name) {
  CAPTURE(name);
  REQUIRE(run.contains(name));
  return std::stod(run.at(name));
}

/// The scene of a case, and studies of it.
class StudyDesk {
 public:
  explicit StudyDesk(const std::string& name) {
    write_file(folder.path() / "scene.toml", file_text(source_folder() / "cases" / name / "scene.toml"));
  }
  /// Replaces a part of the scene's text.
  void change(const std::string& from, const std::string& to) const {
    const auto scene = folder.path() / "scene.toml";
    write_file(scene, replaced(file_text(scene), from, to));
  }
  Outcome sweep(const std::string& text, const std::string& options = "") const {
    write_file(folder.path() / "study.toml", text);
    return freeplay(fmt::format("sweep {} -o {} {}", (folder.path() / "study.toml").string(),
                                (folder.path() / "out").string(), options));
  }
  std::vector<StudyRun> table(const std::string& text) const {
    const auto o = sweep(text, "--export table.csv");
    CAPTURE(o.out, o.err);
    REQUIRE(o.status == 0);
    const auto rows = read_csv(folder.path() / "out/table.csv");
    std::vector<StudyRun> all;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      REQUIRE(rows[i].size() == rows[0].size());
      auto& run = all.emplace_back();
      for (std::size_t c = 0; c < rows[i].size(); ++c)
        if (!rows[i][c].empty()) run[rows[0][c]] = rows[i][c];
    }
    return all;
  }
  Rows ask(const std::string& sql) const { return query(folder.path() / "out/sweep.db", sql); }

  TemporaryFolder folder;
};

}  // namespace freeplay::test

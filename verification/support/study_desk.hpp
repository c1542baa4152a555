// A study in its own folder, read by the library or run by the program: its exported table, and queries of
// its database.
#pragma once

#include <fmt/format.h>
#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "io/files/output_file.hpp"
#include "study/settings/study.hpp"
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

/// Equal, or both absent.
inline bool same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Values of a study for one run, by name, without absent ones.
using StudyRun = std::map<std::string, std::string>;
inline double value_of(const StudyRun& run, const std::string& name) {
  CAPTURE(name);
  REQUIRE(run.contains(name));
  return std::stod(run.at(name));
}

/// The scene of the rig of Flores et al. (2011) with friction in its guide.
inline std::filesystem::path rig() { return source_folder() / "cases/flores2011-experiment/guide.toml"; }
/// The head of a study of the rig: a revolution after half a one, in both formulations, from two starts.
inline std::string rig_study(const std::string& scene = rig()) {
  return fmt::format(
      "scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\nposition = \"lvdt\"\n"
      "revolutions = 1\ndiscard = 0.5\nstarts = 2\n",
      scene);
}

/// [axes.name] with a list of values; `keys`: further lines.
inline std::string axis(const std::string& name, const std::string& key, const std::string& values,
                        const std::string& keys = "") {
  return fmt::format("[axes.{}]\nkey = \"{}\"\nvalues = [{}]\n{}", name, key, values, keys);
}
/// [measure.name]; `keys`: further lines.
inline std::string measure(const std::string& name, const std::string& column, const std::string& reduce,
                           const std::string& keys = "") {
  return fmt::format("[measure.{}]\ncolumn = \"{}\"\nreduce = \"{}\"\n{}", name, column, reduce, keys);
}
/// [calibrate.unknowns.name]; `keys`: further lines.
inline std::string unknown(const std::string& name, const std::string& key, double low, double high,
                           const std::string& keys = "") {
  return fmt::format("[calibrate.unknowns.{}]\nkey = \"{}\"\nlow = {}\nhigh = {}\n{}", name, key, low, high,
                     keys);
}
/// [calibrate.targets.name]; `keys`: its value or data, and its uncertainty.
inline std::string target(const std::string& name, const std::string& statistic, const std::string& keys) {
  return fmt::format("[calibrate.targets.{}]\nstatistic = \"{}\"\n{}", name, statistic, keys);
}

/// A folder with a study in study.toml and its results in out/.
class StudyDesk {
 public:
  StudyDesk() = default;
  /// With the scene of a case.
  explicit StudyDesk(const std::string& name) {
    put("scene.toml", file_text(source_folder() / "cases" / name / "scene.toml"));
  }
  std::filesystem::path at(const std::string& name) const { return folder.path() / name; }
  std::filesystem::path put(const std::string& name, const std::string& text) const {
    write_file(at(name), text);
    return at(name);
  }
  /// Replaces a part of the scene's text.
  void change(const std::string& from, const std::string& to) const {
    put("scene.toml", replaced(file_text(at("scene.toml")), from, to));
  }
  Study read(const std::string& text) const { return read_study(put("study.toml", text)); }
  /// The message with which a study is refused.
  std::string refusal(const std::string& text) const {
    return refusal_of<SceneError>([&] { read(text); });
  }
  Outcome run(const std::string& verb, const std::string& options = "") const {
    return freeplay(
        fmt::format("{} {} -o {} {}", verb, at("study.toml").string(), at("out").string(), options));
  }
  Outcome sweep(const std::string& text, const std::string& options = "") const {
    put("study.toml", text);
    return run("sweep", options);
  }
  std::vector<StudyRun> table(const std::string& text) const {
    const auto o = sweep(text, "--export table.csv");
    CAPTURE(o.out, o.err);
    REQUIRE(o.status == 0);
    const auto rows = read_csv(at("out/table.csv"));
    std::vector<StudyRun> all;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      REQUIRE(rows[i].size() == rows[0].size());
      auto& run = all.emplace_back();
      for (std::size_t c = 0; c < rows[i].size(); ++c)
        if (!rows[i][c].empty()) run[rows[0][c]] = rows[i][c];
    }
    return all;
  }
  Rows ask(const std::string& sql) const { return query(at("out/sweep.db"), sql); }

  TemporaryFolder folder;
};

/// A copy of the rig's scene and a study of four runs beside it, to be changed.
struct RigDesk : StudyDesk {
  std::filesystem::path scene = at("scene.toml"), study = at("study.toml"), out = at("out");
  std::string scene_text = file_text(rig()), study_text;
  explicit RigDesk(const std::string& head = "", const std::string& axes = "")
      : study_text(head + rig_study("scene.toml") + axes) {
    write_file(scene, scene_text);
    write_file(study, study_text);
  }
};

}  // namespace freeplay::test

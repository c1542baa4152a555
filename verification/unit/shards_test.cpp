// Studies divided: any number of shards, in any order, with interruptions, give what one process gives; and what is refused.
#include <fmt/format.h>
#include <sqlite3.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "study/partition/divided_sweep.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"
#include "study/partition/shard_file.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string text = R"(
scene = "scene.toml"
restitution = "as-given"
discard_time = "0.33 s"
duration = "0.3 s"
[axes.e]
key = "surfaces.hard.restitution"
range = [0.2, 0.8, 11]
[measure.highest]
column = "ball.y"
reduce = "max"
each = "period"
[derived]
rise = "highest - 0.05"
)";

struct Place {
  test::TemporaryFolder folder;
  Study study;
  Place() : study(read(text)) {}
  Study read(std::string of) {
    std::filesystem::copy_file(test::source_folder() / "cases/bouncing-ball/scene.toml",
                               folder.path() / "scene.toml",
                               std::filesystem::copy_options::overwrite_existing);
    const auto each = of.find("each = \"period\"\n");  // the scene has none
    if (each != of.npos) of.erase(each, 16);
    write_file(folder.path() / "study.toml", of);
    return read_study(folder.path() / "study.toml");
  }
  Division division() const { return divided_sweep(study, {}, "sweep", {"study.toml"}, subject_of(study)); }
  std::filesystem::path at(const std::string& name) const { return folder.path() / name; }
  ShardMade make(const std::string& into, std::size_t k, StopToken stop = {}) const {
    return make_shard(division(), at(into),
                      {.shard = k, .scratch = at("scratch"), .threads = 1, .stop = stop});
  }
};

/// All rows of what does not depend on the machine, in the order of their text.
std::vector<std::string> dump(const std::filesystem::path& file) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK);
  std::vector<std::string> rows;
  for (const std::string table :
       {"named", "turns", "flights", "impacts", "measures", "spectra", "traces", "work", "derived"}) {
    sqlite3_stmt* s = nullptr;
    INFO(table << ": " << sqlite3_errmsg(db));
    REQUIRE(sqlite3_prepare_v2(db, ("SELECT * FROM " + table).c_str(), -1, &s, nullptr) == SQLITE_OK);
    while (sqlite3_step(s) == SQLITE_ROW) {
      auto row = table;
      for (int c = 0; c < sqlite3_column_count(s); ++c) {
        const auto* bytes = static_cast<const char*>(sqlite3_column_blob(s, c));
        row += fmt::format("|{}:", sqlite3_column_type(s, c));
        if (sqlite3_column_type(s, c) == SQLITE_FLOAT)
          row += fmt::format("{:a}", sqlite3_column_double(s, c));
        else
          row.append(bytes ? bytes : "", static_cast<std::size_t>(sqlite3_column_bytes(s, c)));
      }
      rows.push_back(row);
    }
    sqlite3_finalize(s);
  }
  sqlite3_close(db);
  std::ranges::sort(rows);
  return rows;
}

std::vector<std::string> made_by_one(const Place& place) {
  make_folder(place.at("one"));
  {
    const FolderLock lock(place.at("one"), "sweep", FolderLock::Use::together);
    Results results(place.at("one") / "sweep.db", place.study);
    sweep(place.study, plan(place.study, {}), {}, results, lock, 1, {});
    results.derive(place.study);
  }
  return dump(place.at("one") / "sweep.db");
}

}  // namespace

TEST_CASE("shards of any number, in any order, merge to what one process makes", "[shards]") {
  const Place place;
  const auto expected = made_by_one(place);
  REQUIRE(expected.size() > 22);
  const std::size_t shards = GENERATE(1, 2, 5, 22);
  make_plan(place.division(), place.at("out"), shards);
  for (std::size_t k = shards; k >= 1; --k) CHECK_FALSE(place.make("out", k).found);
  CHECK(place.make("out", 1).found);
  const auto merged = merge_shards(place.division(), place.at("out"), place.at("scratch"));
  CHECK(merged.units == 22);
  CHECK(dump(place.at("out") / "sweep.db") == expected);
  CHECK(merge_shards(place.division(), place.at("out"), place.at("scratch")).found);
  CHECK(std::filesystem::is_empty(place.at("scratch")));
}

TEST_CASE("a shard that is stopped goes on where it was, from its copy on the shared folder", "[shards]") {
  const Place place;
  const auto expected = made_by_one(place);
  make_plan(place.division(), place.at("out"), 2);
  std::atomic<bool> stop{false};
  auto division = place.division();
  const auto made =
      make_shard(division, place.at("out"),
                 {.shard = 1,
                  .scratch = place.at("scratch"),
                  .threads = 1,
                  .stop = StopToken(stop),
                  .on_progress = [&](std::size_t done, std::size_t) { stop = stop || done >= 3; }});
  REQUIRE(made.interrupted);
  CHECK(state_of(place.at("out"), 1).state == "stopped");
  CHECK(std::filesystem::exists(place.at("out") / "shards/1.part.db"));
  std::size_t first = 0;
  make_shard(division, place.at("out"),
             {.shard = 1,
              .scratch = place.at("scratch"),
              .threads = 1,
              .stop = {},
              .on_progress = [&](std::size_t done, std::size_t) { first = first == 0 ? done : first; }});
  CHECK(first > 3);  // what was there is counted, and not made again
  CHECK_FALSE(std::filesystem::exists(place.at("out") / "shards/1.part.db"));
  place.make("out", 2);
  merge_shards(division, place.at("out"), place.at("scratch"));
  CHECK(dump(place.at("out") / "sweep.db") == expected);
}

TEST_CASE("missing and torn shards are refused with the command that makes them", "[shards][errors]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 4);
  for (std::size_t k : {1, 2, 4}) place.make("out", k);
  const auto refusal = [&] {
    try {
      merge_shards(place.division(), place.at("out"), place.at("scratch"));
    } catch (const SceneError& e) {
      return std::string(e.what());
    }
    return std::string("merged");
  };
  CHECK_THAT(refusal(), Contains("1 of 4 shards") && Contains("--shard 3/4 -o ") && Contains("missing"));
  CHECK_FALSE(std::filesystem::exists(place.at("out") / "sweep.db"));
  place.make("out", 3);
  const auto file = place.at("out") / "shards" / read_seal(place.at("out"), 2)->file;
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  CHECK_THAT(refusal(), Contains("--shard 2/4") && Contains("torn"));
  CHECK_FALSE(place.make("out", 2).found);
  {  // a byte turned over
    std::fstream damaged(place.at("out") / "shards" / read_seal(place.at("out"), 4)->file,
                         std::ios::in | std::ios::out);
    damaged.seekp(5000);
    damaged.put('\x7f');
  }
  CHECK_THAT(refusal(), Contains("--shard 4/4") && Contains("damaged"));
  place.make("out", 4);
  CHECK(refusal() == "merged");
}

TEST_CASE("a study that was changed since it was planned is refused", "[shards][errors]") {
  Place place;
  make_plan(place.division(), place.at("out"), 2);
  place.make("out", 1);
  auto other = text;
  other.replace(other.find("0.8"), 3, "0.7");
  place.study = place.read(other);
  CHECK_THROWS_WITH(place.make("out", 2), Contains("has changed since it was planned"));
  CHECK_THROWS_WITH(make_plan(place.division(), place.at("out"), 2), Contains("another plan"));
  CHECK_THROWS_WITH(merge_shards(place.division(), place.at("out"), place.at("scratch")),
                    Contains("changed"));
}

TEST_CASE("shards of another program are refused", "[shards][errors]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 1);
  auto m = read_manifest(place.at("out"));
  m.program += "instructions = \"another\"\n";
  CHECK_THROWS_WITH(require_same(m, place.division(), place.at("out")), Contains("another program"));
}

// Counts that are no whole numbers would be converted to what the language does not define.
TEST_CASE("what lies beside shards and has values of another kind is refused, in no library's words",
          "[shards][errors][security]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 2);
  place.make("out", 1);
  const auto shards = place.at("out") / "shards";
  const auto read = [](const std::filesystem::path& file) {
    return nlohmann::json::parse(std::ifstream(file));
  };
  const auto manifest = read(shards / "manifest.json"), seal = read(shards / "1.json");
  const auto missing = [](nlohmann::json j, const char* key) {
    j.erase(key);
    return j;
  };
  const auto with = [](nlohmann::json j, const char* key, const nlohmann::json& value) {
    j[key] = value;
    return j;
  };
  for (const auto& wrong :
       {missing(manifest, "units"), missing(manifest, "format"), with(manifest, "shards", "2"),
        with(manifest, "units", 11.5), with(manifest, "units", 1e300), with(manifest, "shards", -1),
        with(manifest, "arguments", {1}), with(manifest, "verb", nullptr), nlohmann::json::array()}) {
    write_file(shards / "manifest.json", wrong.dump());
    CAPTURE(wrong.dump());
    CHECK_THROWS_WITH(read_manifest(place.at("out")),
                      Contains("manifest.json: is no manifest of this freeplay (") && !Contains("json."));
  }
  write_file(shards / "manifest.json", manifest.dump());
  const auto whole = read_manifest(place.at("out"));
  REQUIRE(fault_of(*read_seal(place.at("out"), 1), whole, place.at("out"), true).empty());
  for (const auto& wrong : {missing(seal, "file"), with(seal, "bytes", -1), with(seal, "units", 1e300),
                            with(seal, "failed", 0.5), with(seal, "reasons", {1}), with(seal, "host", 7)}) {
    write_file(shards / "1.json", wrong.dump());
    CAPTURE(wrong.dump());
    CHECK(fault_of(*read_seal(place.at("out"), 1), whole, place.at("out"), true) == "its seal is damaged");
  }
  write_file(shards / "2.state.json", R"({"state": "running", "done": 1e300, "total": -5})");
  const auto state = state_of(place.at("out"), 2);
  CHECK(state.state == "running");
  CHECK(state.done == 0);
  CHECK(state.total == 0);
}

TEST_CASE("the five commands of docs/cluster.md do what they say", "[shards][docs]") {
  const Place place;
  std::ifstream page(test::source_folder() / "docs/cluster.md");
  std::string line;
  while (std::getline(page, line) && line != "```sh") {
  }
  std::vector<std::string> commands;
  while (std::getline(page, line) && line != "```") {
    REQUIRE(line.starts_with("freeplay "));
    commands.push_back(line.substr(9, line.find('#') - 9));
    if (const auto at = line.find("1/4"); at != line.npos)
      for (const char* k : {"2", "3", "4"})
        commands.push_back(commands[1].substr(0, at - 9) + k + commands[1].substr(at - 8));
  }
  REQUIRE(commands.size() == 8);
  for (const auto& command : commands) {
    INFO(command);
    CHECK(std::system(fmt::format("cd '{}' && '{}/freeplay' {} >>said 2>&1", place.folder.path().string(),
                                  FREEPLAY_BINARY_DIR, command)
                          .c_str()) == 0);
  }
  CHECK(dump(place.at("out/study/sweep.db")) == made_by_one(place));
}

TEST_CASE("chains of a basin are divided like runs, and none is made again after the merge", "[shards]") {
  const test::TemporaryFolder folder;
  const auto source = test::source_folder() / "cases/bistable-rotor";
  std::filesystem::copy(source, folder.path(), std::filesystem::copy_options::recursive);
  const auto study = folder.path() / "study.toml";
  std::ifstream in(study);
  std::string of{std::istreambuf_iterator<char>(in), {}};
  for (const auto& [from, to] : {std::pair("0.95, 39]", "0.95, 4]"), std::pair("6, 40]", "6, 3]")}) {
    REQUIRE(of.find(from) != of.npos);
    of.replace(of.find(from), std::string(from).size(), to);
  }
  write_file(study, of);
  const std::string verb = "basin";
  const auto run = [&](const std::string& rest) {
    return std::system(fmt::format("cd '{}' && '{}/freeplay' {} study.toml {} >>said 2>&1",
                                   folder.path().string(), FREEPLAY_BINARY_DIR, verb, rest)
                           .c_str());
  };
  REQUIRE(run("--plan 2 -o out") == 0);
  REQUIRE(run("--shard 2/2 -o out") == 0);
  CHECK(run("--merge out") / 256 == 2);
  REQUIRE(run("--shard 1/2 -o out") == 0);
  REQUIRE(run("--merge out") == 0);
  std::filesystem::remove(folder.path() / "said");
  run("-o out");
  std::ifstream said(folder.path() / "said");
  std::string first;
  std::getline(said, first);
  CHECK_THAT(first, Contains("were there, 0 made"));
}

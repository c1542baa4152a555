// Divided studies: any number of shards, in any order, with interruptions, gives the result of one
// process; and refusals.
#include "study/partition/divided.hpp"
#include "study/partition/division.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct Place : test::BallStudy {
  Study read = read_study(study);
  Place()
      : BallStudy(
            "range = [0.2, 0.8, 11]\n[measure.highest]\ncolumn = \"ball.y\"\nreduce = \"max\"\n[derived]\n"
            "rise = \"highest - 0.05\"") {}
  Division division() const { return divided_sweep(read, {}, "sweep", {"study.toml"}, subject_of(read)); }
  std::filesystem::path at(const std::string& name) const { return folder.path() / name; }
  ShardMade make(const std::string& into, std::size_t k, StopToken stop = {}) const {
    return make_shard(division(), at(into),
                      {.shard = k, .scratch = at("scratch"), .threads = 1, .stop = stop});
  }
};

/// All machine-independent rows, sorted by their text.
std::vector<std::string> dump(const std::filesystem::path& file) {
  const Database database(file, Database::Access::read);
  std::vector<std::string> rows;
  for (const std::string table :
       {"named", "turns", "flights", "impacts", "measures", "spectra", "traces", "work", "derived"}) {
    Database::Statement s(database, "SELECT * FROM " + table);
    while (s.step()) {
      rows.push_back(table);
      for (int c = 0; c < s.columns(); ++c)  // a number bit for bit, a text or blob byte for byte
        rows.back() += s.is_text(c) ? "|" + s.text(c) : fmt::format("|{:a} {}", s.number(c), s.text(c));
    }
  }
  std::ranges::sort(rows);
  return rows;
}

std::vector<std::string> made_by_one(const Place& place) {
  make_folder(place.at("one"));
  {
    const FolderLock lock(place.at("one"), "sweep", FolderLock::Use::together);
    Results results(place.at("one") / "sweep.db", place.read);
    sweep(place.read, plan(place.read, {}), {}, results, lock, 1, {});
    results.derive(place.read);
  }
  return dump(place.at("one") / "sweep.db");
}

}  // namespace

TEST_CASE("shards of any number, in any order, merge to the result of one process", "[shards]") {
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

TEST_CASE("a stopped shard resumes from its copy on the shared folder", "[shards]") {
  const Place place;
  const auto expected = made_by_one(place);
  make_plan(place.division(), place.at("out"), 2);
  std::atomic<bool> stop{false};
  std::size_t first = 0;
  const auto division = place.division();
  const auto make = [&](const auto& on_progress) {
    return make_shard(division, place.at("out"),
                      {.shard = 1,
                       .scratch = place.at("scratch"),
                       .threads = 1,
                       .stop = StopToken(stop),
                       .on_progress = on_progress});
  };
  REQUIRE(make([&](std::size_t done, std::size_t) { stop = stop || done >= 3; }).interrupted);
  CHECK(state_of(place.at("out"), 1).state == "stopped");
  CHECK(std::filesystem::exists(place.at("out") / "shards/1.part.db"));
  stop = false;
  make([&](std::size_t done, std::size_t) { first = first == 0 ? done : first; });
  CHECK(first > 3);  // existing runs are counted, and not repeated
  CHECK_FALSE(std::filesystem::exists(place.at("out") / "shards/1.part.db"));
  place.make("out", 2);
  merge_shards(division, place.at("out"), place.at("scratch"));
  CHECK(dump(place.at("out") / "sweep.db") == expected);
}

TEST_CASE("missing and damaged shards are refused with the command that makes them", "[shards][errors]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 4);
  for (std::size_t k : {1, 2, 4}) place.make("out", k);
  const auto refusal = [&] {
    return test::refusal_of<SceneError>(
        [&] { merge_shards(place.division(), place.at("out"), place.at("scratch")); });
  };
  CHECK_THAT(refusal(), Contains("1 of 4 shards") && Contains("--shard 3/4 -o ") && Contains("missing"));
  CHECK_FALSE(std::filesystem::exists(place.at("out") / "sweep.db"));
  place.make("out", 3);
  const auto file = place.at("out") / "shards" / read_seal(place.at("out"), 2)->file;
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  CHECK_THAT(refusal(), Contains("--shard 2/4") && Contains("incomplete"));
  CHECK_FALSE(place.make("out", 2).found);
  {  // one byte changed
    std::fstream damaged(place.at("out") / "shards" / read_seal(place.at("out"), 4)->file,
                         std::ios::in | std::ios::out);
    damaged.seekp(5000);
    damaged.put('\x7f');
  }
  CHECK_THAT(refusal(), Contains("--shard 4/4") && Contains("damaged"));
  place.make("out", 4);
  CHECK(refusal() == "accepted");
}

TEST_CASE("a study that changed after planning is refused", "[shards][errors]") {
  Place place;
  make_plan(place.division(), place.at("out"), 2);
  place.make("out", 1);
  test::put_ball_study(place.folder.path(), "range = [0.2, 0.7, 11]");
  place.read = read_study(place.study);
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

// Converting counts that are not integers is undefined in the language.
TEST_CASE("files beside shards with values of a wrong type are refused in the program's own words",
          "[shards][errors][security]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 2);
  place.make("out", 1);
  const auto shards = place.at("out") / "shards";
  const auto manifest = test::read_json(shards / "manifest.json"), seal = test::read_json(shards / "1.json");
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
                      Contains("manifest.json: is not a manifest of this version (") && !Contains("json."));
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
  CHECK(state.state.empty());
  CHECK(state.done == 0);
  CHECK(state.total == 0);
}

TEST_CASE("the five commands of docs/how-to/cluster.md work as described", "[shards][docs]") {
  const Place place;
  std::ifstream page(test::source_folder() / "docs/how-to/cluster.md");
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

TEST_CASE("starts of an ensemble are divided like runs, and none is repeated after the merge", "[shards]") {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto run = [&](const std::string& options) {
    return test::freeplay(
        fmt::format("ensemble {} --starts 3 --rows 3 --set run.revolutions=0.1 --set run.discard=0.02 {} {}",
                    test::flores().string(), options, out.string()));
  };
  REQUIRE(run("--plan 2 -o").status == 0);
  REQUIRE(run("--shard 2/2 -o").status == 0);
  CHECK(run("--merge").status == 2);
  REQUIRE(run("--shard 1/2 -o").status == 0);
  REQUIRE(run("--merge").status == 0);
  const auto again = run("-o");
  REQUIRE(again.status == 0);
  CHECK_THAT(again.out, Contains("3 starts, 3 finished"));
  for (const char* name : {"statistics.csv", "starts.csv", "bands.csv", "figures/ensemble.pdf"})
    CHECK(std::filesystem::exists(out / name));
  const auto outcome = test::read_json(out / "ensemble.json");
  CHECK(outcome["ensemble"]["finished"] == 3);
  CHECK(outcome["ensemble"]["cpu_seconds"] == 0);  // the time of starts is that of the made ones
  CHECK(test::freeplay("ensemble " + test::flores().string() + " --starts 1").status == 2);
}

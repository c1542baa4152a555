// Untrusted databases in every command that opens one: each is refused with one clear error, executes
// nothing, and leaves the contents inside and outside its folder unchanged. They are made by SQLite
// itself, with writable_schema, and by hand.
#include <fmt/format.h>
#include <sys/stat.h>
#include <catch2/catch.hpp>

#include <chrono>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "io/files/digest.hpp"
#include "study/partition/division.hpp"
#include "study/store/database.hpp"
#include "verification/process/untrusted_files/inputs.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/texts.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::execute;

namespace {

using Path = std::filesystem::path;

void put_bytes(const Path& file, std::streamoff at, const std::string& bytes) {
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  out.seekp(at);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Replaces a definition; SQLite permits this to anyone who writes the file.
std::string redefine(const std::string& name, const std::string& sql) {
  std::string quoted;
  for (const char c : sql) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return fmt::format("PRAGMA writable_schema = ON; UPDATE sqlite_master SET sql = {} WHERE name = '{}';",
                     sql.starts_with("sql ") ? sql : "'" + quoted + "'", name);
}

std::string big_endian(std::uint32_t x) {
  return {static_cast<char>(x >> 24), static_cast<char>(x >> 16), static_cast<char>(x >> 8),
          static_cast<char>(x)};
}

/// A rollback journal of no pages that names another file: SQLite would delete that one.
std::string journal_naming(const Path& other) {
  const std::string magic("\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"), name = other.string();
  std::string journal =
      magic + big_endian(0) + big_endian(1) + big_endian(2) + big_endian(512) + big_endian(4096);
  journal.resize(512, '\0');
  std::uint32_t sum = 0;
  for (const char c : name) sum += static_cast<std::uint32_t>(static_cast<signed char>(c));
  return journal + big_endian(0x40000000 / 4096 + 1) + name +
         big_endian(static_cast<std::uint32_t>(name.size())) + big_endian(sum) + magic;
}

/// What is planted: another content, a damaged copy, or a file beside the database, which is not read if the
/// database is intact.
enum class Kind { forged, damaged, beside };

struct Attack {
  const char* name;
  std::function<void(const Path& database, const Path& victim)> plant;
  Kind kind = Kind::forged;
  bool everywhere = false;  ///< also tried with every command that opens a database in the same way
};

const std::vector<Attack>& attacks() {
  using P = const Path&;
  using enum Kind;
  const auto sql = [](const std::string& text) { return [text](P file, P) { execute(file, text); }; };
  /// Statements behind the definition of a table, an index or a view.
  const auto behind = [](const char* name, const char* statements) {
    return [=](P file, P victim) {
      execute(file, redefine(name, fmt::format(
                                       fmt::runtime("sql || '; ATTACH ''{0}" + std::string(statements) + "'"),
                                       victim.string())));
    };
  };
  /// Another definition of the table of work.
  const auto work = [&](const std::string& state) {
    return sql("PRAGMA writable_schema = ON; UPDATE sqlite_master SET sql = replace(sql, 'state TEXT', '" +
               state + "') WHERE name = 'work'");
  };
  const auto instead = [](std::function<void(P file, P victim)> put) {
    return [=](P file, P victim) {
      std::filesystem::remove(file);
      put(file, victim);
    };
  };
  static const std::vector<Attack> list{
      {"trigger on runs",
       sql("CREATE TRIGGER t AFTER INSERT ON runs BEGIN UPDATE runs SET status = 'forged'; END")},
      {"trigger on processes at work",
       sql("CREATE TRIGGER t AFTER INSERT ON sweeps BEGIN DELETE FROM runs; DELETE FROM work; END"), forged,
       true},
      {"view that never ends",
       sql("DROP VIEW IF EXISTS named; "
           "CREATE VIEW named AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 "
           "FROM c) SELECT x AS run, x AS variant, x AS formulation, x AS start FROM c"),
       forged, true},
      {"view of another name", sql("CREATE VIEW more AS SELECT * FROM runs")},
      {"table of another name", sql("CREATE TABLE evil (x TEXT)")},
      {"file of another program", sql("PRAGMA application_id = 77")},
      {"rows of a run that is not there", sql("INSERT INTO turn_rows VALUES (99999, 1, 1)")},
      {"statements behind a table's definition", behind("work", "'' AS v; DROP TABLE v.precious")},
      {"statements behind an index's definition", behind("work_state", "'' AS v; DROP TABLE v.precious")},
      {"statements behind a view's definition, which make a file",
       behind("turns", ".made'' AS v; CREATE TABLE v.x (y)")},
      {"virtual table",
       sql("PRAGMA writable_schema = ON; INSERT INTO sqlite_master VALUES ('table', 'v', 'v', 0, "
           "'CREATE VIRTUAL "
           "TABLE v USING csv(filename=''/etc/passwd'')')")},
      {"generated column", sql("ALTER TABLE work ADD COLUMN g TEXT AS (hex(zeroblob(100000000)))")},
      {"expression index", sql("CREATE INDEX turn_rows_run ON turn_rows(abs(peak))")},
      {"partial index", sql("CREATE INDEX turn_rows_run ON turn_rows(id) WHERE peak > 0")},
      {"default that is an expression", work("state TEXT DEFAULT (hex(zeroblob(100000000)))")},
      {"check that is an expression", work("state TEXT CHECK (load_extension(''/tmp/x''))")},
      {"two tables of one page",
       sql("PRAGMA writable_schema = ON; "
           "UPDATE sqlite_master SET rootpage = (SELECT rootpage FROM sqlite_master "
           "WHERE name = 'work') WHERE name = 'turn_rows'"),
       damaged},
      {"definition that is a blob",
       sql("PRAGMA writable_schema = ON; "
           "UPDATE sqlite_master SET sql = CAST(sql || x'00' || 'x' AS BLOB) WHERE name = "
           "'work'")},
      {"UTF-16",
       [](P file, P) {
         std::string made = "PRAGMA encoding = 'UTF-16le'; PRAGMA user_version = 3;";
         for (const auto& object : Database(file, Database::Access::read).schema()) made += object.sql + ";";
         std::filesystem::remove(file);
         execute(file, made);
       }},
      {"half of it",
       [](P file, P) { std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2); }, damaged},
      {"its first 100 bytes", [](P file, P) { std::filesystem::resize_file(file, 100); }, damaged},
      {"another page size", [](P file, P) { put_bytes(file, 16, std::string("\x02\x00", 2)); }, damaged},
      {"a size of 8 TB in its header", [](P file, P) { put_bytes(file, 28, big_endian(0x7fffffff)); },
       damaged},
      {"a hole of 1 TiB", [](P file, P) { std::filesystem::resize_file(file, std::uintmax_t{1} << 40); },
       forged, true},
      {"a page of random bytes",
       [](P file, P) {
         std::string page;
         for (std::uint64_t i = 0; page.size() < 4096; ++i) page += digest(std::to_string(i));
         put_bytes(file, 4096, page.substr(0, 4096));
       },
       damaged},
      {"FIFO", instead([](P file, P) { REQUIRE(mkfifo(file.c_str(), 0600) == 0); }), forged, true},
      {"link to /dev/zero", instead([](P file, P) { std::filesystem::create_symlink("/dev/zero", file); })},
      {"link to another database",
       instead([](P file, P victim) { std::filesystem::create_symlink(victim, file); })},
      {"folder", instead([](P file, P) { make_folder(file); })},
      {"log with a trigger",
       [](P file, P) {
         execute(
             file,
             "PRAGMA journal_mode = WAL; CREATE TRIGGER t AFTER INSERT ON sweeps BEGIN DELETE FROM runs; END",
             true);
         REQUIRE(std::filesystem::file_size(file.string() + "-wal") > 0);
         std::filesystem::remove(file.string() + "-shm");
       },
       beside, true},
      {"FIFO as its log", [](P file, P) { REQUIRE(mkfifo((file.string() + "-wal").c_str(), 0600) == 0); },
       beside},
      {"journal with a reference to another file",
       [](P file, P victim) {
         execute(file, "PRAGMA journal_mode = DELETE");
         write_file(file.string() + "-journal", journal_naming(victim));
       },
       beside}};
  return list;
}

/// Content of a folder: names, kinds and bytes, except traces of a command.
std::map<std::string, std::string> contents(const Path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const auto name = entry.path().lexically_relative(folder).string();
    if (name.ends_with(".freeplay.lock") || name.ends_with(".state.json")) continue;
    const auto status = entry.symlink_status();
    all[name] = fmt::format("{} ", static_cast<int>(status.type()));
    if (std::filesystem::is_symlink(status))
      all[name] += std::filesystem::read_symlink(entry.path()).string();
    if (!std::filesystem::is_regular_file(status)) continue;
    const auto size = entry.file_size();
    all[name] += fmt::format("{} {}", size, size < (1u << 30) ? digest(test::file_text(entry.path())) : "");
  }
  return all;
}

struct Place : test::Sandbox {
  Place() {
    test::put_ball_study(bait.folder, "values = [0.4, 0.5, 0.6, 0.7]", "formulations = [\"nonsmooth\"]\n");
    for (const std::string options :
         {"-o out", "--plan 2 -o divided", "--shard 1/2 -o divided", "--shard 2/2 -o divided"})
      REQUIRE(run_scratch("sweep study.toml " + options).status == 0);
    execute(victim(), "CREATE TABLE precious (x TEXT)");
  }
  /// Runs a command, one on shards with a scratch folder in the sandbox.
  test::Outcome run_scratch(std::string command) const {
    for (const char* option : {"--shard", "--merge"})
      if (command.find(option) != command.npos)
        command += " --scratch " + (folder.path() / "scratch").string();
    return run(command);
  }
  Path victim() const { return folder.path() / "victim.db"; }
  /// The file of shard 1, as named by its seal.
  Path shard() const {
    return at("divided/shards") / test::read_json(at("divided/shards/1.json"))["file"].get<std::string>();
  }
  /// Updates the seal for the changed file, as its maker could.
  void seal_again() const {
    const auto file = at("divided/shards/1.json"), place = shard();
    auto seal = test::read_json(file);
    if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(place))) return;
    seal["bytes"] = std::filesystem::file_size(place);
    if (seal["bytes"] < (1u << 30)) seal["checksum"] = file_checksum(place);
    write_file(file, seal.dump());
  }
};

/// Plants the file, runs the command, checks its output and the remaining files, and restores the
/// original.
void assess(const Place& place, const Attack& attack, const Path& database, const std::string& command,
            const std::function<void()>& prepare = {}) {
  CAPTURE(attack.name, command);
  const auto work = place.bait.folder, kept = place.folder.path() / "kept";
  std::filesystem::copy(work, kept, std::filesystem::copy_options::recursive);
  attack.plant(database, place.victim());
  if (prepare) prepare();
  const auto before = contents(work);
  const auto victim = test::file_text(place.victim());
  const auto began = std::chrono::steady_clock::now();
  const auto outcome = place.run_scratch(command);
  CAPTURE(outcome.out, outcome.err);
  CHECK((outcome.status == 1 || outcome.status == 2));
  CHECK_THAT(outcome.err,
             Contains(database.filename().string()) || Contains("1 of 2 shards cannot be merged"));
  CHECK(std::ranges::count(outcome.err, '\n') == 1);
  CHECK(contents(work) == before);
  CHECK(test::file_text(place.victim()) == victim);
  CHECK_FALSE(std::filesystem::exists(place.victim().string() + ".made"));
  // Reading the file once takes milliseconds, planning a study a second; the bound includes a
  // margin for sanitizers and a busy machine.
  CHECK(std::chrono::steady_clock::now() - began < std::chrono::seconds(40));
  std::filesystem::remove_all(work);
  std::filesystem::rename(kept, work);
}

}  // namespace

TEST_CASE("an untrusted database of a sweep is refused: sweep, sweep --prune, report",
          "[security][study][untrusted-databases]") {
  const Place place;
  for (const auto& attack : attacks())
    for (const char* command : {"sweep study.toml -o out", "sweep study.toml --prune -o out", "report out"})
      assess(place, attack, place.at("out/sweep.db"), command);
  // Nothing of all this was left: the study goes on.
  CHECK_THAT(place.run("sweep study.toml -o out").out, Contains("4 from the store, 0 new"));
  CHECK(place.run("report out").status == 0);
}

TEST_CASE("an untrusted shard is refused: sweep --merge", "[security][shards][untrusted-databases]") {
  const Place place;
  for (const auto& attack : attacks())
    if (attack.kind != Kind::beside)
      assess(place, attack, place.shard(), "sweep study.toml --merge divided", [&] { place.seal_again(); });
  CHECK(place.run_scratch("sweep study.toml --merge divided").status == 0);
}

TEST_CASE("an untrusted copy of an unfinished shard is refused: sweep --shard",
          "[security][shards][untrusted-databases]") {
  const Place place;
  const auto part = place.at("divided/shards/1.part.db");
  const auto good = place.folder.path() / "good.db";
  std::filesystem::rename(place.shard(), good);
  for (const auto& attack : attacks()) {
    if (attack.kind == Kind::beside) continue;
    std::filesystem::copy_file(good, part);
    const std::string command = "sweep study.toml --shard 1/2 -o divided";
    if (attack.kind == Kind::damaged) {  // it is made again
      CAPTURE(attack.name);
      attack.plant(part, place.victim());
      CHECK(place.run_scratch(command).status == 0);
      CHECK_FALSE(std::filesystem::exists(part));
      std::filesystem::remove(place.shard());
    } else {
      assess(place, attack, part, command);
      std::filesystem::remove_all(part);
    }
  }
}

TEST_CASE("an untrusted database is refused by every other command that uses one",
          "[security][study][untrusted-databases]") {
  const Place place;
  const auto copy_case = [&](const char* name, const char* to) {
    std::filesystem::copy(test::source_folder() / "cases" / name, place.at(to),
                          std::filesystem::copy_options::recursive);
  };
  copy_case("bistable-rotor", "rotor");
  copy_case("ball-on-table", "ball");
  // A study compared with the experiment, with a fit and without; with few starts, since they are
  // planned before the database is opened.
  const auto change = [&](const char* file, const std::string& from, const std::string& to) {
    write_file(place.at(file), test::replaced(test::file_text(place.at(file)), from, to));
  };
  for (const char* kind : {"fitted", "plain"}) copy_case("flores2011-experiment", kind);
  change("plain/study.toml", "fit = \"calibrate.toml\"\n", "");
  for (const char* file : {"fitted/study.toml", "plain/study.toml", "fitted/calibrate.toml"})
    change(file, "\nstarts = 8\n", "\nstarts = 1\n");
  change("fitted/calibrate.toml", "\npoints = 80\nstarts = 3\n", "\npoints = 17\nstarts = 1\n");
  for (const auto& [database, command] :
       {std::pair<std::string, std::string>{"ensemble.db", "ensemble scene.toml --starts 2 -o other"},
        {"basin.db", "basin rotor/study.toml -o other"},
        {"bifurcation.db", "bifurcation ball/study.toml -o other"},
        {"calibrate.db", "calibrate fitted/calibrate.toml -o other"},
        {"calibrate.db", "validate fitted/study.toml -o other"},
        {"sweep.db", "validate plain/study.toml -o other"}})
    for (const auto& attack : attacks()) {
      if (!attack.everywhere) continue;
      make_folder(place.at("other"));
      std::filesystem::copy_file(place.at("out/sweep.db"), place.at("other") / database);
      assess(place, attack, place.at("other") / database, command);
      std::filesystem::remove_all(place.at("other"));
    }
}

TEST_CASE("only exact definitions of this program are accepted in a database",
          "[security][untrusted-databases]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "some.db";
  const std::string
      work = "CREATE TABLE work (run TEXT PRIMARY KEY, state TEXT, seat INTEGER)",
      runs = "CREATE TABLE runs (run TEXT UNIQUE, \"a speed\" REAL, \"run id\" INTEGER PRIMARY KEY)",
      kept = " WHERE runs.run NOT IN (SELECT run FROM work WHERE state = 'kept')";
  // With the definition as it stands in the file, and that of `work` if there is another one.
  const auto own = [&](const std::string& type, const std::string& name, const char* table,
                       const std::string& sql) {
    const std::map<std::string, std::string> rest{{"table", " (run TEXT, state TEXT, seat INTEGER)"},
                                                  {"index", fmt::format(" ON {}(run)", table)},
                                                  {"view", " AS SELECT 1"},
                                                  {"trigger", " AFTER INSERT ON work BEGIN SELECT 1; END"}};
    std::filesystem::remove(file);
    execute(file, runs + ";" + (name == "work" ? "" : work + ";") +
                      fmt::format("CREATE {} {}{};", type, name, rest.at(type)));
    execute(file, redefine(name, sql));
    try {
      const Database opened(file, Database::Access::read);
      return true;
    } catch (const SceneError&) {
      return false;
    }
  };
  CHECK(own("index", "work_state", "work", "CREATE INDEX work_state ON work(state)"));
  CHECK(own("view", "named", "named",
            "CREATE VIEW named AS SELECT runs.run, runs.\"a speed\" FROM runs" + kept));
  {
    // From an earlier version: report shows such a sweep.
    const std::string
        turns =
            "CREATE TABLE turns (run TEXT REFERENCES runs(run) ON DELETE CASCADE, turn INTEGER, peak REAL)",
        named = "CREATE VIEW named AS SELECT runs.* FROM runs" + kept;
    std::filesystem::remove(file);
    execute(file,
            "CREATE TABLE runs (run TEXT PRIMARY KEY, variant TEXT);" + work + ";" + turns + ";" + named);
    const Database earlier(file, Database::Access::read);
    CHECK(columns_of(earlier, "turns") == std::vector<std::string>{"run", "turn", "peak"});
  }
  for (const std::string& wrong : std::vector<std::string>{
           work + ";", work + " STRICT", work + "; DROP TABLE runs", "CREATE TABLE work (run)",
           "CREATE TABLE work (run TEXT, )", "CREATE TABLE work (run TEXT DEFAULT (1))",
           "CREATE TABLE work (run TEXT CHECK (run > 1))", "CREATE TABLE work (run TEXT COLLATE NOCASE)",
           "CREATE TABLE work (run TEXT, g TEXT AS (1))", "CREATE TABLE work (\"a\nb\" TEXT)",
           "CREATE TABLE work (\"a\"\"b\" TEXT)", "create table work (run TEXT)",
           "CREATE TABLE work AS SELECT 1", "CREATE TABLE runs (run TEXT)", ""}) {
    CAPTURE(wrong);
    CHECK_FALSE(own("table", "work", "work", wrong));
  }
  CHECK_FALSE(own("table", "evil", "evil", "CREATE TABLE evil (run TEXT)"));
  CHECK_FALSE(own("trigger", "t", "work", work));
  CHECK_FALSE(own("index", "work_state", "runs", "CREATE INDEX work_state ON work(state)"));
  CHECK_FALSE(own("view", "named", "named", "CREATE VIEW named AS SELECT runs.run FROM runs WHERE 1"));
  CHECK_FALSE(own("view", "named", "named", "CREATE VIEW named AS SELECT runs.abs(1) FROM runs"));
  CHECK_FALSE(own("view", "named", "named", "CREATE VIEW named AS SELECT runs.run, abs(1) FROM runs" + kept));
}

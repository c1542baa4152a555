// Result folders used by several processes: one writes, sweeps share; an invalid study changes
// nothing.
#include <unistd.h>
#include <atomic>
#include <thread>

#include "cli/folders.hpp"
#include "facade/run_folder.hpp"
#include "io/files/result_set.hpp"
#include "io/scene/read_scene.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/process/crash_recovery/campaign.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using killed::runs_in;

namespace {

using test::replaced;

/// The rig's study of four runs, at one clearance and speed.
struct Desk : test::RigDesk {
  Desk()
      : RigDesk("claims = \"flores2011\"\n",
                "[axes.clearance]\nkey = \"joints.gudgeon.clearance\"\nvalues = [0.5e-3]\n"
                "[axes.speed]\nkey = \"drives.motor.speed_rpm\"\nvalues = [200.0]\n") {}
  killed::Contents runs() const { return runs_in(at("out/sweep.db")); }
};

/// This number of simultaneous sweeps makes the study's runs once.
void shared_by(int processes, const Desk& desk, const killed::Contents& expected) {
  CAPTURE(processes);
  const auto place = desk.at(fmt::format("shared{}", processes));
  std::vector<test::Outcome> outcomes(processes);
  std::vector<std::thread> all;
  for (auto& outcome : outcomes)
    all.emplace_back([&] {
      outcome =
          test::freeplay(fmt::format("sweep {} -o {} --threads 1", desk.study.string(), place.string()));
    });
  for (auto& one : all) one.join();
  std::size_t made = 0;
  for (const auto& o : outcomes) {
    CAPTURE(o.out, o.err);
    CHECK(o.status == 0);
    std::size_t total = 0, found = 0, own = 0;
    CHECK(std::sscanf(o.out.c_str(), "%zu runs: %zu from the store, %zu new", &total, &found, &own) == 3);
    CHECK(total == expected.size());
    made += own;
  }
  CHECK(made == expected.size());
  CHECK(runs_in(place / "sweep.db") == expected);
  CHECK(killed::leftovers_in(place).empty());
}

}  // namespace

TEST_CASE("an invalid study changes none of the existing runs", "[study][folders]") {
  Desk desk;
  REQUIRE(desk.run("sweep").status == 0);
  const auto there = desk.runs();
  REQUIRE(there.size() == 4);
  for (const auto& [from, to, expected] : std::vector<test::Edit>{
           {"\"gudgeon\"", "\"gudgen\"", ": joint: \"gudgen\" has no clearance"},
           {"\"accelerometer\"", "\"lvdt\"", ": accelerometer: \"lvdt\" is not an instrument"},
           {"\"lvdt\"", "\"lvtd\"", ": position: \"lvtd\" is not an instrument"},
           {"joints.gudgeon.clearance", "joints.gudgeon.clearanse", "clearanse"},
           {"[0.5e-3]", "[0.5e-3, -1.0]", "clearance"},
           {"[0.5e-3]", "\"wide\"", "values"},
           {"[200.0]", "[200.0, 0.0]", "drive"},
           {"starts = 2", "starts = 0", "starts"},
           // The last of many scenes: a variant whose guide is perpendicular to the crank's circle
           // cannot be assembled.
           {"[axes.clearance]",
            "[variants.far]\nset = [\"joints.gudgeon.at=[[5.0, 0.0], [0.0, 0.0]]\", "
            "\"run.start=assembled\", \"joints.guide.at=[[0.0, 9.0], [0.0, 0.0]]\"]\n[axes.clearance]",
            "scene.toml"}}) {
    write_file(desk.study, replaced(desk.study_text, from, to));
    for (const char* verb : {"sweep", "validate"}) {
      const auto o = desk.run(verb);
      CAPTURE(to, verb, o.out, o.err);
      CHECK(o.status == 2);
      CHECK(std::ranges::count(o.err, '\n') == 1);
      CHECK_THAT(o.err, Contains(expected));
      CHECK(desk.runs() == there);
    }
  }
  write_file(desk.study, desk.study_text);
  // The scene itself.
  desk.change("[joints.gudgeon]", "[joints.gudgen]");
  CHECK(desk.run("sweep").status == 2);
  CHECK(desk.runs() == there);
  // A change without effect repeats no run, and removes none.
  write_file(desk.scene, "title = \"The same by another name\"\n# A remark.\n" +
                             replaced(desk.scene_text, "title", "# title"));
  CHECK_THAT(desk.run("sweep").out, Contains("4 from the store, 0 new") && !Contains("kept"));
  CHECK(desk.runs() == there);
}

TEST_CASE("runs that a study does not contain are kept until they are pruned", "[study][folders]") {
  Desk desk;
  REQUIRE(desk.run("sweep").status == 0);
  const auto there = desk.runs();
  auto o = desk.sweep(replaced(desk.study_text, "starts = 2", "starts = 1"));
  CHECK_THAT(o.out, Contains("2 runs: 2 from the store, 0 new") && Contains("2 further runs are kept") &&
                        Contains("--prune"));
  CHECK(desk.runs() == there);
  o = desk.run("sweep", "--prune");
  CHECK(o.status == 0);
  CHECK_THAT(o.out, Contains("given, nonsmooth: 1 runs that are not part of the study") &&
                        Contains("given, penalty: 1 runs") && Contains("2 removed from"));
  CHECK(desk.runs().size() == 2);
  CHECK_THAT(desk.run("sweep", "--prune").out, Contains("0 removed from"));
  const auto none = desk.at("none");
  CHECK(test::freeplay(fmt::format("sweep {} --prune -o {}", desk.study.string(), none.string())).status ==
        2);
  CHECK_FALSE(std::filesystem::exists(none));
}

TEST_CASE("sweeps that share a study make each run once, with the results of a single sweep",
          "[study][folders]") {
  Desk desk;
  REQUIRE(desk.sweep(replaced(desk.study_text, "[0.5e-3]", "[0.25e-3, 0.5e-3]"), "--threads 1").status == 0);
  const auto expected = desk.runs();
  REQUIRE(expected.size() == 8);
  for (const int processes : {2, 4}) shared_by(processes, desk, expected);
  // One of two is killed: the other makes its claimed runs.
  const auto place = desk.at("killed");
  const killed::Words words{"sweep", desk.study.string(), "-o", place.string(), "--threads", "1"};
  std::thread one([&] { killed::kill_after(words, 0.3); });
  const auto other = killed::let_end(words);
  one.join();
  CHECK(other.status == 0);
  CHECK(runs_in(place / "sweep.db") == expected);
}

// scripts/kill-test
TEST_CASE("eight sweeps share a study of 64 runs", "[.campaign]") {
  if (!std::getenv("FREEPLAY_KILLS")) return;
  Desk desk;
  const auto text =
      replaced(replaced(desk.study_text, "[0.5e-3]", "[0.25e-3, 0.5e-3]"), "starts = 2", "starts = 16");
  REQUIRE(desk.sweep(text, "--threads 1").status == 0);
  const auto expected = desk.runs();
  REQUIRE(expected.size() == 64);
  for (const int processes : {2, 4, 8}) shared_by(processes, desk, expected);
}

TEST_CASE("one version of a study is in use at a time, and only living processes hold claims",
          "[study][folders]") {
  Desk desk;
  const auto study = read_study(desk.study);
  const auto folder = desk.folder.path();
  Results mine(folder / "sweep.db", study), theirs(folder / "sweep.db", study);
  const FolderLock first(folder, "sweep", FolderLock::Use::together);
  std::optional<FolderLock> second;
  second.emplace(folder, "sweep", FolderLock::Use::together);
  CHECK(first.slot() != second->slot());
  CHECK(first.taken(second->slot()));
  const std::vector<std::string> runs{"a", "b"}, others{"a", "c"};
  WorkList list(mine.database(), first, runs, WorkList::Earlier::kept);
  CHECK(list.claim(1) == std::vector<std::string>{"a"});
  CHECK_THROWS_WITH(WorkList(theirs.database(), *second, others, WorkList::Earlier::kept),
                    Contains("another form of this study") && Contains(std::to_string(getpid())));
  {
    WorkList same(theirs.database(), *second, runs, WorkList::Earlier::kept);
    CHECK(same.claim(1) == std::vector<std::string>{"b"});
    CHECK(same.claim(1).empty());
    CHECK(list.claim(1).empty());
  }  // releases b
  CHECK(list.claim(1) == std::vector<std::string>{"b"});
  CHECK_FALSE(list.ended());
}

TEST_CASE("one writer in a folder: refusals name the process that holds it", "[folders]") {
  Desk desk;
  make_folder(desk.out);
  const auto scene = test::flores().string() + " --set run.revolutions=0.02 --set run.discard=0";
  const std::string study = desk.study;
  const std::vector<std::string> commands{"run " + scene + " --formulation nonsmooth",
                                          "compare " + scene,
                                          "drift " + scene,
                                          "laws " + test::flores().string(),
                                          "sweep " + study,
                                          "validate " + study,
                                          "tradeoff " + study,
                                          "validate " + test::flores().string() + " --data none.csv",
                                          "extremes"};
  {
    const FolderLock lock(desk.out, "compare");
    for (const auto& command : commands) {
      const auto o = test::freeplay(command + " -o " + desk.out.string());
      CAPTURE(command, o.out, o.err);
      CHECK(o.status == 1);
      CHECK_THAT(o.err, Contains("another freeplay process writes to this folder (freeplay compare, "
                                 "process " +
                                 std::to_string(getpid()) + " on ") &&
                            Contains("since 20"));
      CHECK(std::ranges::count(o.err, '\n') == 1);
    }
    CHECK(test::freeplay("figures " + desk.out.string()).status == 1);
    CHECK(std::ranges::distance(std::filesystem::directory_iterator(desk.out)) == 1);
  }
  CHECK(std::filesystem::is_empty(desk.out));
  const FolderLock shared(desk.out, "sweep", FolderLock::Use::together);
  CHECK_THROWS_AS(FolderLock(desk.out, "compare"), OutputError);
  CHECK_NOTHROW(FolderLock(desk.out, "sweep", FolderLock::Use::together));
}

TEST_CASE("an interrupted run keeps the finished one in its folder and can be resumed", "[resume][folders]") {
  test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto scene = [](const char* revolutions) {
    return read_scene(test::flores(), {std::string("run.revolutions=") + revolutions, "run.discard=0"});
  };
  RunPlan plan{.formulation = "nonsmooth", .folder = out, .checkpoint = 30};
  REQUIRE(run_scene(scene("0.1"), plan).ending.status == Ending::Status::finished);
  const auto older = killed::results_in(out);
  REQUIRE(older.size() == 4);
  std::atomic<bool> requested{false};
  plan.stop = StopToken(requested);
  plan.on_progress = [&](double done) { requested = done > 0.3; };
  const auto interrupted = run_scene(scene("0.2"), plan);
  REQUIRE(interrupted.ending.status == Ending::Status::interrupted);
  CHECK_THAT(interrupted.notes.back(), Contains("the finished run in the folder was kept"));
  CHECK(killed::results_in(out) == older);
  // Without its incomplete file there is nothing to resume, and the older file is not a
  // replacement.
  const auto half = out / "trajectory.csv.partial", aside = folder.path() / "aside";
  std::filesystem::rename(half, aside);
  CHECK_THROWS_AS(resume_run(out, {.checkpoint = 30}), std::runtime_error);
  CHECK(killed::results_in(out) == older);
  std::filesystem::rename(aside, half);
  CHECK(resume_run(out, {.checkpoint = 30}).ending.status == Ending::Status::finished);
  const auto whole = folder.path() / "whole";
  REQUIRE(run_scene(scene("0.2"), {.formulation = "nonsmooth", .folder = whole}).ending.status ==
          Ending::Status::finished);
  CHECK(killed::results_in(out) == killed::results_in(whole));
  CHECK(killed::leftovers_in(out).empty());
}

TEST_CASE("a database held by another program is waited for until a stop request", "[study][folders]") {
  Desk desk;
  const auto study = read_study(desk.study);
  const auto file = desk.folder.path() / "sweep.db";
  const Results holder(file, study);
  const Database::Transaction held(holder.database());
  std::atomic<bool> requested{false};
  std::thread stop([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    requested = true;
  });
  const auto began = std::chrono::steady_clock::now();
  CHECK_THROWS_WITH(Results(file, study, StopToken(requested)), Contains("another program uses it"));
  const auto waited = std::chrono::steady_clock::now() - began;
  stop.join();
  CHECK(waited > std::chrono::milliseconds(150));
  CHECK(waited < std::chrono::seconds(20));
}

TEST_CASE("a database with keys of another kind is neither used nor lost", "[study][folders]") {
  const Desk desk;
  REQUIRE(desk.run("sweep").status == 0);
  CHECK(desk.ask("PRAGMA user_version")[0][0] == "3");
  for (const auto& [version, who] :
       {std::pair(0, "an earlier version"), {1, "an earlier version"}, {4, "a later version"}}) {
    desk.ask(fmt::format("PRAGMA user_version = {}", version));
    const auto o = desk.run("sweep");
    CAPTURE(o.out, o.err);
    CHECK(o.status == 1);
    CHECK_THAT(o.err, Contains((desk.out / "sweep.db").string()) && Contains(who) &&
                          Contains("cannot be used") && Contains("give another folder with -o"));
    CHECK(std::ranges::count(o.err, '\n') == 1);
    CHECK(o.out.empty());
    CHECK(desk.ask("SELECT count(*) FROM runs")[0][0] == "4");
  }
  desk.ask("PRAGMA user_version = 3");
  CHECK_THAT(desk.run("sweep").out, Contains("4 from the store, 0 new"));
}

TEST_CASE("a planted lock file is not followed", "[folders]") {
  test::TemporaryFolder folder;
  const auto victim = folder.path() / "victim", lock = folder.path() / "out/.freeplay.lock";
  make_folder(folder.path() / "out");
  write_file(victim, "kept");
  std::filesystem::create_symlink(victim, lock);
  CHECK_THROWS_WITH(FolderLock(folder.path() / "out", "run"), Contains("is a link"));
  std::filesystem::remove(lock);
  std::filesystem::create_hard_link(victim, lock);
  CHECK_THROWS_WITH(FolderLock(folder.path() / "out", "run"), Contains("must be a regular file"));
  CHECK(test::file_text(victim) == "kept");
}

TEST_CASE("results are replaced as a whole, and links are not followed", "[folders]") {
  test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto make = [&](const char* text, bool commit) {
    ResultSet set(out, "compare");
    make_folder(set.place() / "penalty");
    write_file(set.place() / "comparison.json", text);
    write_file(set.place() / "penalty/run.json", text);
    if (std::string_view(text) == "one") write_file(set.place() / "penalty/forces.csv", text);
    if (commit) set.commit();
  };
  make("nothing", false);
  CHECK_FALSE(std::filesystem::exists(out));
  make("one", true);
  write_file(out / "penalty/notes.txt", "the user's");
  make("two", false);
  CHECK(test::file_text(out / "comparison.json") == "one");
  make("two", true);
  CHECK(test::file_text(out / "penalty/run.json") == "two");
  CHECK_FALSE(std::filesystem::exists(out / "penalty/forces.csv"));  // of the older
  CHECK(test::file_text(out / "penalty/notes.txt") == "the user's");
  // A folder that is a link.
  make_folder(folder.path() / "elsewhere");
  write_file(folder.path() / "elsewhere/run.json", "kept");
  std::filesystem::remove_all(out / "penalty");
  std::filesystem::create_directory_symlink(folder.path() / "elsewhere", out / "penalty");
  CHECK_THROWS_WITH(make("three", true), Contains("is a link"));
  CHECK(test::file_text(folder.path() / "elsewhere/run.json") == "kept");
}

TEST_CASE("a planted half-moved result set moves only files of the command, and through no link",
          "[folders]") {
  test::TemporaryFolder folder;
  const auto out = folder.path() / "received", home = folder.path() / "home";
  make_folder(out / ".laws.complete/a/keys");
  make_folder(home / "keys");
  write_file(home / "keys/one", "kept");
  write_file(out / ".laws.complete/a/keys/one", "planted");
  write_file(out / ".laws.complete/laws.json", "{}");
  std::filesystem::create_directory_symlink(home, out / "a");
  settle_result_sets(out);
  CHECK(test::file_text(home / "keys/one") == "kept");
  CHECK(test::file_text(out / "laws.json") == "{}");
  CHECK_FALSE(std::filesystem::exists(out / ".laws.complete"));
}

TEST_CASE("obstacles to new results are reported before any older result is removed", "[folders]") {
  test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  make_folder(out);
  write_file(out / "comparison.json", "older");
  const auto refused = [&](const char* why) {
    CHECK_THROWS_WITH(ResultSet(out, "compare"), Contains(why));
    CHECK(test::file_text(out / "comparison.json") == "older");
  };
  write_file(out / "penalty", "a file");
  refused("is a file, but a folder is needed");
  std::filesystem::remove(out / "penalty");
  write_file(out / ".compare.complete", "a file");
  refused("is a file, but a folder is needed");
  std::filesystem::remove(out / ".compare.complete");
  make_folder(out / "comparison.md");
  refused("is a folder, but a result file is needed");
  std::filesystem::remove(out / "comparison.md");
  {
    ResultSet set(out, "compare");
    write_file(set.place() / "comparison.json", "newer");
    make_folder(folder.path() / "elsewhere");
    // meanwhile
    std::filesystem::create_directory_symlink(folder.path() / "elsewhere", out / "figures");
    CHECK_THROWS_WITH(set.commit(), Contains("is a link"));
  }
  CHECK(test::file_text(out / "comparison.json") == "older");
}

TEST_CASE("a database path that looks like an SQLite URI is a plain file name", "[study][folders]") {
  Desk desk;
  // As a URI, file:x/sweep.db would be the file x/sweep.db.
  for (const char* name : {"file:x", "x"}) make_folder(desk.folder.path() / name);
  struct Back {
    std::filesystem::path before = std::filesystem::current_path();
    ~Back() { std::filesystem::current_path(before); }
  } back;
  std::filesystem::current_path(desk.folder.path());
  const Results results("file:x/sweep.db", read_study(desk.study));
  CHECK(std::filesystem::exists("file:x/sweep.db"));
  CHECK_FALSE(std::filesystem::exists("x/sweep.db"));
}

TEST_CASE("default result folder of a scene path with .. is named after the resolved folder", "[folders]") {
  CHECK(cli::default_folder("cases/ring/inner/../scene.toml", "") == "out/ring");
  CHECK(cli::default_folder("cases/ring/./scene.toml", "-x") == "out/ring-x");
}

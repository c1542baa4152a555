// freeplay run --resume: a run that is killed or interrupted, any number of times and anywhere,
// finally leaves the files of an undisturbed run, byte for byte. process/crash_recovery kills the program
// itself.
#include <atomic>
#include <thread>

#include "facade/run_folder.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/run_files.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::check_same, test::files_of;
using Path = std::filesystem::path;
using Words = std::vector<std::string>;

namespace {

/// A scene and a formulation. Each run takes about a tenth of a second.
struct Setup {
  Path scene;
  const char* formulation;
  Words set;
  std::vector<const char*> files;
};

const std::vector<Setup>& setups() {
  static const std::vector<Setup> list{
      {test::flores(),
       "penalty",
       {"run.revolutions=0.3", "run.discard=0.05", "run.output_step=2e-5", "run.forces=true"},
       {"trajectory.csv", "events.csv", "signals.csv", "forces.csv"}},
      {test::flores(),
       "nonsmooth",
       {"nonsmooth.scheme=\"event-driven\"", "run.revolutions=1", "run.discard=0.1", "run.output_step=2e-5"},
       {"trajectory.csv", "events.csv", "signals.csv"}},
      {test::flores(),
       "nonsmooth",
       {"nonsmooth.scheme=\"moreau-jean\"", "run.revolutions=0.3", "run.discard=0.05", "run.output_step=2e-5",
        "run.forces=true"},
       {"trajectory.csv", "events.csv", "signals.csv", "forces.csv"}},
      {test::scene_file("four_bar_two"),
       "nonsmooth",
       {"run.duration=0.2", "run.forces=true"},
       {"trajectory.csv", "events.csv", "forces.csv"}}};
  return list;
}

/// Runs a setup, or resumes its run.
Result proceed(const Path& folder, const Setup& setup, const std::function<void(double)>& on_progress = {},
               StopToken stop = {}, double checkpoint = 30) {
  const RunPlan plan{.formulation = setup.formulation,
                     .folder = folder,
                     .on_progress = on_progress,
                     .stop = stop,
                     .checkpoint = checkpoint,
                     .companion = true};  // as the command
  return has_checkpoint(folder) ? resume_run(folder, plan)
                                : run_scene(*open_scene(setup.scene, setup.set), plan);
}

/// Interrupts the run of a setup, or its resumption, at a share of its length.
Result interrupt(const Path& folder, const Setup& setup, double share, double checkpoint = 30) {
  std::atomic<bool> requested{false};
  const auto result = proceed(
      folder, setup, [&](double done) { requested = requested || done > share; }, StopToken(requested),
      checkpoint);
  REQUIRE(result.ending.status == Ending::Status::interrupted);
  return result;
}

/// Kills the run of a setup, or its resumption, at a share of its length: a kill leaves the folder as it is.
void kill(const Path& folder, const Setup& setup, double share) {
  const Path left = folder.string() + "-left";
  const auto copy = [&](double done) {
    if (done > share && !std::filesystem::exists(left)) std::filesystem::copy(folder, left);
  };
  proceed(folder, setup, copy, {}, 0.002);
  std::filesystem::remove_all(folder);
  std::filesystem::rename(left, folder);
  REQUIRE(has_checkpoint(folder));
}

}  // namespace

TEST_CASE("resume: a killed run ends with the same files as an undisturbed one", "[resume]") {
  test::TemporaryFolder place;
  for (const auto& setup : setups())
    // A run that was interrupted before has its files in their places, from where they are moved.
    for (const bool interrupted : {false, true}) {
      CAPTURE(setup.scene, setup.formulation, interrupted);
      const auto whole = place.path() / "whole", folder = place.path() / "killed";
      for (const auto& old : {whole, folder}) std::filesystem::remove_all(old);
      proceed(whole, setup);
      if (interrupted)
        interrupt(folder, setup, 0.2);
      else
        kill(folder, setup, 0.2);
      CHECK(std::filesystem::exists(folder / "run.json") == interrupted);
      for (const double share : {0.5, 0.8}) kill(folder, setup, share);
      proceed(folder, setup);
      check_same(folder, whole);
    }
}

TEST_CASE("resume: an interrupted run leaves complete files and continues", "[resume]") {
  test::TemporaryFolder place;
  for (const auto& setup : setups()) {
    CAPTURE(setup.scene, setup.formulation);
    const auto whole = place.path() / "whole", folder = place.path() / "interrupted";
    for (const auto& old : {whole, folder}) std::filesystem::remove_all(old);
    proceed(whole, setup);
    REQUIRE(files_of(whole).size() == setup.files.size() + 1);
    std::size_t done = 0;
    for (int i = 0; i < 4; ++i) {  // at first, and while it resumes; also without new checkpoints
      interrupt(folder, setup, 0.2 + 0.2 * i, i == 2 ? 0 : 30);
      CHECK(test::read_json(folder / "run.json")["ending"]["status"] == "interrupted");
      const auto files = files_of(folder);
      CHECK(files.size() == setup.files.size() + 2);
      for (const auto* name : setup.files) {
        CAPTURE(name);
        REQUIRE(files.contains(name));
        const auto& here = files.at(name);
        CHECK(std::filesystem::file_size(whole / name) > 1000);
        CHECK(here.ends_with('\n'));
        CHECK(test::file_text(whole / name).starts_with(here));
      }
      CHECK(files.at("trajectory.csv").size() > done);
      done = files.at("trajectory.csv").size();
    }
    const auto o = test::succeeded("run --no-figures --resume " + folder.string());
    CHECK_THAT(o.out, Contains("results in " + folder.string()));
    check_same(folder, whole);
  }
}

TEST_CASE("resume: a stop request during the recording of a step loses no row", "[resume]") {
  // Thousands of rows in each step: most requests fall between them. A step with very many is
  // aborted, and repeated on resumption.
  const Setup kinds[] = {{test::flores(),
                          "penalty",
                          {"run.revolutions=0.05", "run.discard=0", "run.output_step=2e-6", "run.forces=true",
                           "penalty.tolerance=1e-6"},
                          {}},
                         {test::scene_file("bouncing_ball"),
                          "nonsmooth",
                          {"nonsmooth.scheme=\"event-driven\"", "run.duration=0.3", "run.output_step=1e-6"},
                          {}}};
  test::TemporaryFolder place;
  std::mt19937 engine(11);
  for (const auto& [file, formulation, set, files] : kinds) {
    const auto scene = open_scene(file, set);
    const auto whole = place.path() / "whole", folder = place.path() / "stopped";
    const auto start = std::chrono::steady_clock::now();
    run_scene(*scene, {.formulation = formulation, .folder = whole});
    const auto length = std::chrono::steady_clock::now() - start;
    for (int round = 0; round < 4; ++round) {
      std::filesystem::remove_all(folder);
      std::atomic<bool> requested{false};
      std::thread asker([&, wait = length * (engine() % 1000) / 1250] {
        while (!has_checkpoint(folder)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::this_thread::sleep_for(wait);
        requested = true;
      });
      auto result = run_scene(
          *scene,
          {.formulation = formulation, .folder = folder, .stop = StopToken(requested), .checkpoint = 30});
      asker.join();
      if (result.ending.status == Ending::Status::interrupted) {
        REQUIRE(has_checkpoint(folder));
        result = resume_run(folder, {.checkpoint = 30});
      }
      REQUIRE(result.ending.status == Ending::Status::finished);
      check_same(folder, whole);
    }
  }
}

TEST_CASE("resume: a folder that cannot be resumed is refused and stays unchanged", "[resume]") {
  test::TemporaryFolder place;
  const auto setup = setups().front();
  const auto refused = [&](const Path& folder, int status, const std::string& why) {
    const auto before =
        std::filesystem::exists(folder) ? files_of(folder) : std::map<std::string, std::string>();
    const auto o = test::freeplay("run --resume " + folder.string());
    CAPTURE(o.out, o.err, why);
    CHECK(o.status == status);
    CHECK_THAT(o.err, Contains(why));
    CHECK_THAT(o.err, Contains(folder.string()));
    CHECK(std::ranges::count(o.err, '\n') == 1);
    CHECK(o.out.empty());
    if (std::filesystem::exists(folder)) CHECK((files_of(folder) == before));
  };
  const auto empty = place.path() / "empty", done = place.path() / "done", cut = place.path() / "cut",
             interrupted = place.path() / "interrupted";
  std::filesystem::create_directory(empty);
  refused(empty, 2, "has no run.checkpoint to continue from; give the folder of an interrupted run");
  refused(place.path() / "none", 2, "has no run.checkpoint");
  proceed(done, setup);
  refused(done, 2, "its run has ended");

  kill(cut, setup, 0.5);
  interrupt(interrupted, setup, 0.3);
  const auto spoil = [&](const Path& source, const std::string& name, const auto& how) {
    const auto folder = place.path() / "spoilt";
    std::filesystem::remove_all(folder);
    std::filesystem::copy(source, folder);
    how(folder / name);
    return folder;
  };
  for (const std::string name : {"trajectory.csv", "events.csv", "signals.csv", "forces.csv"})
    for (const auto& [source, suffix] : {std::pair(cut, ".partial"), std::pair(interrupted, "")}) {
      INFO(name << " of " << source);
      refused(spoil(source, name + suffix, [](const Path& file) { REQUIRE(std::filesystem::remove(file)); }),
              1, name + ": cannot be continued: it has 0 of its first ");
      refused(spoil(source, name + suffix, [](const Path& file) { std::filesystem::resize_file(file, 5); }),
              1, name + ": cannot be continued: it has 5 of its first ");
    }

  // The checkpoint.
  const std::string checkpoint = "run.checkpoint", head = "freeplay checkpoint 5 ";
  const auto whole = test::file_text(cut / checkpoint);
  REQUIRE(whole.starts_with(head));
  const auto rewritten = [&](const std::string& bytes) {
    return spoil(cut, checkpoint, [&](const Path& file) { write_file(file, bytes); });
  };
  refused(rewritten("freeplay checkpoint 1 " + whole.substr(head.size())), 2, "is a checkpoint of version 1");
  refused(rewritten(whole.substr(0, whole.size() / 2)), 2, "is damaged");
  refused(rewritten(""), 2, "is not a checkpoint of freeplay");
  auto flipped = whole;
  flipped[whole.size() / 2] ^= 4;
  refused(rewritten(flipped), 2, "is damaged");
  // Of another program, with a new seal: its length and FNV-1a are in the first line.
  const auto sealed = [](const std::string& body) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const unsigned char c : body) hash = (hash ^ c) * 0x100000001b3u;
    return fmt::format("freeplay checkpoint 5 {} {:016x}\n", body.size(), hash) + body;
  };
  auto body = whole.substr(whole.find('\n') + 1);
  REQUIRE(sealed(body) == whole);
  const std::string sources = "\nsources = \"";
  const auto at = body.rfind(sources);
  REQUIRE(at != body.npos);
  auto& digit = body[at + sources.size()];
  digit = digit == '9' ? '8' : '9';
  refused(rewritten(sealed(body)), 2, "was taken by freeplay");

  // An undamaged run is resumed.
  for (const auto& folder : {cut, interrupted}) {
    proceed(folder, setup);
    check_same(folder, done);
  }
}

TEST_CASE("resume: a run that cannot be moved to its place is not lost", "[resume]") {
  test::TemporaryFolder place;
  const Setup setup{
      test::flores(), "penalty", {"run.revolutions=0.1", "run.discard=0", "penalty.tolerance=1e-6"}, {}};
  const auto whole = place.path() / "whole", folder = place.path() / "full";
  proceed(whole, setup);
  interrupt(folder, setup, 0.3);
  // run.json cannot be put in its place, which a folder occupies.
  std::filesystem::remove(folder / "run.json");
  std::filesystem::create_directories(folder / "run.json" / "x");
  CHECK_THROWS_AS(proceed(folder, setup), OutputError);
  REQUIRE(has_checkpoint(folder));
  std::filesystem::remove_all(folder / "run.json");
  // The run had ended: its files are put in their places, and nothing remains to resume.
  CHECK_THROWS_WITH(proceed(folder, setup), Contains("its run has ended"));
  check_same(folder, whole);
}

TEST_CASE("resume: a new run in a folder removes leftovers of an old one", "[resume]") {
  test::TemporaryFolder place;
  const auto folder = place.path() / "run", whole = place.path() / "whole";
  const auto &forces = setups()[0], &none = setups()[1];
  kill(folder, forces, 0.5);
  REQUIRE(std::filesystem::exists(folder / "forces.csv.partial"));
  write_file(folder / "run.checkpoint.partial", "half");
  const auto scene = open_scene(none.scene, none.set);
  for (const auto& one : {folder, whole}) run_scene(*scene, {.formulation = none.formulation, .folder = one});
  check_same(folder, whole);
}

TEST_CASE("resume: only its own options are accepted", "[resume]") {
  test::TemporaryFolder place;
  const std::string resume = "run --resume " + place.path().string();
  for (const char* option :
       {" --formulation penalty", " --set run.duration=1", " --accuracy fast", " -o x"}) {
    test::refused(resume + option, Contains("the only other option is --checkpoint"));
  }
  CHECK(test::freeplay(resume + " " + test::flores().string()).status == 2);
  CHECK(test::freeplay("run").status == 2);
  CHECK(test::freeplay(resume + " --checkpoint -1").status == 2);
}

TEST_CASE("an interruption is reported in the same words by every command", "[resume]") {
  test::TemporaryFolder place;
  const auto cases = (test::source_folder() / "cases").string(), flores = test::flores().string();
  const std::string anew = "interrupted; the same command starts again, nothing was written";
  for (const auto& [line, words] : {std::pair("poincare " + flores + " --periods 5000 --discard 10", anew),
                                    {"drift " + flores + " --set run.revolutions=5000", anew},
                                    {"bifurcation " + cases + "/flores2011-attractors/friction.toml",
                                     "interrupted; the same command continues"},
                                    // It may still be reading its scenes, and then has nothing to resume.
                                    {"sweep " + cases + "/flores2011-experiment/study.toml", "interrupted"},
                                    {"run " + flores + " --formulation penalty --set run.revolutions=5000",
                                     "interrupted: penalty at t = "}}) {
    CAPTURE(line);
    const auto err = place.path() / "err";
    const int status =
        std::system(fmt::format("timeout --foreground -s INT 0.7 {}/freeplay {} -o {}/out >/dev/null 2>{}",
                                FREEPLAY_BINARY_DIR, line, place.path().string(), err.string())
                        .c_str());
    CHECK(WEXITSTATUS(status) == 124);  // it was still running
    CHECK_THAT(test::file_text(err), Catch::StartsWith(words));
  }
}

// freeplay run --resume: a run that is killed or interrupted, any number of times and anywhere,
// finally leaves the files of an undisturbed run, byte for byte.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <atomic>
#include <chrono>
#include <thread>

#include "facade/run_folder.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/run_files.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::check_same, test::files_of;
using Path = std::filesystem::path;

namespace {

using Words = std::vector<std::string>;
using Clock = std::chrono::steady_clock;

/// The program, started as a separate process.
class Process {
 public:
  explicit Process(const Words& words) : id_(test::start_freeplay(words)) {}
  ~Process() {
    if (id_ > 0) end(SIGKILL);
  }
  /// Sends the signal and waits; returns whether the process was still running.
  bool end(int signal) {
    ::kill(id_, signal);
    return wait() == signal;
  }
  /// The signal that ended it, or 0; see status().
  int wait() {
    int status = 0;
    REQUIRE(waitpid(id_, &status, 0) == id_);
    id_ = 0;
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }
  int status() const { return status_; }  ///< −1: ended by a signal
  void signal(int which) const { ::kill(id_, which); }

 private:
  pid_t id_;
  int status_ = -1;
};

void sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }
/// Waits until the folder contains a checkpoint; false: not within ten seconds.
bool wait_for_checkpoint(const Path& folder) {
  const auto start = Clock::now();
  while (!has_checkpoint(folder)) {
    if (Clock::now() - start > std::chrono::seconds(10)) return false;
    sleep(0.001);
  }
  return true;
}

/// A scene and a method to run it, with about half a second of stepping, and without figures, which
/// take longer.
struct Setup {
  const char* what;
  Words words;  // of `run`, without the folder
  std::vector<const char*> files;
};

std::vector<Setup> setups() {
  return {
      {"penalty, one kind of everything",
       {test::flores().string(), "--formulation", "penalty", "--forces", "--set", "run.revolutions=1.5",
        "--set", "run.discard=0.05", "--set", "run.output_step=2e-5"},
       {"trajectory.csv", "events.csv", "signals.csv", "forces.csv"}},
      {"Moreau-Jean",
       {test::flores().string(), "--formulation", "nonsmooth", "--forces", "--set", "run.revolutions=5",
        "--set", "run.discard=0.1", "--set", "run.output_step=5e-5"},
       {"trajectory.csv", "events.csv", "signals.csv", "forces.csv"}},
      {"event-driven",
       {test::flores().string(), "--formulation", "nonsmooth", "--set", "nonsmooth.scheme=\"event-driven\"",
        "--set", "run.revolutions=5", "--set", "run.discard=0.1", "--set", "run.output_step=2e-5"},
       {"trajectory.csv", "events.csv", "signals.csv"}},
      {"two contacts, no instrument",
       {test::scene_file("four_bar_two").string(), "--formulation", "nonsmooth", "--forces", "--set",
        "run.duration=0.6"},
       {"trajectory.csv", "events.csv", "forces.csv"}},
      {"point bodies",
       {test::scene_file("point_on_loose_pin").string(), "--formulation", "penalty", "--forces", "--set",
        "run.revolutions=1", "--set", "run.output_step=2e-5"},
       {"trajectory.csv", "events.csv", "signals.csv", "forces.csv"}}};
}

Words run_in(const Path& folder, const Setup& setup, const char* checkpoint = "0.002") {
  Words words{"run"};
  words.insert(words.end(), setup.words.begin(), setup.words.end());
  for (const std::string& word : {std::string("-o"), folder.string(), std::string("--checkpoint"),
                                  std::string(checkpoint), std::string("--no-figures")})
    words.push_back(word);
  return words;
}
Words resume_in(const Path& folder, const char* checkpoint = "0.002") {
  return {"run", "--resume", folder.string(), "--checkpoint", checkpoint};
}

/// Runs to the end; returns how long it took (s).
double run_whole(const Words& words) {
  const auto start = Clock::now();
  Process process(words);
  REQUIRE(process.wait() == 0);
  REQUIRE(process.status() == 0);
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Starts the run of a setup in a folder and ends it at some time with a signal, repeated until the
/// signal was in time.
void begin(const Path& folder, const Setup& setup, double after, int signal,
           const char* checkpoint = "0.002") {
  for (int i = 0; i < 10; ++i, after *= 0.7) {
    std::filesystem::remove_all(folder);  // a completed run would have left files
    Process process(run_in(folder, setup, checkpoint));
    REQUIRE(wait_for_checkpoint(folder));
    sleep(after);
    process.signal(signal);
    process.wait();
    if (has_checkpoint(folder)) return;
  }
  FAIL("the run is over before it can be ended");
}

}  // namespace

TEST_CASE("resume: a killed run ends with the same files as an undisturbed one", "[resume]") {
  test::TemporaryFolder place;
  std::mt19937 engine(3);
  const auto share = [&] { return static_cast<double>(engine() % 1000) / 1000; };
  for (const auto& setup : setups()) {
    INFO(setup.what);
    const auto whole = place.path() / "whole", folder = place.path() / "killed";
    for (const auto& old : {whole, folder}) std::filesystem::remove_all(old);
    const double length = run_whole(run_in(whole, setup, "0"));
    for (const auto* name : setup.files) {
      INFO(name);
      REQUIRE(std::filesystem::exists(whole / name));
      CHECK(std::filesystem::file_size(whole / name) > 1000);
    }
    REQUIRE(files_of(whole).size() == setup.files.size() + 1);

    begin(folder, setup, share() * 0.5 * length, SIGKILL);
    CHECK_FALSE(std::filesystem::exists(folder / "run.json"));
    int kills = 0;
    for (int i = 0; i < 6; ++i) {
      Process process(resume_in(folder));
      sleep(share() * 0.3 * length);
      kills += process.end(SIGKILL);
      if (!has_checkpoint(folder)) break;
    }
    CHECK(kills >= 1);
    if (has_checkpoint(folder)) {
      run_whole(resume_in(folder));
    } else if (!std::filesystem::exists(folder / "run.json")) {
      // Killed after the removal of the checkpoint and before run.json exists: the next call puts
      // run.json in its place.
      Process(resume_in(folder)).wait();
    }
    check_same(folder, whole);
  }
}

TEST_CASE("resume: an interrupted run leaves complete files and continues", "[resume]") {
  test::TemporaryFolder place;
  std::mt19937 engine(5);
  for (const auto& setup : setups()) {
    INFO(setup.what);
    const auto whole = place.path() / "whole", folder = place.path() / "interrupted";
    for (const auto& old : {whole, folder}) std::filesystem::remove_all(old);
    const double length = run_whole(run_in(whole, setup, "30"));
    const auto share = [&] { return (0.05 + 0.3 * static_cast<double>(engine() % 1000) / 1000) * length; };
    begin(folder, setup, share(), engine() % 2 ? SIGINT : SIGTERM, "30");
    const auto check_interrupted = [&] {
      const auto document = nlohmann::json::parse(test::file_text(folder / "run.json"));
      CHECK(document["ending"]["status"] == "interrupted");
      const auto files = files_of(folder);
      CHECK(files.size() == setup.files.size() + 2);
      for (const auto* name : setup.files) {
        INFO(name);
        REQUIRE(files.contains(name));
        const auto& here = files.at(name);
        CHECK(here.ends_with('\n'));
        CHECK(test::file_text(whole / name).starts_with(here));
      }
    };
    check_interrupted();
    for (int i = 0; i < 3; ++i) {  // again, while it resumes; also without new checkpoints
      const auto done = test::file_text(folder / "trajectory.csv").size();
      Process process(resume_in(folder, i == 1 ? "0" : "30"));
      sleep(share());
      process.signal(SIGINT);
      process.wait();
      if (!has_checkpoint(folder)) break;
      check_interrupted();
      CHECK(test::file_text(folder / "trajectory.csv").size() >= done);
    }
    {  // killed while it resumes an interrupted run: its files are in their places, and are moved
      Process process(resume_in(folder));
      sleep(0.1 * share());
      process.end(SIGKILL);
    }
    if (has_checkpoint(folder)) {
      const auto o = test::succeeded("run --resume " + folder.string());
      CHECK_THAT(o.out, Contains("results in " + folder.string()));
    }
    check_same(folder, whole);
  }
}

TEST_CASE("resume: a stop request during the recording of a step loses no row", "[resume]") {
  // Thousands of rows in each step: most requests fall between them. A step with very many is
  // aborted, and repeated on resumption.
  struct Kind {
    std::shared_ptr<const Scene> scene;
    const char* formulation;
    int rounds;
  };
  const Kind kinds[] = {
      {open_scene(test::flores(), {"run.revolutions=0.05", "run.discard=0", "run.output_step=2e-6",
                                   "run.forces=true", "penalty.tolerance=1e-6"}),
       "penalty", 8},
      {open_scene(test::scene_file("bouncing_ball"),
                  {"nonsmooth.scheme=\"event-driven\"", "run.duration=0.3", "run.output_step=1e-6"}),
       "nonsmooth", 4}};
  test::TemporaryFolder place;
  std::mt19937 engine(11);
  for (const auto& [scene, formulation, rounds] : kinds) {
    const auto whole = place.path() / "whole", folder = place.path() / "stopped";
    const auto start = Clock::now();
    run_scene(*scene, {.formulation = formulation, .folder = whole});
    const double length = std::chrono::duration<double>(Clock::now() - start).count();
    for (int round = 0; round < rounds; ++round) {
      std::filesystem::remove_all(folder);
      std::atomic<bool> requested{false};
      std::thread asker([&, wait = static_cast<double>(engine() % 1000) * 0.8e-3 * length] {
        wait_for_checkpoint(folder);
        sleep(wait);
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
  const double length = run_whole(run_in(done, setup));
  refused(done, 2, "its run has ended");

  begin(cut, setup, 0.4 * length, SIGKILL);
  begin(interrupted, setup, 0.3 * length, SIGINT);
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
  run_whole(resume_in(cut));
  run_whole(resume_in(interrupted));
  check_same(cut, done);
  check_same(interrupted, done);
}

TEST_CASE("resume: a run that cannot be moved to its place is not lost", "[resume]") {
  test::TemporaryFolder place;
  const auto scene =
      open_scene(test::flores(), {"run.revolutions=0.1", "run.discard=0", "penalty.tolerance=1e-6"});
  const auto whole = place.path() / "whole", folder = place.path() / "full";
  run_scene(*scene, {.formulation = "penalty", .folder = whole});
  std::atomic<bool> requested{false};
  auto result = run_scene(*scene, {.formulation = "penalty",
                                   .folder = folder,
                                   .on_progress = [&](double done) { requested = done > 0.3; },
                                   .stop = StopToken(requested),
                                   .checkpoint = 30});
  REQUIRE(result.ending.status == Ending::Status::interrupted);
  // run.json cannot be put in its place, which a folder occupies.
  std::filesystem::remove(folder / "run.json");
  std::filesystem::create_directories(folder / "run.json" / "x");
  CHECK_THROWS_AS(resume_run(folder, {.checkpoint = 30}), OutputError);
  REQUIRE(has_checkpoint(folder));
  std::filesystem::remove_all(folder / "run.json");
  // The run had ended: its files are put in their places, and nothing remains to resume.
  CHECK_THROWS_WITH(resume_run(folder, {.checkpoint = 30}), Contains("its run has ended"));
  check_same(folder, whole);
}

TEST_CASE("resume: a new run in a folder removes leftovers of an old one", "[resume]") {
  test::TemporaryFolder place;
  const auto folder = place.path() / "run", whole = place.path() / "whole";
  const auto list = setups();
  begin(folder, list[0], 0.05, SIGKILL);
  write_file(folder / "run.checkpoint.partial", "half");
  REQUIRE(std::filesystem::exists(folder / "forces.csv.partial"));
  run_whole(run_in(folder, list[2]));  // which has no forces
  run_whole(run_in(whole, list[2]));
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
  const auto source = test::source_folder() / "cases", flores = test::flores();
  const auto said = [&](const std::string& line) {
    const auto err = place.path() / "err";
    const int status =
        std::system(fmt::format("timeout --foreground -s INT 0.7 {}/freeplay {} -o {}/out >/dev/null 2>{}",
                                FREEPLAY_BINARY_DIR, line, place.path().string(), err.string())
                        .c_str());
    CHECK(WEXITSTATUS(status) == 124);  // it was still running
    return test::file_text(err);
  };
  const auto anew = Catch::Contains("interrupted; the same command starts again, nothing was written"),
             on = Catch::Contains("interrupted; the same command continues");
  CHECK_THAT(said("poincare " + flores.string() + " --periods 5000 --discard 10"), anew);
  CHECK_THAT(said("drift " + flores.string() + " --set run.revolutions=5000"), anew);
  CHECK_THAT(said("bifurcation " + (source / "flores2011-attractors/friction.toml").string()), on);
  // It may still be reading its scenes, and then has nothing to resume.
  CHECK_THAT(said("sweep " + (source / "flores2011-experiment/study.toml").string()),
             Catch::StartsWith("interrupted"));
  CHECK_THAT(said("run " + flores.string() + " --formulation penalty --set run.revolutions=5000"),
             Catch::Contains("interrupted: penalty at t = "));
}

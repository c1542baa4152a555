// Bounds on the cost of a run: bytes before they are written, the time until Ctrl-C takes effect,
// memory, and messages when nothing more can be written.
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <thread>

#include "dynamics/assembly/assembly.hpp"
#include "facade/run_folder.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_estimate.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Result of a shell line in which $F is the program: exit status and standard error.
std::pair<int, std::string> shell(const std::string& line) {
  test::TemporaryFolder folder;
  const auto err = folder.path() / "err";
  const auto whole =
      "F=" FREEPLAY_BINARY_DIR "/freeplay; { " + line + "; } 2>" + err.string() + " </dev/null";
  const int status = std::system(("bash -c '" + whole + "'").c_str());
  return {WEXITSTATUS(status), test::file_text(err)};
}

/// Status of a line that has to end with one line of standard error.
int status_of(const std::string& line, const std::string& why) {
  CAPTURE(line);
  const auto [status, err] = shell(line);
  CAPTURE(err);
  CHECK(std::ranges::count(err, '\n') == 1);
  CHECK_THAT(err, Contains(why));
  return status;
}

}  // namespace

TEST_CASE("the size of the output of a run is estimated before it starts", "[bounded][files]") {
  // Ten mechanisms, each in its typical formulation. An error beyond 20 % would make the estimate
  // useless for planning.
  struct Row {
    const char* scene;
    Family family;
    std::vector<std::string> set;
  };
  const Row rows[] = {
      {"gudgeon", Family::nonsmooth, {"run.forces=true"}},
      {"gudgeon_mu03", Family::penalty, {}},
      {"big_end", Family::nonsmooth, {}},
      {"four_bar", Family::nonsmooth, {"run.forces=true"}},
      {"four_bar_two", Family::nonsmooth, {}},
      {"four_bar_row", Family::penalty, {"run.forces=true"}},
      {"seven_body", Family::nonsmooth, {"run.forces=true"}},
      {"double_pendulum", Family::penalty, {"run.forces=true"}},
      {"long_chain", Family::nonsmooth, {}},
      {"gudgeon_1mm_250rpm", Family::nonsmooth, {}},
  };
  for (const auto& row : rows) {
    CAPTURE(row.scene);
    auto scene = read_scene(test::scene_file(row.scene), row.set);
    scene.run.duration = std::min(scene.run.duration, 0.2);
    scene.run.discard = 0;
    scene.run.output_step = scene.run.duration / 2000;
    const auto estimate = estimate_output(scene, assemble(scene.mechanism, scene.run.start));
    test::TemporaryFolder folder;
    run_scene(scene, {.formulation = name_of(row.family), .folder = folder.path()});
    double written = 0, estimated = 0;
    for (const auto& file : estimate.files) {
      if (file.name.find(".csv") == file.name.npos) continue;  // the other files are small here
      written += static_cast<double>(std::filesystem::file_size(folder.path() / file.name));
      estimated += file.bytes;
    }
    CHECK(estimated / written == Approx(1).margin(0.2));
  }
}

TEST_CASE("the output of forces of discs with changing contacts is estimated as an upper bound",
          "[bounded][files][groups]") {
  // The contacts of a group are one family without an individual gap: its columns are assumed to be
  // full, so the bound is one-sided.
  auto scene = read_scene(test::source_folder() / "cases/discs-in-a-box/scene.toml", {"run.forces=true"});
  scene.run.duration = 0.05;
  const auto estimate = estimate_output(scene, assemble(scene.mechanism, scene.run.start));
  const auto estimated = std::ranges::find(estimate.files, "forces.csv", &OutputEstimate::File::name);
  REQUIRE(estimated != estimate.files.end());
  test::TemporaryFolder folder;
  run_scene(scene, {.formulation = "nonsmooth", .folder = folder.path()});
  const auto written = static_cast<double>(std::filesystem::file_size(folder.path() / "forces.csv"));
  CHECK(estimated->bytes > 0.8 * written);
  CHECK(estimated->bytes < 3 * written);  // before the first contacts most discs are apart
}

TEST_CASE("a run whose estimated output is too large does not start", "[bounded][files]") {
  test::TemporaryFolder folder;
  const auto out = (folder.path() / "out").string();
  const auto run = "run " + test::flores().string() + " --formulation nonsmooth -o " + out;
  auto o = test::refused(run + " --set instruments.accelerometer.sampling=2.5e8",
                         Contains("would write about") && Contains("signals.csv") &&
                             Contains("10 GB is allowed") && Contains("--limit-output"));
  CHECK(std::ranges::count(o.err, '\n') == 1);
  test::refused(run + " --limit-output 0.001", Contains("1 MB is allowed"));
  test::refused("compare " + test::flores().string() + " --limit-output 0.001 -o " + out,
                Contains("3 times"));
  CHECK_FALSE(std::filesystem::exists(out));
  o = test::freeplay("check " + test::flores().string());
  CHECK(o.status == 0);
  CHECK_THAT(o.out, Contains("estimated output") && Contains("trajectory.csv"));
  const auto scene = read_scene(test::flores());
  CHECK_THROWS_WITH(require_room(scene, {{{"a", 1e24}}}, 1, folder.path() / "none/yet", 1e30),
                    Contains("is free there"));
  CHECK_THROWS_AS(require_room(scene, {{{"a", 1e24}}}, 1, folder.path(), 1e30), OutputError);
  CHECK_NOTHROW(require_room(scene, {{{"a", 1e3}}}, 1, folder.path() / "none/yet", 1e9));
}

TEST_CASE("output that cannot be printed or written ends the program with status 1 and one line",
          "[bounded]") {
  test::TemporaryFolder folder;
  const auto at = folder.path().string(), scene = test::flores().string();
  const auto refused = [](const std::string& line, const char* why) { CHECK(status_of(line, why) == 1); };
  const std::string quick = " --set run.revolutions=0.02 --set run.discard=0 --set nonsmooth.step=1e-4";
  const auto run = "$F run " + scene + " --formulation nonsmooth" + quick;
  REQUIRE(shell("$F laws " + scene + " -o " + at + "/laws >" + at + "/said").first == 0);
  for (const auto& verb :
       {std::string("--help"), std::string("--version"), std::string("check --keys"), std::string("laws"),
        "check " + scene, "verify closed-forms -o " + at + "/verify", "figures " + at + "/laws"})
    refused("$F " + verb + " >/dev/full", "standard output: cannot be written: No space left on device");
  refused(run + " -o " + at + "/full >/dev/full", "No space left on device");
  CHECK(std::filesystem::exists(at + "/full/run.json"));  // its files are complete nevertheless
  refused(run + " -o " + at + "/pipe | true; (exit ${PIPESTATUS[0]})", "Broken pipe");
  refused(run + " -o " + at + "/closed >&-", "standard output");
  refused(run + " -o /proc/none", "/proc/none: cannot make this folder");
  refused("ulimit -f 8; " + run + " -o " + at + "/large", "File too large");
  for (const auto* name : {"run.json", "trajectory.csv"})
    CHECK_FALSE(std::filesystem::exists(at + "/large/" + name));
}

TEST_CASE("paths and folders that cannot serve are named in one line before any work", "[bounded]") {
  test::TemporaryFolder place;
  const auto& folder = place.path();
  const auto refused = [](const std::string& line, const char* why) { CHECK(status_of(line, why) != 0); };
  const auto odd = folder / "\xff",
             deep = folder / std::string(200, 'd') / std::string(200, 'd') / std::string(200, 'd');
  for (const auto& one : {odd, deep}) {
    std::filesystem::create_directories(one);
    test::put_ball_study(one, "values = [0.1, 0.2]");
  }
  refused("cd " + odd.string() + "; $F sweep study.toml --plan 2 -o " + odd.string() + "/out",
          "is not UTF-8");
  CHECK_FALSE(std::filesystem::exists(odd / "out" / "shards"));
  CHECK(shell("cd " + odd.string() + "; $F sweep study.toml -o out >/dev/null").first == 0);
  refused("cd " + deep.string() + "; $F sweep study.toml -o out >/dev/null", "more than 503 bytes");
  // More threads than cores are used without a word of oneTBB.
  const auto [status, err] = shell("cd " + deep.string() + "; $F sweep study.toml --threads 64 -o " +
                                   folder.string() + "/out >/dev/null");
  CHECK(status == 0);
  CHECK(err.empty());
}

TEST_CASE("a report of a folder that cannot be written is written elsewhere", "[bounded]") {
  test::TemporaryFolder place;
  const auto results = place.path() / "results";
  test::succeeded("run " + (test::source_folder() / "cases/bouncing-ball/scene.toml").string() +
                  " --formulation nonsmooth --no-figures -o " + results.string());
  std::filesystem::permissions(results, std::filesystem::perms(0555));
  if (access(results.c_str(), W_OK) == 0) return;  // root writes everywhere
  test::succeeded("report " + results.string() + " -o " + (place.path() / "report.html").string());
  CHECK(std::filesystem::exists(place.path() / "report.html"));
  CHECK(test::freeplay("report " + results.string()).status == 1);
  std::filesystem::permissions(results, std::filesystem::perms(0755));
}

TEST_CASE("a command whose folder another one uses ends before its work", "[bounded]") {
  test::TemporaryFolder folder;
  const auto ball = (test::source_folder() / "cases/ball-on-table/scene.toml").string();
  const FolderLock lock(folder.path(), "test");
  for (const auto& [verb, options] :
       {std::pair{"lyapunov", ""}, {"orbit", ""}, {"sensitivity", " --of event.1.t --to gravity[1]"}}) {
    CAPTURE(verb);
    // The run would last for years.
    const auto o = test::freeplay(verb + (" " + ball) + options + " --set run.duration=1e9 -o " +
                                  folder.path().string());
    CHECK(o.status == 1);
    CHECK_THAT(o.err, Contains("another freeplay process writes to this folder"));
  }
}

TEST_CASE("Ctrl-C is obeyed in every phase, and complete files stay complete", "[bounded]") {
  test::TemporaryFolder folder;
  const auto out = (folder.path() / "out").string();
  const std::string scene = test::flores().string();
  const std::vector<std::vector<std::string>> verbs{
      {"run", scene, "--formulation", "penalty", "--set", "run.revolutions=2000", "-o", out + "/run"},
      {"run", scene, "--formulation", "nonsmooth", "--set", "run.revolutions=2000", "-o", out + "/run"},
      {"compare", scene, "--set", "run.revolutions=2000", "-o", out + "/compare"},
      {"verify", "-o", out + "/verify"},
      {"advise", scene},
  };
  double worst = 0;
  for (const auto& verb : verbs)
    for (const auto& [signal, wait] : {std::pair{SIGINT, 10}, {SIGTERM, 300}}) {
      CAPTURE(verb, wait);
      const pid_t id = test::start_freeplay(verb);
      std::this_thread::sleep_for(std::chrono::milliseconds(wait));
      const auto requested = Clock::now();
      kill(id, signal);
      int status = 0;
      REQUIRE(waitpid(id, &status, 0) == id);
      worst = std::max(worst, since(requested));
      // A signal before the program handles signals ends it with the default action.
      CHECK((WIFSIGNALED(status) ? WTERMSIG(status) == signal : WEXITSTATUS(status) == 1));
    }
  CHECK(worst <
        // 0.75 s are the permitted reaction time (cli/ending.hpp); the rest is for the machine
        2);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out))
    if (entry.path().filename() == "run.json") {
      std::ifstream in(entry.path());
      CHECK_FALSE(nlohmann::json::parse(in, nullptr, false).is_discarded());
    }
}

TEST_CASE("an assembly obeys a request to stop", "[bounded]") {
  const std::atomic<bool> requested{true};
  std::atomic<bool> heard{false};
  const auto scene = read_scene(test::scene_file("four_bar"));
  CHECK_THROWS_AS(
      assemble(scene.mechanism, RunOptions::Start::assembled, nullptr, StopToken(requested, heard)),
      Interrupted);
  CHECK(heard);
  CHECK_THROWS_AS(Simulation(scene, "nonsmooth", {.stop = StopToken(requested)}), Interrupted);
}

TEST_CASE("the memory of a run does not grow with its length", "[bounded]") {
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    long kib[2] = {0, 0};
    for (const int i : {0, 1}) {
      test::TemporaryFolder folder;
      test::succeeded(
          fmt::format("run {} --formulation {} -o {} --set run.revolutions={} --set run.discard=0 --set "
                      "run.output_step=1e-4 --set nonsmooth.step=5e-5 --set penalty.tolerance=1e-6",
                      test::flores().string(), formulation, folder.path().string(), i == 0 ? 0.5 : 10.0));
      kib[i] = test::read_json(folder.path() / "run.json").at("cost").at("peak_memory_KiB").get<long>();
    }
    CAPTURE(formulation, kib[0], kib[1]);
    CHECK(kib[1] < kib[0] + 2048);  // its longer files alone have 25 MB
  }
}

TEST_CASE("the program starts in little memory", "[bounded]") {
  // A BLAS that makes threads when it is loaded would loop here.
  CHECK(shell("ulimit -v 150000; timeout -k 1 20 $F --version >/dev/null").first == 0);
}

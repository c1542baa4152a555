// Child processes: their time limits, requests to stop, and the compilation that a stop or a kill
// ends.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <thread>

#include "compile/compiled_object.hpp"
#include "io/files/child.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Whether a process runs; a zombie does not.
bool runs(pid_t id) {
  std::ifstream in(fmt::format("/proc/{}/stat", id));
  const std::string facts{std::istreambuf_iterator<char>(in), {}};
  const auto end = facts.rfind(')');
  return end != facts.npos && facts.size() > end + 2 && facts[end + 2] != 'Z';
}

/// Waits until a condition holds, 20 s at most.
bool comes_true(const auto& condition) {
  for (const auto begun = Clock::now(); since(begun) < 20;
       std::this_thread::sleep_for(std::chrono::milliseconds(10)))
    if (condition()) return true;
  return false;
}

/// This test program with default signals, which executes one test in a process of its own; the program
/// `cc` and the cache are in the folder.
pid_t start_test(const std::string& name, const std::filesystem::path& folder) {
  const auto self = std::filesystem::read_symlink("/proc/self/exe").string();
  const auto path = folder.string() + ":" + std::getenv("PATH"), output = (folder / "output").string();
  const pid_t id = fork();
  if (id == 0) {
    for (const int signal : {SIGPIPE, SIGINT, SIGTERM, SIGCHLD}) std::signal(signal, SIG_DFL);
    setenv("PATH", path.c_str(), 1);
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);
    const int to = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(to, 1);
    dup2(to, 2);
    execl(self.c_str(), self.c_str(), name.c_str(), nullptr);
    _exit(127);
  }
  return id;
}

/// A compiler that closes its input unread and leaves the work to another process, as gcc does. The
/// number of that process is in the file `worker`, and its temporary file in the folder for these.
constexpr const char* slow_compiler = R"(#!/bin/sh
if [ "$1" = -v ]; then echo slow compiler >&2; exit 0; fi
exec 0<&-
sh -c 'echo $$ >"$0/started"; mv "$0/started" "$0/worker"; >$TMPDIR/temporary.s; exec sleep 300' "${0%/*}" &
wait
)";

/// Results of a compilation by the slow compiler that ended in one way.
struct StoppedCompilation {
  int status = 0;         ///< of its process
  bool worked = false;    ///< whether the compiler's process ran
  bool works = false;     ///< whether it still does
  std::size_t files = 0;  ///< number of files that it left in the cache
  std::string output;
};
StoppedCompilation stopped_compilation(bool killed) {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  std::ofstream(place / "cc") << slow_compiler;
  std::filesystem::permissions(place / "cc", std::filesystem::perms::owner_all);
  StoppedCompilation found;
  const pid_t id = start_test("the compilation that is stopped", place);
  found.worked = comes_true([&] { return std::filesystem::exists(place / "worker"); });
  pid_t worker = 0;
  std::ifstream(place / "worker") >> worker;
  if (killed)
    kill(id, SIGKILL);
  else
    std::ofstream(place / "stop") << "now";
  waitpid(id, &found.status, 0);
  const auto files = [&] {
    namespace fs = std::filesystem;
    std::error_code gone;  // files vanish meanwhile
    std::size_t count = 0;
    for (fs::recursive_directory_iterator one(place / "freeplay", gone), end; !gone && one != end;
         one.increment(gone))
      ++count;
    return count;
  };
  comes_true([&] { return !runs(worker) && files() == 0; });
  found.works = runs(worker);
  found.files = files();
  found.output = test::file_text(place / "output");
  return found;
}

}  // namespace

TEST_CASE("a child process ends within its time limit", "[bounded]") {
  const auto quiet = run_child({.command = {"cat"}, .input = std::string(1 << 20, 'x')});
  CHECK(quiet.status == 0);
  CHECK_FALSE(quiet.late);
  const auto said = run_child({.command = {"sh"}, .folder = "/", .input = "pwd >&2; exit 3"});
  CHECK(said.status == 3);
  CHECK(said.errors == "/\n");
  CHECK(run_child({.command = {"a-program-that-is-not-there"}}).status == 127);

  auto begun = Clock::now();
  const auto late =
      run_child({.command = {"sh", "-c", "trap '' TERM INT; while :; do sleep 100; done"}, .seconds = 0.2});
  CHECK(late.late);
  CHECK(late.status == 128 + SIGKILL);
  CHECK(since(begun) < 5);

  std::atomic<bool> requested{false};
  std::thread impatient([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    requested = true;
  });
  begun = Clock::now();
  CHECK_THROWS_AS(run_child({.command = {"sleep", "100"}, .stop = StopToken(requested)}), Interrupted);
  CHECK(since(begun) < 5);
  impatient.join();
  // A stop at the instant of the start: signal handlers of this process must not run in the new one.
  for (int i = 0; i < 50; ++i)
    CHECK_THROWS_AS(run_child({.command = {"sleep", "100"}, .stop = StopToken(requested)}), Interrupted);
  CHECK(since(begun) < 30);
}

TEST_CASE("the compilation that is stopped", "[.][bounded][compiled]") {
  const std::filesystem::path folder = std::getenv("XDG_CACHE_HOME");
  std::atomic<bool> requested{false};
  std::thread impatient(
      [&] { requested = comes_true([&] { return std::filesystem::exists(folder / "stop"); }); });
  CHECK_THROWS_AS(compiled_object(std::string(1 << 20, ' '), 1, StopToken(requested)), Interrupted);
  impatient.join();
}

TEST_CASE("a stop during a compilation ends the compiler and its processes", "[bounded][compiled]") {
  // Signals have their default actions: a write to the closed pipe must not end the process.
  const auto stopped = stopped_compilation(false);
  INFO(stopped.output);
  REQUIRE(stopped.worked);
  CHECK(WIFEXITED(stopped.status));
  CHECK(WEXITSTATUS(stopped.status) == 0);
  CHECK_FALSE(stopped.works);
  CHECK(stopped.files == 0);
}

TEST_CASE("the compiler and its files vanish when the process is killed", "[bounded][compiled]") {
  const auto killed = stopped_compilation(true);
  INFO(killed.output);
  REQUIRE(killed.worked);
  CHECK(WIFSIGNALED(killed.status));
  CHECK_FALSE(killed.works);
  CHECK(killed.files == 0);
}

TEST_CASE("a child's process group ends with it and at its time limit", "[bounded]") {
  test::TemporaryFolder folder;
  const auto leave = [&](const char* then, double seconds) {
    const auto file = folder.path() / "left";
    std::filesystem::remove(file);
    const auto end = run_child({.command = {"sh", "-c", std::string("sleep 300 & echo $! >left; ") + then},
                                .folder = folder.path(),
                                .seconds = seconds});
    pid_t left = 0;
    std::ifstream(file) >> left;
    REQUIRE(left > 0);
    CHECK_FALSE(runs(left));
    return end;
  };
  CHECK(leave("exit 3", 60).status == 3);
  CHECK(leave("wait", 1).late);
  CHECK(leave("kill -9 $$", 60).status == 128 + SIGKILL);
  // Input that nobody reads; SIGPIPE would end this process.
  CHECK(run_child({.command = {"true"}, .input = std::string(1 << 20, 'x')}).status == 0);
}

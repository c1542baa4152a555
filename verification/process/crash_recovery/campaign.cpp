#include <fcntl.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <bit>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>

#include "io/files/output_file.hpp"
#include "verification/process/crash_recovery/campaign.hpp"
#include "verification/support/runs.hpp"
#include "verification/support/support.hpp"

namespace freeplay::killed {

namespace {

Words with_folder(Words words, const Verb& verb, const Path& folder) {
  if (!verb.in_folder) words.emplace_back("-o");
  words.push_back(folder.string());
  return words;
}

/// The first difference, for a finding.
std::string difference(const Contents& found, const Contents& expected) {
  for (const auto& [name, text] : expected) {
    if (!found.contains(name)) return name + " is missing";
    if (found.at(name) != text) return name + " differs";
  }
  for (const auto& [name, text] : found)
    if (!expected.contains(name)) return name + " is too much";
  return "";
}

/// Whether a killed call has completed its new results, so that the next one can move them to their
/// place.
bool complete_beside(const Path& folder, const std::string& verb) {
  if (std::filesystem::exists(folder / fmt::format(".{}.complete", verb)) ||
      std::filesystem::exists(folder / fmt::format(".{}.moving", verb)))
    return true;
  std::ifstream in(folder / "run.json.partial");
  return in && nlohmann::json::accept(in);
}

}  // namespace

Campaign::Campaign(const Verb& verb, const Path& folder)
    : verb_(verb), whole_(folder / "whole"), older_(folder / "older"), shot_(folder / "shot") {
  const auto must = [&](const Words& words) {
    const auto end = let_end(words);
    if (end.status != 0)
      throw std::runtime_error(fmt::format("{} ends with {} undisturbed", verb.name, end.status));
    return end.seconds;
  };
  if (!verb_.older.empty()) must(with_folder(verb_.older, {}, older_));
  if (!verb_.older.empty()) std::filesystem::copy(older_, whole_, std::filesystem::copy_options::recursive);
  seconds_ = must(with_folder(verb_.words, verb_, whole_));
  expected_ = results_in(whole_);
  before_ = results_in(older_);
  if (!verb_.database.empty()) expected_runs_ = runs_in(whole_ / verb_.database);
  prepare();
}

void Campaign::prepare() {
  std::filesystem::remove_all(shot_);
  if (std::filesystem::exists(older_))
    std::filesystem::copy(older_, shot_, std::filesystem::copy_options::recursive);
  stored_.clear();
}

Words Campaign::words() const {
  if (verb_.resumes && std::filesystem::exists(shot_ / "run.checkpoint"))
    return {"run", "--resume", shot_.string(), "--checkpoint", "0.05", "--no-figures"};
  return with_folder(verb_.words, verb_, shot_);
}

void Campaign::wrong(int& count, const std::string& what) {
  ++count;
  tally_.findings.push_back(fmt::format("{}: {}", verb_.name, what));
}

void Campaign::assess(const std::string& when) {
  const auto found = results_in(shot_);
  if (found != expected_ && found != before_ && !complete_beside(shot_, verb_.name))
    wrong(tally_.lost, fmt::format("{}: neither the older results nor the new ones are there: {}; {}", when,
                                   difference(found, before_), difference(found, expected_)));
  if (verb_.database.empty()) return;
  const auto runs = runs_in(shot_ / verb_.database);
  for (const auto& [key, text] : stored_)
    if (!runs.contains(key)) wrong(tally_.lost, fmt::format("{}: the stored run {} is gone", when, key));
  for (const auto& [key, text] : runs)
    if (!expected_runs_.contains(key) || expected_runs_.at(key) != text)
      wrong(tally_.other, fmt::format("{}: the run {} is stored otherwise", when, key));
  stored_ = runs;
}

void Campaign::finish() {
  // --resume moves the results of a finished run to their place, and has then nothing to resume.
  const bool ended = verb_.resumes && complete_beside(shot_, verb_.name);
  const auto end = let_end(words());
  ++tally_.calls;
  if (end.status != 0 && !(ended && end.status == 2))
    wrong(tally_.stuck, fmt::format("the next call ends with {}", end.status));
  if (const auto what = difference(results_in(shot_), expected_); !what.empty())
    wrong(tally_.other, "the results are others in the end: " + what);
  if (std::filesystem::exists(whole_ / "figures"))
    for (const auto& figure : std::filesystem::directory_iterator(whole_ / "figures"))
      if (const auto name = figure.path().filename(); !std::filesystem::exists(shot_ / "figures" / name))
        wrong(tally_.other, fmt::format("{} is not drawn", name.string()));
  if (!verb_.database.empty())
    if (const auto what = difference(runs_in(shot_ / verb_.database), expected_runs_); !what.empty())
      wrong(tally_.other, "the stored runs are others in the end: " + what);
  if (const auto names = leftovers_in(shot_); !names.empty()) wrong(tally_.left_over, "left over: " + names);
  prepare();
}

void Campaign::at_random(int kills, unsigned seed) {
  std::mt19937 engine(seed);
  int in_a_row = 0;
  for (int missed = 0; kills > 0 && missed < 100;) {
    const double share = static_cast<double>(engine() % 10000) / 10000;
    const auto end = kill_after(words(), share * seconds_);
    ++tally_.calls;
    if (!end.killed) {  // too late: it is checked like any other completed call
      ++missed;
      finish();
      in_a_row = 0;
      continue;
    }
    ++tally_.kills;
    --kills;
    assess(fmt::format("killed after {:.3f} s", share * seconds_));
    if (++in_a_row == 6 ||
        kills == 0) {  // a command that makes no progress between kills is sometimes allowed
                       // to finish
      finish();
      in_a_row = 0;
    }
  }
}

void Campaign::at_changes(int first, int every) {
  for (int n = first;; n += every) {
    const auto end = kill_before(words(), n);
    ++tally_.calls;
    if (!end.killed) break;
    ++tally_.kills;
    assess(fmt::format("killed before its change {}", n));
    finish();
  }
}

std::vector<Verb> verbs(const Path& folder) {
  const auto source = test::source_folder();
  const auto rig = (source / "cases/flores2011/scene.toml").string();
  const auto study = [&](const char* name, const std::string& text) {
    write_file(folder / name, text);
    return (folder / name).string();
  };
  const std::string head = fmt::format(
      "scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\nrevolutions = 1\n"
      "discard = 0.5\n",
      (source / "cases/flores2011-experiment/guide.toml").string());
  const auto set = [](Words words, const std::string& revolutions) {
    for (const auto& key : {"run.revolutions=" + revolutions, std::string("run.discard=0")}) {
      words.emplace_back("--set");
      words.push_back(key);
    }
    return words;
  };
  const Words run{"run",          rig,    "--formulation", "nonsmooth", "--forces",
                  "--checkpoint", "0.05", "--no-figures"},
      compare{"compare", rig};
  const auto sweep = study("sweep.toml", head + "starts = 6\n");
  const auto calibrate = study("calibrate.toml", head + R"(starts = 1
[calibrate]
points = 5
starts = 1
revolutions = 1
[calibrate.unknowns.c]
key = "joints.gudgeon.clearance"
low = 0.2e-3
high = 1e-3
[calibrate.targets.t]
statistic = "rms"
value = 20.0
)");
  const auto tradeoff =
      study("tradeoff.toml", fmt::format(R"(scene = "{0}"
starts = 1
revolutions = 1
[variants.ideal]
scene = "{1}"
set = ["run.revolutions=0.02", "run.discard=0"]
)",
                                         rig, (source / "cases/tradeoff/ideal.toml").string()));
  const auto ball = (source / "cases/ball-on-table/scene.toml").string();
  const auto bifurcation = study("bifurcation.toml", fmt::format(R"(scene = "{}"
[axes.strength]
key = "curves.shake.amplitude"
range = [0.9e-3, 1.1e-3, 6]
[bifurcation]
section = "each touch"
discard = 60
keep = 20
)",
                                                                 ball));
  const auto basin = study("basin.toml", fmt::format(R"(scene = "{}"
[axes.angle]
key = "bodies.rotor.angle"
range = [-0.6, 0.6, 5]
[axes.speed]
key = "bodies.rotor.angular_velocity"
range = [-4.0, 4.0, 5]
[basin]
section = "every 0.5 s"
period = 0.5
discard = 12
keep = 4
)",
                                                     (source / "cases/bistable-rotor/scene.toml").string()));
  const auto poincare = [&](const char* periods) {
    return Words{"poincare", ball, "--section", "each touch", "--periods", periods, "--discard", "20"};
  };
  const Words trade{"tradeoff", tradeoff, "--allow-outside", "--repeats", "1"},
      penalty{"run", rig, "--formulation", "penalty", "--no-figures"};
  return {
      {.name = "run", .words = set(run, "0.4"), .older = set(penalty, "0.05"), .resumes = true},
      {.name = "compare", .words = set(compare, "0.1"), .older = set(compare, "0.05")},
      {.name = "sweep", .words = {"sweep", sweep, "--allow-outside"}, .database = "sweep.db"},
      {.name = "calibrate", .words = {"calibrate", calibrate, "--allow-outside"}, .database = "calibrate.db"},
      {.name = "tradeoff", .words = trade, .older = trade},
      {.name = "figures", .words = {"figures"}, .older = set(compare, "0.05"), .in_folder = true},
      {.name = "poincare", .words = poincare("2000"), .older = poincare("20")},
      {.name = "bifurcation",
       .words = {"bifurcation", bifurcation, "--allow-outside"},
       .database = "bifurcation.db"},
      {.name = "basin", .words = {"basin", basin, "--allow-outside"}, .database = "basin.db"},
      {.name = "plot",
       .words = {"plot", "--y", "gudgeon.gap,slider.vx"},
       .older = set(compare, "0.05"),
       .in_folder = true},
      {.name = "export", .words = {"export", "--hdf5"}, .older = set(penalty, "0.4"), .in_folder = true},
      {.name = "laws", .words = {"laws", rig}, .older = {"laws", rig, "--mass", "2"}},
      {.name = "drift", .words = set({"drift", rig}, "0.02"), .older = set({"drift", rig}, "0.01")}};
}

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

pid_t start(const Words& words, bool traced) {
  return test::start_freeplay(words, traced ? +[] { ptrace(PTRACE_TRACEME, 0, nullptr, nullptr); } : nullptr);
}

End end_of(pid_t id, Clock::time_point began) {
  int status = 0;
  if (waitpid(id, &status, 0) != id) throw std::runtime_error("the process is gone");
  return {WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL, WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          since(began), 0};
}

/// Whether a call changes the names in a folder.
bool changes_names(const __ptrace_syscall_info& call) {
  switch (call.entry.nr) {
#ifdef SYS_rename
    case SYS_rename:
    case SYS_unlink:
    case SYS_mkdir:
    case SYS_rmdir:
#endif
    case SYS_renameat:
    case SYS_renameat2:
    case SYS_unlinkat:
    case SYS_mkdirat:
      return true;
#ifdef SYS_open
    case SYS_open:
      return (call.entry.args[1] & O_CREAT) != 0;
#endif
    case SYS_openat:
      return (call.entry.args[2] & O_CREAT) != 0;
    default:
      return false;
  }
}

}  // namespace

End let_end(const Words& words) {
  const auto began = Clock::now();
  return end_of(start(words, false), began);
}

End kill_after(const Words& words, double seconds) {
  const auto began = Clock::now();
  const pid_t id = start(words, false);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  ::kill(id, SIGKILL);
  return end_of(id, began);
}

End kill_before(const Words& words, int n) {
  const auto began = Clock::now();
  const pid_t id = start(words, true);
  End end;
  int status = 0;
  // It stops once when it executes the program.
  if (waitpid(id, &status, 0) != id || !WIFSTOPPED(status)) throw std::runtime_error("cannot be traced");
  if (ptrace(PTRACE_SETOPTIONS, id, nullptr,
             PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL) != 0)
    throw std::runtime_error("cannot be traced");
  std::set<pid_t> threads{id};
  ptrace(PTRACE_SYSCALL, id, nullptr, nullptr);
  while (!threads.empty()) {
    const pid_t one = waitpid(-1, &status, __WALL);
    if (one < 0) break;
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      threads.erase(one);
      if (one == id) {
        end.killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
        end.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      continue;
    }
    threads.insert(one);
    int pass = 0;
    const int signal = WSTOPSIG(status);
    if (signal == (SIGTRAP | 0x80)) {
      __ptrace_syscall_info call{};
      ptrace(PTRACE_GET_SYSCALL_INFO, one, std::bit_cast<void*>(std::uintptr_t{sizeof call}), &call);
      if (call.op == PTRACE_SYSCALL_INFO_ENTRY && changes_names(call) && ++end.changes == n)
        ::kill(id, SIGKILL);
    } else if (signal != SIGTRAP && signal != SIGSTOP) {
      pass = signal;
    }
    ptrace(PTRACE_SYSCALL, one, nullptr, std::bit_cast<void*>(static_cast<std::intptr_t>(pass)));
  }
  end.seconds = since(began);
  return end;
}

}  // namespace freeplay::killed

// Many random scenes, each in a process of its own, on all cores. Judgements go to a file as they come.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "verification/random_scenes/builder.hpp"

namespace freeplay::verification::random_scenes {
namespace {

constexpr const char* whole = "all";  ///< the way of a line that ends a scene

std::string line_of(const RandomScene& s, const std::string& way, const Verdict& v) {
  auto what = v.what.substr(0, 1500);
  for (auto& c : what)
    if (c == ',' || c == '\n' || c == '\r') c = c == ',' ? ';' : ' ';
  return fmt::format("{},{},{},{},{:.3f},{:.3g},{}\n", s.index, s.kind, way, static_cast<int>(v.outcome),
                     v.known, v.cpu, what);
}

void append(int file, const std::string& line) {
  if (::write(file, line.data(), line.size()) != static_cast<ssize_t>(line.size())) _exit(3);
}

std::vector<Judgement> read_file(const std::filesystem::path& path, const std::string& head,
                                 std::set<int>& done) {
  std::map<std::pair<int, std::string>, Judgement> all;
  std::ifstream in(path);
  std::string line;
  if (in && std::getline(in, line) && line != head)
    throw std::runtime_error(
        fmt::format("{} holds other scenes ({}): take another folder", path.string(), line));
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::string f[7];
    for (int i = 0; i < 6; ++i) std::getline(fields, f[i], ',');
    std::getline(fields, f[6]);
    if (f[2].empty()) continue;
    const int index = std::atoi(f[0].c_str());
    if (f[2] == whole) {
      done.insert(index);
      continue;
    }
    all[{index, f[2]}] = {index,
                          f[1],
                          f[2],
                          {static_cast<Outcome>(std::atoi(f[3].c_str())), f[6],
                           std::strtod(f[4].c_str(), nullptr), std::strtod(f[5].c_str(), nullptr)}};
  }
  std::vector<Judgement> list;
  for (auto& [key, judgement] : all) list.push_back(std::move(judgement));
  return list;
}

void write_failing(const std::filesystem::path& folder, const RandomScene& scene, const Way& way,
                   const Verdict& v) {
  auto what = v.what;
  std::replace(what.begin(), what.end(), '\n', ' ');
  std::ofstream out(folder / "failing" / fmt::format("{}-{}-{}.toml", scene.kind, scene.index, [&] {
                      std::string name = way.name;
                      std::replace(name.begin(), name.end(), ' ', '_');
                      return name;
                    }()));
  out << fmt::format("# {} [{}]: {}\n# freeplay run FILE --formulation {}\n# {}\n", name_of(v.outcome),
                     way.name, scene.kind, name_of(way.family), what)
      << text_for(scene, way);
}

/// One scene in a process of its own; whose end tells of crashes and of hanging.
void judge_apart(const Request& request, int index, int file, const std::filesystem::path& folder, int* at) {
  const auto scene = draw(request.seed, index, request.kinds);
  *at = -1;
  const pid_t child = fork();
  if (child < 0) _exit(2);
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int s : {SIGABRT, SIGSEGV, SIGFPE, SIGILL, SIGBUS, SIGTERM}) std::signal(s, SIG_DFL);
    judge(scene, request.way, [&](const Way& way, const Verdict& v) {
      append(file, line_of(scene, way.name, v));
      if (is_defect(v.outcome)) write_failing(folder, scene, way, v);
      *at = static_cast<int>(&way - ways().data());
    });
    append(file, line_of(scene, whole, {}));
    _exit(0);
  }
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(40 * run_limit);
  int status = 0;
  bool late = false;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > until) {
      late = true;
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      break;
    }
    usleep(1000);
  }
  if (!late && WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  const auto next = static_cast<std::size_t>(*at + 1);
  const auto& way = ways()[std::min(next, ways().size() - 1)];
  const Verdict v{
      Outcome::crashed,
      late ? "did not end" : fmt::format("signal {}", WIFSIGNALED(status) ? WTERMSIG(status) : 0)};
  append(file, line_of(scene, way.name, v));
  write_failing(folder, scene, way, v);
  append(file, line_of(scene, whole, {}));
}

}  // namespace

std::vector<Judgement> judge_all(const Request& request, const std::filesystem::path& folder,
                                 const std::function<void(double)>& seen) {
  std::filesystem::create_directories(folder / "failing");
  const auto path = folder / "judgements.csv";
  const auto head = fmt::format("seed {} kinds {}", request.seed, request.kinds);
  std::set<int> done;
  read_file(path, head, done);
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) throw std::runtime_error("cannot write " + path.string());
  if (std::filesystem::file_size(path) == 0) append(file, head + "\n");
  std::vector<int> open_ones;
  for (int i = request.first; i < request.first + request.count; ++i)
    if (!done.contains(i)) open_ones.push_back(i);
  const int workers = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  auto* shared = static_cast<int*>(mmap(nullptr, sizeof(int) * static_cast<std::size_t>(workers + 1),
                                        PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  if (shared == MAP_FAILED) throw std::runtime_error("no shared memory");
  std::vector<pid_t> children;
  for (int w = 0; w < workers; ++w) {
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("no process");
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      // The next open one, whoever is free.
      for (;;) {
        const auto next = static_cast<std::size_t>(__atomic_fetch_add(&shared[workers], 1, __ATOMIC_RELAXED));
        if (next >= open_ones.size()) break;
        judge_apart(request, open_ones[next], file, folder, &shared[w]);
      }
      _exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
      if (seen)
        seen(std::min(1.0, static_cast<double>(shared[workers]) /
                               std::max<double>(1, static_cast<double>(open_ones.size()))));
      usleep(100000);
    }
  }
  munmap(shared, sizeof(int) * static_cast<std::size_t>(workers + 1));
  close(file);
  done.clear();
  auto list = read_file(path, head, done);
  std::erase_if(list, [&](const Judgement& j) {
    return j.index < request.first || j.index >= request.first + request.count;
  });
  return list;
}

std::string tables(const std::vector<Judgement>& judgements) {
  constexpr int outcomes = static_cast<int>(Outcome::crashed) + 1;
  std::string text =
      "| way | runs | right | doubted | falsely doubted | refused | slow | silent | crashed | all rows known | CPU s, mean |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  std::map<std::string, std::map<std::string, std::array<long, outcomes>>> by_kind;
  for (const auto& way : ways()) {
    std::array<long, outcomes> counts{};
    long all = 0, known = 0;
    double cpu = 0;
    for (const auto& j : judgements) {
      if (j.way != way.name) continue;
      ++counts[static_cast<std::size_t>(j.verdict.outcome)], ++all;
      known += j.verdict.known > 0.999;
      cpu += j.verdict.cpu;
    }
    text += fmt::format("| {} | {} |", way.name, all);
    for (const long n : counts) text += fmt::format(" {} |", n);
    text += fmt::format(" {} | {:.2g} |\n", known, all ? cpu / static_cast<double>(all) : 0);
  }
  for (const auto& j : judgements) ++by_kind[j.kind][j.way][static_cast<std::size_t>(j.verdict.outcome)];
  text += "\nSilent / falsely doubted / refused / slow / crashed of all runs, by kind and way:\n\n| kind |";
  for (const auto& way : ways()) text += fmt::format(" {} |", way.name);
  text += "\n| --- |";
  for (std::size_t i = 0; i < ways().size(); ++i) text += " --- |";
  text += "\n";
  for (const auto& [kind, row] : by_kind) {
    text += fmt::format("| {} |", kind);
    for (const auto& way : ways()) {
      const auto at = row.find(way.name);
      if (at == row.end()) {
        text += " |";
        continue;
      }
      const auto& n = at->second;
      const auto get = [&](Outcome o) { return n[static_cast<std::size_t>(o)]; };
      long all = 0;
      for (const long x : n) all += x;
      text += fmt::format(" {}/{}/{}/{}/{} of {} |", get(Outcome::silent), get(Outcome::falsely_doubted),
                          get(Outcome::refused), get(Outcome::slow), get(Outcome::crashed), all);
    }
    text += "\n";
  }
  return text;
}

}  // namespace freeplay::verification::random_scenes

// Many strangers, each by each way in a process of its own, on all cores.
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "mechanism/scene.hpp"
#include "verification/strangers/strangers.hpp"

namespace freeplay::verification::strangers {
namespace {

/// s of wall time for all runs of one stranger by one way: the run itself, its reference and twins, each limited.
constexpr double patience = 12 * run_limit;

Verdict judge_apart(const Stranger& stranger, const Way& way) {
  Cell cell{"strangers",
            stranger.kind,
            0,
            way.name,
            [&] {
              const auto v = judge(stranger, way);
              return Judged{v.outcome, fmt::format("{}\t{}\t{}\t{}", v.check, v.cpu, v.touches, v.detail)};
            },
            {}};
  const auto j = verification::judge_apart(cell, patience);
  Verdict v{j.outcome, "", j.detail};
  std::istringstream in(j.detail);
  std::string cpu, touches;
  if (j.detail.find('\t') != j.detail.npos) {
    std::getline(in, v.check, '\t'), std::getline(in, cpu, '\t'), std::getline(in, touches, '\t');
    v.cpu = std::strtod(cpu.c_str(), nullptr);
    v.touches = std::stoi(touches);
    v.detail.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (auto& c : v.detail)
    if (c == '\n' || c == '\t') c = ' ';
  return v;
}

/// A row on a line, short enough to be written at once.
std::string line_of(const Row& r) {
  return fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}", r.index, r.kind, r.way,
                     static_cast<int>(r.verdict.outcome), r.verdict.check, r.verdict.cpu, r.verdict.touches,
                     r.verdict.detail)
             .substr(0, 3000) +
         "\n";
}
Row row_of(const std::string& line) {
  std::istringstream in(line);
  std::string field[8];
  for (auto& f : field) std::getline(in, f, '\t');
  return {std::stoi(field[0]),
          field[1],
          field[2],
          {static_cast<Outcome>(std::stoi(field[3])), field[4], field[7],
           std::strtod(field[5].c_str(), nullptr), std::stoi(field[6])}};
}

}  // namespace

std::vector<Row> judge_one(const Stranger& stranger) {
  std::vector<Row> rows;
  const auto scene = parse_scene(stranger.text, fmt::format("stranger {}", stranger.index));
  for (const auto& way : ways())
    if (has_model(scene, way))
      rows.push_back({stranger.index, stranger.kind, way.name, judge_apart(stranger, way)});
  return rows;
}

std::vector<Row> judge_all(std::uint64_t seed, int count, const std::function<void(double)>& seen) {
  const int workers = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("strangers: no pipe");
  std::vector<pid_t> children;
  for (int w = 0; w < workers; ++w) {
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("strangers: no process");
    if (child == 0) {
      close(ends[0]);
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // what it inherits, a folder's lock too, ends with the program
      for (int i = w; i < count; i += workers)
        for (const auto& row : judge_one(draw(seed, i))) {
          const auto line = line_of(row);
          (void)!::write(ends[1], line.data(), line.size());
        }
      _exit(0);
    }
    children.push_back(child);
  }
  close(ends[1]);
  std::vector<Row> rows;
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(n));
    for (std::size_t at; (at = text.find('\n')) != text.npos; text.erase(0, at + 1)) {
      rows.push_back(row_of(text.substr(0, at)));
      if (seen) seen(rows.back().index / static_cast<double>(count));
    }
  }
  close(ends[0]);
  bool whole = true;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    whole = whole && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
  if (!whole) throw std::runtime_error("strangers: a process that judges them ended early");
  const auto place = [](const std::string& way) {
    const auto all = ways();
    return std::ranges::find_if(all, [&](const Way& w) { return way == w.name; }) - all.begin();
  };
  std::ranges::sort(rows, [&](const Row& a, const Row& b) {
    return std::pair{a.index, place(a.way)} < std::pair{b.index, place(b.way)};
  });
  return rows;
}

}  // namespace freeplay::verification::strangers

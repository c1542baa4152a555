#include "verification/random_scenes/runner.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "verification/random_scenes/checks/checks.hpp"
#include "verification/support/apart.hpp"

namespace freeplay::verification::random_scenes {
namespace {

constexpr const char* whole = "all";  ///< the method field of a line that ends a scene

/// A row on a line, short enough to be passed through a pipe at once.
std::string line_of(const Row& r) {
  const auto& v = r.verdict;
  return fmt::format("{},{},{},{},{:.3f},{:.3g},{}{}", r.index, r.kind, r.way, static_cast<int>(v.outcome),
                     v.known, v.cpu, v.check.empty() ? "" : v.check + "\t", v.detail)
             .substr(0, 3000) +
         "\n";
}
Row row_of(const std::string& line) {
  std::istringstream in(line);
  std::string f[7];
  for (int i = 0; i < 6; ++i) std::getline(in, f[i], ',');
  std::getline(in, f[6]);
  Row r{std::atoi(f[0].c_str()), f[1], f[2], {static_cast<Outcome>(std::atoi(f[3].c_str())), f[6]}};
  r.verdict.known = std::strtod(f[4].c_str(), nullptr);
  r.verdict.cpu = std::strtod(f[5].c_str(), nullptr);
  if (const auto tab = f[6].find('\t'); tab != f[6].npos)
    r.verdict.check = f[6].substr(0, tab), r.verdict.detail = f[6].substr(tab + 1);
  return r;
}

/// s of wall time until the next verdict: a run, its reference and twins, each limited.
double patience(Suite suite) { return (suite == Suite::rows ? 40 : 12) * run_limit(suite); }

/// The lines of a file that continues this request, without its header.
std::vector<Row> read_file(const std::filesystem::path& path, const std::string& head) {
  std::vector<Row> list;
  std::ifstream in(path);
  std::string line;
  if (in && std::getline(in, line) && line != head)
    throw std::runtime_error(
        fmt::format("{} holds other scenes ({}): take another folder", path.string(), line));
  while (std::getline(in, line))
    if (auto row = row_of(line); !row.way.empty()) list.push_back(std::move(row));
  return list;
}

void write_failing(const std::filesystem::path& folder, const RandomScene& scene, const Row& row) {
  const auto by = ways(scene.suite);
  const auto& way = *std::ranges::find(by, std::string_view(row.way), &Way::name);
  auto name = row.way;
  std::ranges::replace(name, ' ', '_');
  std::ofstream out(folder / "failing" / fmt::format("{}-{}-{}.toml", scene.kind, scene.index, name));
  out << fmt::format("# {} [{}]: {}\n# freeplay run FILE --formulation {}\n# {}\n",
                     name_of(row.verdict.outcome, scene.suite), way.name, scene.kind, name_of(way.family),
                     row.verdict.detail)
      << text_for(scene, way);
}

}  // namespace

std::vector<Row> judge_apart(const RandomScene& scene, const std::string& only_way) {
  std::vector<const Way*> by;
  for (const auto& way : ways(scene.suite))
    if ((only_way.empty() || only_way == way.name) && has_model(scene, way)) by.push_back(&way);
  std::vector<Row> rows;
  const auto next = [&] { return Row{scene.index, scene.kind, by[rows.size()]->name, {}}; };
  while (rows.size() < by.size()) {
    const auto left = std::span(by).subspan(rows.size());
    const auto apart = run_apart(
        [&](const Say& say) {
          assess(scene, left, [&](const Verdict& v) {
            auto row = next();
            row.verdict = v;
            for (auto& c : row.verdict.detail)
              if (c == '\n' || c == '\r' || c == '\t') c = ' ';
            const auto line = line_of(row);
            rows.push_back(std::move(row));
            say(line);
          });
        },
        patience(scene.suite));
    std::istringstream in(apart.said);
    for (std::string line; std::getline(in, line) && rows.size() < by.size();) rows.push_back(row_of(line));
    if (rows.size() == by.size()) break;
    // It ended early: this method has that outcome, and the next ones run in another process.
    auto row = next();
    row.verdict = apart.late ? Verdict{Outcome::hung, "did not end"}
                             : Verdict{Outcome::crashed, fmt::format("signal {}", apart.signal)};
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<Row> judge_all(const Request& request, const std::filesystem::path& folder,
                           const std::function<void(double)>& seen) {
  const auto suite = draw(request.seed, request.first, request.kinds).suite;
  const bool recorded = suite == Suite::rows;
  std::vector<Row> rows;
  std::set<int> done;
  std::ofstream record;
  if (recorded) {
    std::filesystem::create_directories(folder / "failing");
    const auto path = folder / "judgements.csv";
    const auto head = fmt::format("seed {} kinds {}", request.seed, request.kinds);
    rows = read_file(path, head);
    for (const auto& r : rows)
      if (r.way == whole) done.insert(r.index);
    record.open(path, std::ios::app);
    if (!record) throw std::runtime_error("cannot write " + path.string());
    if (std::filesystem::file_size(path) == 0) record << head << std::endl;
  }
  std::vector<int> open_ones;
  for (int i = request.first; i < request.first + request.count; ++i)
    if (!done.contains(i)) open_ones.push_back(i);
  // The next open scene, for any free process.
  auto* next = static_cast<std::size_t*>(
      mmap(nullptr, sizeof(std::size_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  int ends[2];
  if (next == MAP_FAILED || pipe(ends) != 0)
    throw std::runtime_error("random scenes: no shared memory or pipe");
  std::vector<pid_t> children;
  for (unsigned w = 0; w < std::max(1U, std::thread::hardware_concurrency()); ++w) {
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("random scenes: no process");
    if (child == 0) {
      close(ends[0]);
      // inherited resources, a folder's lock too, end with the program
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      for (std::size_t i; (i = __atomic_fetch_add(next, 1, __ATOMIC_RELAXED)) < open_ones.size();) {
        const auto scene = draw(request.seed, open_ones[i], request.kinds);
        auto list = judge_apart(scene, request.way);
        for (const auto& row : list)
          if (recorded && is_defect(row.verdict.outcome, suite)) write_failing(folder, scene, row);
        list.push_back({scene.index, scene.kind, whole, {}});
        for (const auto& row : list) {
          const auto line = line_of(row);
          (void)!::write(ends[1], line.data(), line.size());
        }
      }
      _exit(0);
    }
    children.push_back(child);
  }
  close(ends[1]);
  std::size_t ended = 0;
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) {
    text.append(buffer, static_cast<std::size_t>(n));
    for (std::size_t at; (at = text.find('\n')) != text.npos; text.erase(0, at + 1)) {
      rows.push_back(row_of(text.substr(0, at)));
      if (recorded) {
        std::ranges::replace(rows.back().verdict.detail, ',', ';');  // the file separates by commas
        record << line_of(rows.back()) << std::flush;
      }
      if (rows.back().way == whole && seen)
        seen(static_cast<double>(++ended) / static_cast<double>(open_ones.size()));
    }
  }
  close(ends[0]);
  munmap(next, sizeof *next);
  bool kept = true;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    kept = kept && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }
  if (!kept) throw std::runtime_error("random scenes: a process that judges them ended early");
  // The last line of a scene and a method counts: interrupted ones have been assessed again.
  std::map<std::pair<int, std::ptrdiff_t>, Row> in_order;
  const auto all = ways(suite);
  for (auto& row : rows) {
    const auto way = std::ranges::find(all, std::string_view(row.way), &Way::name) - all.begin();
    if (row.way != whole && row.index >= request.first && row.index < request.first + request.count)
      in_order[{row.index, way}] = std::move(row);
  }
  rows.clear();
  for (auto& [place, row] : in_order) rows.push_back(std::move(row));
  return rows;
}

}  // namespace freeplay::verification::random_scenes

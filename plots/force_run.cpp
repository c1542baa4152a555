// Reads forces.csv, finds the last turn in it and merges its rows.
#include "plots/force_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numbers>

#include "io/output_file.hpp"
#include "model/elements/speed_drive.hpp"

namespace freeplay::plots {

ForceRun read_force_run(const std::filesystem::path& file, const char* title, int style) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line)) throw OutputError(file.string() + ": cannot be read");
  ForceRun run{title, style, {}, {}, {}, {}};
  std::vector<Values*> place;
  const auto fields = [&](const auto& take) {
    std::size_t count = 0;
    for (std::size_t from = 0; from <= line.size(); ++count) {
      const auto to = line.find(',', from);
      if (to != line.npos) line[to] = '\0';
      take(count, line.c_str() + from);
      from = to == line.npos ? line.size() + 1 : to + 1;
    }
    return count;
  };
  fields([&](std::size_t, const char* field) {
    const std::string name = field;
    place.push_back(name == "t" ? &run.t : nullptr);
    if (!name.ends_with("_mean")) return;
    run.names.push_back(name.substr(0, name.size() - 5));
    place.back() = &run.mean[run.names.back()];
  });
  for (std::size_t row = 2; std::getline(in, line); ++row) {
    const auto count = fields([&](std::size_t i, const char* field) {
      if (i >= place.size() || !place[i]) return;
      char* end = nullptr;
      const double x = std::strtod(field, &end);
      if (row > 2 || place[i] == &run.t)
        place[i]->push_back(end == field ? std::numeric_limits<double>::quiet_NaN() : x);
    });
    if (count != place.size())
      throw OutputError(
          fmt::format("{}: line {} has {} fields, its header {}", file.string(), row, count, place.size()));
  }
  return run;
}

void keep_last_turn(ForceRun& run, const SpeedDrive* drive) {
  const auto& t = run.t;
  const std::size_t n = t.empty() ? 0 : t.size() - 1;
  std::size_t first = 0, last = n;
  for (std::size_t i = 0; i < n; ++i) run.x.push_back(0.5 * (t[i] + t[i + 1]));
  if (drive && n > 0) {
    const auto turns = [&](double time) {
      return std::copysign(1, drive->speed) * (drive->initial_angle + drive->speed * time) /
             (2 * std::numbers::pi);
    };
    constexpr double rounding = 1e-6;
    double begin = std::floor(turns(t.back()) + rounding) - 1;
    run.part = "last turn";
    if (begin < turns(t.front()) - rounding) {
      begin = turns(t.back()) - 1;
      run.part = begin < turns(t.front()) - rounding ? "whole run" : "last 360°";
    }
    for (auto& x : run.x) x = turns(x);
    while (first < n && run.x[first] < begin) ++first;
    while (last > first && run.x[last - 1] > begin + 1) --last;
    for (auto& x : run.x) {  // at the crank's own angles, which a crank that turns backwards passes falling
      x = drive->speed < 0 ? -x : x;
      x = 360 * (x - std::floor(x));
    }
  }
  const auto cut = [&](Values& v, std::size_t to) {
    v.erase(v.begin() + static_cast<std::ptrdiff_t>(to), v.end());
    v.erase(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(first));
  };
  cut(run.x, last);
  cut(run.t, std::min(last + 1, t.size()));
  for (auto& [name, v] : run.mean) cut(v, last);
}

void merge(ForceRun& run, std::size_t count) {
  const auto& t = run.t;
  const std::size_t n = run.x.size();
  const auto joined = [&](const Values& v, bool angle) {
    Values out;
    for (std::size_t i = 0; i < n; i += count) {
      double sum = 0;
      const std::size_t end = std::min(i + count, n);
      // An angle that jumps back to 0, or to 360, has no mean.
      if (angle && std::abs(v[end - 1] - v[i]) > 180) {
        out.push_back(v[i]);
        continue;
      }
      for (std::size_t k = i; k < end; ++k) sum += v[k] * (t[k + 1] - t[k]);
      out.push_back(sum / (t[end] - t[i]));
    }
    return out;
  };
  for (auto& [name, v] : run.mean) v = joined(v, false);
  run.x = joined(run.x, true);
  if (n > 0) run.interval = t[std::min(count, n)] - t[0];
}

}  // namespace freeplay::plots

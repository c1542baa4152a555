// Reads forces.csv, finds its last turn and merges its rows.
#include "plots/tables/force_run.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/elements/speed_drive.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {

ForceRun read_force_run(const std::filesystem::path& file, const char* title, int style) {
  Rows rows(file);
  ForceRun run{title, style, {}, {}, {}, {}};
  const auto t = rows.place("t");
  std::vector<std::pair<std::size_t, Values*>> means;
  for (std::size_t i = 0; i < rows.names().size(); ++i) {
    const auto& name = rows.names()[i];
    if (!name.ends_with("_mean")) continue;
    run.names.push_back(name.substr(0, name.size() - 5));
    means.emplace_back(i, &run.mean[run.names.back()]);
  }
  while (rows.next()) {
    run.t.push_back(rows.number(t));
    if (run.t.size() == 1) continue;  // the first row has no interval before it
    for (const auto& [place, values] : means) values->push_back(rows.maybe_number(place));
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
    for (auto& x : run.x) {  // the angle decreases if the crank turns backwards
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
      // No mean can be taken of angles across the wrap at 360°.
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

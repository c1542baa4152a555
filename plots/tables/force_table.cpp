// Selects the runs, joints, drives and columns of the figures of forces.

#include "plots/tables/force_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "io/files/input_file.hpp"
#include "mechanism/elements/speed_drive.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"
#include "values/family.hpp"

namespace freeplay::plots {

// Reads forces.csv, finds its last turn and merges its rows.

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

namespace {

constexpr std::size_t curve_points = 2000;  ///< at most, per curve; further rows are merged
constexpr std::size_t most_joints = 12;
constexpr std::size_t most_drives = 6;

}  // namespace

ForceTable::ForceTable(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "comparison.json")) {
    source_ = "comparison.json";
    add(folder / "penalty", "penalty", 1);
    add(folder / "nonsmooth", "nonsmooth", 2);
    add(folder / "ideal", "ideal joint", 3);
  } else if (std::filesystem::exists(folder / "run.json")) {
    const auto family =
        family_named(JsonFile(folder / "run.json").text("formulation")).value_or(Family::penalty);
    add(folder, name_of(family), family == Family::penalty ? 1 : 2);
  }
  if (scene_)
    if (const auto* drive = main_drive(scene_->mechanism); drive && drive->speed != 0) drive_ = *drive;
  std::size_t longest = 0;
  for (auto& run : runs_) {
    keep_last_turn(run, drive_ ? &*drive_ : nullptr);
    longest = std::max(longest, run.x.size());
  }
  for (auto& run : runs_) {
    merge(run, std::max<std::size_t>(1, (longest + curve_points - 1) / curve_points));
    interval_ = std::max(interval_, run.interval);
  }
}

void ForceTable::add(const std::filesystem::path& folder, const char* title, int style) {
  if (!std::filesystem::exists(folder / "forces.csv")) return;
  const JsonFile json(folder / "run.json");
  if (!scene_) scene_ = scene_in(json);
  if (json.find("undetermined_reactions"))
    for (const auto& name : json.texts("undetermined_reactions")) undetermined_.insert(name);
  auto run = read_force_run(folder / "forces.csv", title, style);
  if (run.t.size() > 2) runs_.push_back(std::move(run));
}

/// Joints and contacts have a column for the moment; loads have none.
std::vector<std::string> ForceTable::joints() const {
  std::vector<std::string> list;
  for (const auto& run : runs_)
    for (const auto& column : run.names) {
      if (!column.ends_with(".m")) continue;
      auto name = column.substr(0, column.size() - 2);
      for (const auto* corner : guide_corners)
        if (name.ends_with(std::string(".") + corner)) name.resize(name.size() - std::strlen(corner) - 1);
      place_in(list, name);
    }
  if (list.size() > most_joints) {
    std::stable_partition(list.begin(), list.end(),
                          [&](const std::string& name) { return clearance_joint(name); });
    list.resize(most_joints);
  }
  return list;
}

std::vector<std::string> ForceTable::drives() const {
  std::vector<std::string> list;
  for (const auto& run : runs_)
    for (const auto& column : run.names) {
      if (!column.ends_with(".torque")) continue;
      const auto name = column.substr(0, column.size() - 7);
      const auto is = [&](const Drive& d) {
        return std::visit([](const auto& x) { return x.name; }, d) == name;
      };
      if (scene_ && std::ranges::none_of(scene_->mechanism.drives, is)) continue;
      if (std::ranges::find(list, name) == list.end() && list.size() < most_drives) list.push_back(name);
    }
  return list;
}

const Joint* ForceTable::joint(const std::string& name) const {
  if (!scene_) return nullptr;
  const auto& list = scene_->mechanism.joints;
  const auto it = std::ranges::find(list, name, [](const Joint& j) { return name_of(j); });
  return it == list.end() ? nullptr : &*it;
}

bool ForceTable::revolute(const std::string& name) const {
  const auto* j = joint(name);
  return j && std::holds_alternative<RevoluteJoint>(*j);
}

bool ForceTable::clearance_joint(const std::string& name) const {
  const auto has_clearance = [](const auto& x) {
    if constexpr (requires { x.clearance; })
      return x.clearance.has_value();
    else
      return false;
  };
  const auto* j = joint(name);
  return j && std::visit(has_clearance, *j);
}

std::string ForceTable::heading(const std::string& name) const {
  const auto* j = joint(name);
  const char* open = undetermined_.contains(name) ? " (minimum norm: statically indeterminate)" : "";
  if (!j) return name + ": force on the second body" + open;
  const int body = bodies_of(*j)[1];
  return fmt::format("{}: force on {}{}", name,
                     body == ground ? "the ground" : scene_->mechanism.bodies[body].name, open);
}

bool ForceTable::any(const std::string& column) const {
  return std::ranges::any_of(runs_, [&](const ForceRun& run) { return run.find(column) != nullptr; });
}

std::vector<Values> ForceTable::columns(const std::string& name, const char* suffix) const {
  std::vector<Values> list;
  for (const auto& run : runs_) {
    Values sum;
    if (const auto* v = run.find(name + suffix)) sum = *v;
    for (const auto* corner : guide_corners)
      if (const auto* v = run.find(name + "." + corner + suffix)) {
        sum.resize(v->size(), 0.0);
        std::ranges::transform(sum, *v, sum.begin(), std::plus<>());
      }
    if (std::ranges::none_of(sum, [](double x) { return std::isfinite(x); })) sum.clear();
    list.push_back(std::move(sum));
  }
  return list;
}

std::vector<Values> ForceTable::magnitudes(const std::string& name) const {
  auto x = columns(name, ".fx");
  const auto y = columns(name, ".fy");
  for (std::size_t r = 0; r < x.size(); ++r) {
    x[r].resize(std::min(x[r].size(), y[r].size()));
    std::ranges::transform(x[r], y[r], x[r].begin(), [](double a, double b) { return std::hypot(a, b); });
  }
  return x;
}

std::string ForceTable::extent() const {
  return fmt::format("{}, means over {}", runs_.front().part,
                     interval_ < 1e-3 ? fmt::format("{:.3g} µs", 1e6 * interval_)
                                      : fmt::format("{:.3g} ms", 1e3 * interval_));
}

}  // namespace freeplay::plots

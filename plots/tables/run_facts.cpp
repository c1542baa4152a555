#include "plots/tables/run_facts.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/files/input_file.hpp"
#include "io/files/recorded_run.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/table.hpp"
#include "values/family.hpp"

namespace freeplay::plots {

std::shared_ptr<const Scene> scene_in(const JsonFile& file) {
  try {
    return std::make_shared<const Scene>(parse_scene(file.text("provenance.scene"),
                                                     file.text("provenance.scene_file"),
                                                     file.texts("provenance.overrides")));
  } catch (const SceneError&) {
    return {};
  }
}

std::shared_ptr<const Scene> scene_of_run(const std::filesystem::path& folder) {
  if (auto scene = scene_in(JsonFile(folder / "run.json"))) return scene;
  try {  // the scene was built in code, or refers to missing files: use the setup of the run
    return std::make_shared<const Scene>(read_run(folder / "run.json").setup.scene);
  } catch (const SceneError&) {
    return {};
  }
}

std::optional<double> turn_of(const Scene* scene) {
  const auto* drive = scene ? main_drive(scene->mechanism) : nullptr;
  if (!drive || drive->speed == 0) return std::nullopt;
  return 2 * std::numbers::pi / std::abs(drive->speed);
}

Span first_part(std::optional<double> turn, double end) {
  if (!turn) return {0, 0.1 * end, "first tenth"};
  return {0, std::min(*turn, end), "first turn"};
}

Span last_part(std::optional<double> turn, double end, int turns) {
  if (!turn) return {0.9 * end, end, "last tenth"};
  // a short run is not covered completely
  while (turns > 1 && (turns + 0.5) * *turn > end) --turns;
  if (turns * *turn >= end) return {0, end, "whole run"};
  return {end - turns * *turn, end, turns == 1 ? "last turn" : fmt::format("last {} turns", turns)};
}

std::vector<RunFolder> runs_in(const std::filesystem::path& folder) {
  std::vector<RunFolder> list;
  const auto add = [&](const std::filesystem::path& run, const char* title, int style) {
    if (std::filesystem::exists(run / "trajectory.csv") && std::filesystem::exists(run / "run.json"))
      list.push_back({run, title, style});
  };
  if (std::filesystem::exists(folder / "comparison.json")) {
    add(folder / "penalty", "penalty", 1);
    add(folder / "nonsmooth", "nonsmooth", 2);
    add(folder / "ideal", "ideal joint", 3);
  } else {
    // A folder of `freeplay orbit` has the run of the periodic motion in a folder of its own.
    const auto run =
        !std::filesystem::exists(folder / "run.json") && std::filesystem::exists(folder / "orbit.json")
            ? folder / "motion"
            : folder;
    if (!std::filesystem::exists(run / "run.json")) return list;
    const auto family =
        family_named(JsonFile(run / "run.json").text("formulation")).value_or(Family::penalty);
    add(run, name_of(family), family == Family::penalty ? 1 : 2);
  }
  return list;
}

const char* source_of(const std::filesystem::path& folder) {
  for (const char* name : {"comparison.json", "run.json"})
    if (std::filesystem::exists(folder / name)) return name;
  return "orbit.json";
}

double end_of(const std::filesystem::path& folder) {
  Rows rows(folder / "trajectory.csv");
  const auto t = rows.place("t");
  double end = 0;
  while (rows.next()) end = rows.number(t);
  return end;
}

double discard_of(const std::filesystem::path& folder) {
  const JsonFile run(folder / "run.json");
  const auto* discard = run.find("provenance.options.run.discard");
  return discard && discard->is_number() ? discard->get<double>() : 0;
}

std::vector<std::string> bodies_in(const Rows& rows) {
  std::vector<std::string> list;
  for (const auto& name : rows.names())
    if (name.ends_with(".omega")) list.push_back(name.substr(0, name.size() - 6));
  return list;
}

BodyMotion motion_of(const std::filesystem::path& run, const Span& span, std::size_t most_bodies, long rows) {
  const auto file = run / "trajectory.csv";
  long count = 0;
  {
    Rows in(file);
    const auto t = in.place("t");
    while (in.next()) count += span.holds(in.number(t));
  }
  Rows in(file);
  const auto t = in.place("t");
  BodyMotion motion{bodies_in(in), {}, {}};
  motion.bodies.resize(std::min(motion.bodies.size(), most_bodies));
  std::vector<std::size_t> places;
  for (const auto& body : motion.bodies)
    for (const char* part : {".x", ".y", ".theta", ".vx", ".vy", ".omega"})
      places.push_back(in.place(body + part));
  motion.coordinates.resize(motion.bodies.size());
  const long each = 1 + count / rows;
  for (long seen = 0; in.next();) {
    const double time = in.number(t);
    if (!span.holds(time) || seen++ % each != 0) continue;
    motion.t.push_back(time);
    for (std::size_t i = 0; i < places.size(); ++i)
      motion.coordinates[i / 6][i % 6].push_back(in.number(places[i]));
  }
  return motion;
}

double range_of(const std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(values);
  return most - least;
}

}  // namespace freeplay::plots

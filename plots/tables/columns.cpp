#include "plots/tables/columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "io/files/visible.hpp"
#include "io/scene/schema.hpp"
#include "mechanism/scene.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_samples = 20'000'000;

/// Units of columns by the ends of their names. A mean has the unit of its quantity.
constexpr std::pair<std::string_view, std::string_view> units[] = {{".x", "m"},
                                                                   {".y", "m"},
                                                                   {".theta", "rad"},
                                                                   {".vx", "m/s"},
                                                                   {".vy", "m/s"},
                                                                   {".omega", "rad/s"},
                                                                   {".ex", "m"},
                                                                   {".ey", "m"},
                                                                   {".gap", "m"},
                                                                   {".fx", "N"},
                                                                   {".fy", "N"},
                                                                   {".fn", "N"},
                                                                   {".ft", "N"},
                                                                   {".m", "N m"},
                                                                   {".torque", "N m"},
                                                                   {".power", "W"},
                                                                   {".ax", "m/s²"},
                                                                   {".ay", "m/s²"},
                                                                   {".alpha", "rad/s²"},
                                                                   {"t", "s"},
                                                                   {"crank_angle", "rad"},
                                                                   {"v_n_minus", "m/s"},
                                                                   {"v_n_plus", "m/s"},
                                                                   {"v_t_minus", "m/s"},
                                                                   {"v_t_plus", "m/s"},
                                                                   {"impulse_n", "N s"},
                                                                   {"impulse_t", "N s"},
                                                                   {"duration", "s"},
                                                                   {"t_uncertainty", "s"}};

/// Unit of the samples of an instrument.
const char* unit_of(Instrument::Kind kind) {
  switch (kind) {
    case Instrument::Kind::accelerometer:
      return "m/s²";
    case Instrument::Kind::lvdt:
      return "m";
    case Instrument::Kind::encoder:
      return "rad";
    case Instrument::Kind::load_cell:
      return "N";
    case Instrument::Kind::torque:
      return "N m";
  }
  return "";
}

constexpr const char* angle_name = "crank_angle";
constexpr const char *signal_file = "signals.csv", *event_file = "events.csv";

}  // namespace

std::string_view unit_of_column(std::string_view column) {
  if (column.ends_with("_mean")) column.remove_suffix(5);
  const auto dot = column.rfind('.');
  const auto end = dot == column.npos ? column : column.substr(dot);
  const auto it = std::ranges::find(units, end, &std::pair<std::string_view, std::string_view>::first);
  return it == std::end(units) ? "" : it->second;
}

std::string_view unit_of_instrument(const Scene& scene, std::string_view name) {
  const auto it = std::ranges::find(scene.instruments, name, &Instrument::name);
  return it == scene.instruments.end() ? "" : unit_of(it->kind);
}

std::string no_column(const std::string& name, const std::vector<Column>& all) {
  std::vector<std::string> names;
  for (const auto& c : all) names.push_back(c.name);
  const auto near = nearest_word(name, names);
  std::string said = fmt::format("unknown column {}", visible_brief(name, 60));
  if (!near.empty()) said += fmt::format("; did you mean {}?", near);
  constexpr std::size_t widest = 1000;
  for (const char* file : {"", "trajectory.csv", "forces.csv", signal_file, event_file}) {
    std::size_t width = widest;
    for (const auto& c : all) {
      if (c.file != file) continue;
      if (width == widest) {
        said += fmt::format("\n  {}:", c.file.empty() ? "everywhere" : c.file);
        width = c.file.size() + 3;
      }
      if (width + c.name.size() + 1 > 78) said += "\n   ", width = 3;
      said += " " + c.name;
      width += c.name.size() + 1;
    }
  }
  return said;
}

struct RunColumns::Series {
  std::vector<double> t, v;
  std::string without_rows;  ///< the file, if it has only a header
};

RunColumns::RunColumns(const std::filesystem::path& folder) : folder_(folder), scene_(scene_of_run(folder)) {
  if (scene_)
    if (const auto* drive = main_drive(scene_->mechanism)) crank_ = {drive->initial_angle, drive->speed};
  all_.push_back({"t", "", "", "s"});
  if (crank_) all_.push_back({angle_name, "", "", "rad"});
  for (const char* file : {"trajectory.csv", "forces.csv", event_file}) {
    if (!std::filesystem::exists(folder / file)) continue;
    const Rows header(folder / file);
    for (const auto& name : header.names())
      if (name != "t" && name != angle_name && name != "joint" && name != "kind")
        all_.push_back({name, file, "", std::string(unit_of_column(name))});
  }
  if (!std::filesystem::exists(folder / signal_file)) return;
  Rows rows(folder / signal_file);
  const auto channel = rows.place("channel");
  std::vector<std::string> seen;
  for (long i = 0; i < 100'000 && rows.next(); ++i)
    if (const auto& name = rows.name(channel); std::ranges::find(seen, name) == seen.end())
      seen.push_back(name);
  for (const auto& name : seen) {
    Column c{name, signal_file, name, ""};
    if (scene_) c.unit = unit_of_instrument(*scene_, name);
    all_.push_back(std::move(c));
  }
}

const Column* RunColumns::find(std::string_view name) const {
  const auto it = std::ranges::find(all_, name, &Column::name);
  return it == all_.end() ? nullptr : &*it;
}

double RunColumns::crank(double t) const { return crank_->first + crank_->second * t; }

/// A column over the time of its file. A column without a file (t, crank_angle) is over the time of
/// `file`.
RunColumns::Series RunColumns::series(const Column& column, const std::string& file,
                                      const std::string& channel, double from, double to) const {
  const bool own = !column.file.empty();
  Rows rows(folder_ / (own ? column.file : file));
  const auto& wanted = own ? column.channel : channel;
  const auto t = rows.place("t");
  const auto v = !own ? t : rows.place(wanted.empty() ? column.name : "value");
  const auto name = wanted.empty() ? t : rows.place("channel");
  Series s;
  s.without_rows = (folder_ / (own ? column.file : file)).string();
  while (rows.next()) {
    s.without_rows.clear();
    if (!wanted.empty() && rows.name(name) != wanted) continue;
    if (const double time = rows.number(t); time < from || time > to) continue;
    if (s.t.size() == most_samples)
      throw SceneError(fmt::format("{}: has more than {} rows", (folder_ / file).string(), most_samples));
    s.t.push_back(rows.number(t));
    s.v.push_back(column.name == angle_name ? crank(s.t.back()) : own ? rows.maybe_number(v) : s.t.back());
  }
  return s;
}

Points RunColumns::read(const Column& x, const Column& y, double from, double to,
                        const std::optional<Crossing>& section) const {
  const auto& leading = !y.file.empty() ? y : x;
  const std::string file = leading.file.empty() ? "trajectory.csv" : leading.file;
  std::vector<Series> all{series(x, file, leading.channel, from, to),
                          series(y, file, leading.channel, from, to)};
  const bool of_crank = section && section->column == "crank";
  if (of_crank && !crank_) throw SceneError("--section crank: no drive of the run has a prescribed speed");
  if (section && file == event_file)
    throw SceneError("--section: does not apply to events, which are instants already");
  if (section && !of_crank) {
    const auto* s = find(section->column);
    if (!s) throw SceneError("--section: " + no_column(section->column, all_));
    all.push_back(series(*s, file, leading.channel, from, to));
  }
  for (const auto& one : all)
    if (!one.without_rows.empty()) return {.without_rows = one.without_rows};
  // The rows whose t occurs in all series.
  std::vector<std::array<double, 4>> rows;
  const auto same_file = [](const Column& a, const Column& b) {
    return a.file.empty() || b.file.empty() || (a.file == b.file && a.channel == b.channel);
  };
  std::vector<std::size_t> at(all.size(), 0);
  const bool events_alone = file == event_file && same_file(x, y);
  if (file == event_file && !events_alone)
    throw SceneError(
        fmt::format("{} and {} have no rows in common: events are at separate instants", x.name, y.name));
  for (const double t : all.back().t) {
    bool found = true;
    for (std::size_t k = 0; k < all.size(); ++k) {
      while (at[k] < all[k].t.size() && all[k].t[at[k]] < t) ++at[k];
      found = found && at[k] < all[k].t.size() && all[k].t[at[k]] == t;
    }
    if (found)
      rows.push_back({t, all[0].v[at[0]], all[1].v[at[1]],
                      of_crank         ? crank(t) * 180 / std::acos(-1.0)
                      : all.size() > 2 ? all[2].v[at[2]]
                                       : 0});
    if (found && events_alone)  // there may be several events at one instant
      for (auto& k : at) ++k;
  }
  if (rows.empty() && from == -INFINITY && to == INFINITY)
    throw SceneError(fmt::format("{} and {} have no rows in common: the times of {} and {} differ", x.name,
                                 y.name, x.file.empty() ? "it" : x.file, y.file.empty() ? "it" : y.file));
  Points points;
  const auto add = [&](double a, double b) {
    if (!std::isfinite(a) || !std::isfinite(b)) return;
    points.x.push_back(a);
    points.y.push_back(b);
  };
  if (!section) {
    for (const auto& r : rows) add(r[1], r[2]);
    return points;
  }
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    double a = rows[i][3] - section->value, b = rows[i + 1][3] - section->value;
    if (of_crank) {  // the angle passes the section in every turn
      const double turn = 360 * (b > a ? std::floor(b / 360) : std::ceil(b / 360));
      a -= turn, b -= turn;
    }
    const bool rises = a < 0 && b >= 0, falls = a > 0 && b <= 0;
    if (!(rises && section->sense >= 0) && !(falls && section->sense <= 0)) continue;
    const double w = a / (a - b);
    add(rows[i][1] + w * (rows[i + 1][1] - rows[i][1]), rows[i][2] + w * (rows[i + 1][2] - rows[i][2]));
  }
  return points;
}

}  // namespace freeplay::plots

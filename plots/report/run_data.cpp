#include "plots/report/run_data.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "io/scene/beam_line.hpp"
#include "io/scene/bearing_line.hpp"
#include "io/scene/pose_file.hpp"
#include "mechanism/scene.hpp"
#include "plots/report/thinning.hpp"
#include "plots/tables/clearance_joints.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::report {
namespace {

/// Orders by impulse, then by approach speed, because the onset of a lasting contact has no impulse
/// yet.
bool harder(const Event& a, const Event& b) {
  const double p = std::abs(a.impulse), q = std::abs(b.impulse);
  return p != q ? p > q : std::abs(a.approach) > std::abs(b.approach);
}

void keep_hardest(std::vector<Event>& list, std::size_t most) {
  if (list.size() <= most) return;
  std::ranges::nth_element(list, list.begin() + static_cast<std::ptrdiff_t>(most), harder);
  list.resize(most);
}

}  // namespace

Events read_events(const std::filesystem::path& folder, std::size_t most) {
  Events events;
  const auto file = folder / "events.csv";
  if (!std::filesystem::exists(file)) return events;
  plots::Rows rows(file);
  const auto t = rows.place("t"), joint = rows.place("joint"), kind = rows.place("kind"),
             approach = rows.place("v_n_minus"), impulse = rows.place("impulse_n"),
             duration = rows.place("duration");
  while (rows.next()) {
    ++events.all;
    const auto number = [&](std::size_t place) {
      const double x = rows.maybe_number(place);
      return std::isfinite(x) ? x : 0;
    };
    events.list.push_back({rows.number(t), number(approach), number(impulse), number(duration),
                           plots::place_in(events.joints, rows.name(joint)),
                           static_cast<int>(plots::place_in(events.kinds, rows.name(kind)))});
    if (events.list.size() >= 4 * most) keep_hardest(events.list, most);
  }
  keep_hardest(events.list, most);
  std::ranges::stable_sort(events.list, {}, &Event::t);
  return events;
}

std::vector<double> hardest(const Events& events, std::size_t most) {
  auto list = events.list;
  keep_hardest(list, most);
  std::vector<double> times;
  for (const auto& e : list) times.push_back(e.t);
  std::ranges::sort(times);
  return times;
}

nlohmann::json to_json(const Events& events) {
  std::vector<double> t, approach, impulse, duration;
  std::vector<std::size_t> joint;
  std::vector<int> kind;
  for (const auto& e : events.list) {
    t.push_back(e.t), approach.push_back(e.approach), impulse.push_back(e.impulse);
    duration.push_back(e.duration), joint.push_back(e.joint), kind.push_back(e.kind);
  }
  return {{"joints", events.joints},   {"kinds", events.kinds},    {"all", events.all},
          {"t", numbers(t, 10)},       {"joint", joint},           {"kind", kind},
          {"v", numbers(approach, 5)}, {"p", numbers(impulse, 5)}, {"d", numbers(duration, 5)}};
}

namespace {

using nlohmann::json;

constexpr long fewest = 60, greatest = 4000;  // limits of the number of values per curve

json curves_of(const std::string& file, long rows, const std::vector<std::string>& names,
               const Thinning& table) {
  json out = {{"file", file}, {"rows", rows}, {"t", numbers(table.t(), 8)}, {"columns", json::array()}};
  for (std::size_t k = 0; k < names.size(); ++k)
    out["columns"].push_back(
        {{"name", names[k]}, {"unit", plots::unit_of_column(names[k])}, {"y", numbers(table.column(k), 5)}});
  return out;
}

long rows_of(const std::filesystem::path& file) {
  LineReader lines(file);
  std::string line;
  long count = -1;  // does not count the header
  while (lines.next(line)) ++count;
  return count;
}

json table(const std::filesystem::path& file, long most) {
  plots::Rows rows(file);
  const auto t = rows.place("t");
  std::vector<std::string> names;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < rows.names().size(); ++i)
    if (i != t) names.push_back(rows.names()[i]), places.push_back(i);
  const long count = rows_of(file);
  Thinning thinned(count, names.size(), most);
  std::vector<double> values(names.size());
  while (rows.next()) {
    for (std::size_t k = 0; k < names.size(); ++k) values[k] = rows.maybe_number(places[k]);
    thinned.take(rows.number(t), values);
  }
  thinned.finish();
  return curves_of(file.filename().string(), count, names, thinned);
}

/// Number of samples of each channel, in the order of the file.
std::vector<std::pair<std::string, long>> channels_in(const std::filesystem::path& file) {
  std::vector<std::pair<std::string, long>> list;
  plots::Rows rows(file);
  const auto channel = rows.place("channel");
  while (rows.next()) {
    const auto& name = rows.name(channel);
    const auto it = std::ranges::find(list, name, [](const auto& c) { return c.first; });
    if (it == list.end())
      list.emplace_back(name, 1);
    else
      ++it->second;
  }
  return list;
}

void signals(const std::filesystem::path& file, long most, json& out) {
  const auto channels = channels_in(file);
  std::map<std::string, Thinning, std::less<>> tables;
  for (const auto& [name, count] : channels) tables.emplace(name, Thinning(count, 1, most));
  plots::Rows rows(file);
  const auto channel = rows.place("channel"), t = rows.place("t"), value = rows.place("value");
  while (rows.next()) {
    const double y = rows.maybe_number(value);
    tables.find(rows.name(channel))->second.take(rows.number(t), {&y, 1});
  }
  const plots::RunColumns columns(file.parent_path());
  for (const auto& [name, count] : channels) {
    auto& thinned = tables.find(name)->second;
    thinned.finish();
    out.push_back(curves_of("signals.csv", count, {name}, thinned));
    if (const auto* column = columns.find(name)) out.back()["columns"][0]["unit"] = column->unit;
  }
}

}  // namespace

json curves(const std::filesystem::path& folder, long most) {
  std::size_t columns = 0;
  for (const char* name : {"trajectory.csv", "forces.csv"})
    if (std::filesystem::exists(folder / name)) columns += plots::Rows(folder / name).names().size();
  const bool sampled = std::filesystem::exists(folder / "signals.csv");
  if (sampled) columns += channels_in(folder / "signals.csv").size();
  const long each = std::clamp(most / static_cast<long>(columns + 1), fewest, greatest);
  auto out = json::array();
  if (sampled) signals(folder / "signals.csv", each, out);
  for (const char* name : {"trajectory.csv", "forces.csv"})
    if (std::filesystem::exists(folder / name)) out.push_back(table(folder / name, each));
  return out;
}

namespace {

using plots::ClearanceJoint;

/// Columns that are read from the same row for each frame: their names, indices and values.
struct Series {
  std::vector<std::string> names = {};
  std::vector<std::size_t> places = {};
  std::vector<std::vector<double>> values = {};

  void find(const plots::Rows& rows) {
    for (const auto& name : names) places.push_back(rows.place(name));
    values.resize(names.size());
  }
  void take(const plots::Rows& rows) {
    for (std::size_t i = 0; i < places.size(); ++i) values[i].push_back(rows.number(places[i]));
  }
};

/// Joints, contacts and loads with a force at the instants of the rows (not only means) in a table
/// of forces.
std::vector<std::string> forces_in(const plots::Rows& rows) {
  std::vector<std::string> list;
  for (const auto& name : rows.names())
    if (name.ends_with(".fx") && rows.has(name.substr(0, name.size() - 1) + 'y'))
      list.push_back(name.substr(0, name.size() - 3));
  return list;
}

constexpr std::array guide_walls{".rear_lower", ".rear_upper", ".front_lower", ".front_upper"};
constexpr std::array slot_walls{".right", ".left"};

std::vector<std::string> columns_of(const ClearanceJoint& joint) {
  std::vector<std::string> list;
  if (joint.kind == ClearanceJoint::Kind::journal)
    for (const char* part : {".ex", ".ey", ".gap"}) list.push_back(joint.name + part);
  if (joint.kind == ClearanceJoint::Kind::guide)
    for (const char* wall : guide_walls) list.push_back(joint.name + wall + ".gap");
  if (joint.kind == ClearanceJoint::Kind::slot)
    for (const char* wall : slot_walls) list.push_back(joint.name + wall + ".gap");
  return list;
}

/// The numbers of the selected rows.
struct Choice {
  long rows = 0, each = 1;
  std::vector<long> beside;  ///< rows beside events, in order; may repeat
};

Choice choose(const std::filesystem::path& file, long most, const std::vector<double>& times) {
  Choice choice;
  plots::Rows rows(file);
  const auto t = rows.place("t");
  std::size_t next = 0;
  for (; rows.next(); ++choice.rows)
    for (const double now = rows.number(t); next < times.size() && times[next] < now; ++next) {
      choice.beside.push_back(choice.rows - 1);
      choice.beside.push_back(choice.rows);
    }
  choice.each = std::max(1L, (choice.rows + most - 1) / most);
  return choice;
}

const char* kind_of(const ClearanceJoint& joint) {
  return joint.kind == ClearanceJoint::Kind::journal ? "journal"
         : joint.kind == ClearanceJoint::Kind::guide ? "guide"
                                                     : "slot";
}

/// The lines of beams. Bodies are indices into `bodies`, −1: ground.
json beams_of(const Mechanism& mechanism, const std::vector<std::string>& bodies) {
  const auto shown = [&](int body) {
    if (body < 0) return -1;
    const auto it = std::ranges::find(bodies, mechanism.bodies[static_cast<std::size_t>(body)].name);
    return it == bodies.end() ? -2 : static_cast<int>(it - bodies.begin());
  };
  auto list = json::array();
  for (const auto& line : beam_lines(mechanism)) {
    auto points = json::array();
    bool complete = true;
    for (const auto& p : line.points) {
      const int first = shown(p.bodies[0]), second = shown(p.bodies[1]);
      complete = complete && first > -2 && second > -2;
      points.push_back({first, rounded(p.at[0].x(), 7), rounded(p.at[0].y(), 7), second,
                        rounded(p.at[1].x(), 7), rounded(p.at[1].y(), 7), rounded(p.share, 7),
                        rounded(p.unloaded.x(), 7), rounded(p.unloaded.y(), 7)});
    }
    if (complete) list.push_back({{"name", line.name}, {"points", std::move(points)}});
  }
  return list;
}

/// [kind, name, body, x, y, other, a, b] of each shape, in the frame of its body. Bodies are
/// indices into `bodies`, −1: ground.
json shapes_of(const Scene& scene, const std::vector<std::string>& bodies, const Series& poses) {
  const auto& known = scene.mechanism.bodies;
  std::vector<int> place(known.size(), -1);
  std::vector<double> q(3 * known.size(), 0.0);
  for (std::size_t b = 0; b < known.size(); ++b)
    for (std::size_t k = 0; k < bodies.size(); ++k)
      if (bodies[k] == known[b].name) {
        place[b] = static_cast<int>(k);
        for (std::size_t i = 0; i < 3; ++i) q[3 * b + i] = poses.values[3 * k + i].front();
      }
  const auto turned = [&](int body, double x, double y) {
    if (body < 0) return Vec2{x, y};
    const double angle = q[3 * static_cast<std::size_t>(body) + 2], c = std::cos(angle), s = std::sin(angle);
    return Vec2{c * x + s * y, c * y - s * x};
  };
  const auto local = [&](int body, const Vec2& p) {
    if (body < 0) return p;
    const auto b = static_cast<std::size_t>(body);
    return turned(body, p.x() - q[3 * b], p.y() - q[3 * b + 1]);
  };
  const auto shown = [&](int body) { return body < 0 ? -1 : place[static_cast<std::size_t>(body)]; };
  auto list = json::array();
  for (const auto& s : pose_shapes(scene, q)) {
    if (s.kind == "beam") continue;  // see beams_of()
    if ((s.body >= 0 && shown(s.body) < 0) || (s.other >= 0 && shown(s.other) < 0)) continue;
    const bool point = s.kind == "line" || s.kind == "spring" || is_surface(s.kind),
               along = s.kind == "slider" || s.kind == "wall";
    const auto p = local(s.body, s.at);
    const auto more = point   ? local(s.other, s.more)
                      : along ? turned(s.other, s.more.x(), s.more.y())
                              : s.more;
    list.push_back({s.kind, s.name, shown(s.body), rounded(p.x(), 7), rounded(p.y(), 7), shown(s.other),
                    rounded(more.x(), 7), rounded(more.y(), 7)});
  }
  return list;
}

}  // namespace

long numbers_of_frame(const std::filesystem::path& folder, const Scene* scene) {
  const plots::Rows rows(folder / "trajectory.csv");
  std::size_t count = 1 + 3 * plots::bodies_in(rows).size();
  for (const auto& joint : plots::clearance_joints(folder, scene)) count += columns_of(joint).size();
  if (std::filesystem::exists(folder / "forces.csv"))
    count += 2 * forces_in(plots::Rows(folder / "forces.csv")).size();
  return static_cast<long>(count);
}

json motion(const std::filesystem::path& folder, const Scene* scene, long most,
            const std::vector<double>& times) {
  const auto file = folder / "trajectory.csv";
  const auto choice = choose(file, most, times);
  const auto clearance_joint = plots::clearance_joints(folder, scene);
  plots::Rows rows(file);
  const auto bodies = plots::bodies_in(rows);
  Series poses, play, arrows;
  for (const auto& body : bodies)
    for (const char* part : {".x", ".y", ".theta"}) poses.names.push_back(body + part);
  for (const auto& joint : clearance_joint)
    for (const auto& column : columns_of(joint)) play.names.push_back(column);
  const auto t = rows.place("t");
  poses.find(rows), play.find(rows);
  std::optional<plots::Rows> forces;
  std::vector<std::string> pushed;
  if (std::filesystem::exists(folder / "forces.csv")) {
    forces.emplace(folder / "forces.csv");
    pushed = forces_in(*forces);
    for (const auto& name : pushed)
      for (const char* part : {".fx", ".fy"}) arrows.names.push_back(name + part);
    arrows.find(*forces);
  }
  std::vector<double> instants;
  std::size_t beside = 0;
  for (long row = 0; rows.next(); ++row) {
    if (forces && !forces->next())
      throw SceneError((folder / "forces.csv").string() + ": has fewer rows than trajectory.csv");
    bool shown = row % choice.each == 0 || row == choice.rows - 1;
    for (; beside < choice.beside.size() && choice.beside[beside] <= row; ++beside)
      shown = shown || choice.beside[beside] == row;
    if (!shown) continue;
    instants.push_back(rows.number(t));
    poses.take(rows), play.take(rows);
    if (forces) arrows.take(*forces);
  }

  json out = {{"rows", choice.rows}, {"t", numbers(instants, 10)}, {"bodies", bodies}};
  const auto columns = [](const Series& series, std::size_t from, std::size_t count, int digits) {
    auto list = json::array();
    for (std::size_t i = from; i < from + count; ++i) list.push_back(numbers(series.values[i], digits));
    return list;
  };
  out["poses"] = columns(poses, 0, poses.names.size(), 7);
  out["loose"] = json::array();
  std::size_t at = 0;
  for (const auto& joint : clearance_joint) {
    const auto count = columns_of(joint).size();
    out["loose"].push_back({{"name", joint.name},
                            {"kind", kind_of(joint)},
                            {"frame", joint.frame},
                            {"axis", {joint.axis[0], joint.axis[1]}},
                            {"columns", columns(play, at, count, 6)}});
    at += count;
  }
  out["arrows"] = json::array();
  for (std::size_t i = 0; i < pushed.size(); ++i)
    out["arrows"].push_back({{"name", pushed[i]}, {"columns", columns(arrows, 2 * i, 2, 4)}});
  out["beams"] = scene ? beams_of(scene->mechanism, bodies) : json::array();
  out["shapes"] = scene && !instants.empty() ? shapes_of(*scene, bodies, poses) : json::array();
  return out;
}

}  // namespace freeplay::report

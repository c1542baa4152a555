#include "plots/report/motion.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/scene/pose_file.hpp"
#include "mechanism/scene.hpp"
#include "plots/report/thinning.hpp"
#include "plots/tables/clearance_joints.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;
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

std::vector<std::string> bodies_in(const plots::Rows& rows) {
  std::vector<std::string> list;
  for (const auto& name : rows.names())
    if (name.ends_with(".omega")) list.push_back(name.substr(0, name.size() - 6));
  return list;
}

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
    if ((s.body >= 0 && shown(s.body) < 0) || (s.other >= 0 && shown(s.other) < 0)) continue;
    const bool point = s.kind == "line" || s.kind == "spring", along = s.kind == "slider" || s.kind == "wall";
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
  std::size_t count = 1 + 3 * bodies_in(rows).size();
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
  const auto bodies = bodies_in(rows);
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
  out["shapes"] = scene && !instants.empty() ? shapes_of(*scene, bodies, poses) : json::array();
  return out;
}

}  // namespace freeplay::report

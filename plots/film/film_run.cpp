#include "plots/film/film_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/scene/bearing_line.hpp"
#include "mechanism/scene.hpp"
#include "plots/report/run_data.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;

Column column_of(const json& list) {
  Column column;
  column.reserve(list.size());
  for (const auto& x : list)
    column.push_back(x.is_number() ? x.get<double>() : std::numeric_limits<double>::quiet_NaN());
  return column;
}

std::vector<Column> columns_of(const json& list) {
  std::vector<Column> columns;
  for (const auto& one : list) columns.push_back(column_of(one));
  return columns;
}

/// Shapes from rows [kind, name, body, x, y, other, a, b]. The corners of one link, outline, bearing or
/// journal make one shape.
std::vector<FilmShape> shapes_of(const json& list) {
  std::vector<FilmShape> shapes;
  for (const auto& s : list) {
    FilmShape shape{s[0],
                    s[1],
                    s[2],
                    s[5],
                    {{s[3].get<double>(), s[4].get<double>()}},
                    {s[6].get<double>(), s[7].get<double>()}};
    if (is_surface(shape.kind)) shape.nominal.push_back(shape.more);
    const bool corners = shape.kind == "link" || shape.kind == "outline" || is_surface(shape.kind);
    if (auto* before = shapes.empty() ? nullptr : &shapes.back();
        corners && before && before->kind == shape.kind && before->name == shape.name &&
        before->body == shape.body) {
      before->points.push_back(shape.points.front());
      if (is_surface(shape.kind)) before->nominal.push_back(shape.more);
    } else {
      shapes.push_back(std::move(shape));
    }
  }
  return shapes;
}

/// Lines from the rows of `beams` (run_data.hpp).
std::vector<BeamLine> beams_of(const json& list) {
  std::vector<BeamLine> beams;
  for (const auto& one : list) {
    beams.push_back({one["name"], {}});
    for (const auto& p : one["points"])
      beams.back().points.push_back(
          {{p[0], p[3]},
           {Vec2{p[1].get<double>(), p[2].get<double>()}, Vec2{p[4].get<double>(), p[5].get<double>()}},
           p[6],
           {p[7].get<double>(), p[8].get<double>()}});
  }
  return beams;
}

double clearance_of(const FilmClearance& joint) {
  const auto first = [&](std::size_t k) { return joint.columns[k].front(); };
  return joint.kind == "journal" ? first(2) + std::hypot(first(0), first(1)) : 0.5 * (first(0) + first(1));
}

/// The force that 1 in 50 values exceed. It scales the arrows, so that single peaks do not shorten
/// all others.
double usual(const std::vector<FilmForce>& forces) {
  Column sizes;
  for (const auto& f : forces)
    for (std::size_t i = 0; i < f.fx.size(); ++i)
      if (const double size = std::hypot(f.fx[i], f.fy[i]); size > 0) sizes.push_back(size);
  if (sizes.empty()) return 0;
  const auto place =
      sizes.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(sizes.size() - 1));
  std::ranges::nth_element(sizes, place);
  return *place;
}

std::pair<int, int> crank_of(const Scene& scene, const std::vector<std::string>& bodies) {
  const int joint = crank_joint(scene.mechanism);
  if (joint < 0) return {-1, -1};
  const auto* pin = std::get_if<RevoluteJoint>(&scene.mechanism.joints[joint]);
  if (!pin) return {-1, -1};
  const auto shown = [&](int body) {
    if (body == ground) return -1;
    return static_cast<int>(
        std::ranges::find(bodies, scene.mechanism.bodies[static_cast<std::size_t>(body)].name) -
        bodies.begin());
  };
  const std::pair<int, int> crank{shown(pin->between[0]), shown(pin->between[1])};
  const auto known = [&](int body) { return body < static_cast<int>(bodies.size()); };
  return known(crank.first) && known(crank.second) ? crank : std::pair{-1, -1};
}

}  // namespace

double between(const Column& column, const At& at) {
  return at.part > 0 ? column[at.i] + at.part * (column[at.i + 1] - column[at.i]) : column[at.i];
}

At FilmRun::at(double now) const {
  const auto after = std::ranges::upper_bound(t, now);
  if (after == t.begin()) return {};
  const auto i = static_cast<std::size_t>(after - t.begin()) - 1;
  if (after == t.end()) return {i, 0};
  return {i, (now - t[i]) / (t[i + 1] - t[i])};
}

Pose FilmRun::pose(int body, const At& now) const {
  if (body < 0) return {};
  const auto* columns = &poses[3 * static_cast<std::size_t>(body)];
  const double theta = between(columns[2], now);
  return {{between(columns[0], now), between(columns[1], now)}, std::cos(theta), std::sin(theta)};
}

double FilmRun::crank_angle(const At& now) const {
  const auto theta = [&](int body) {
    return body < 0 ? 0.0 : between(poses[3 * static_cast<std::size_t>(body) + 2], now);
  };
  return theta(crank.second) - theta(crank.first);
}

std::vector<Vec2> FilmRun::line(const BeamLine& beam, const At& now, double magnify) const {
  std::vector<Vec2> list;
  for (const auto& p : drawn(beam, [&](int body, const Vec2&at) { return pose(body, now).place(at); }))
    list.push_back(p.magnified(magnify));
  return list;
}

std::vector<Vec2> FilmRun::line(const FilmShape& surface, const At& now, double magnify) const {
  const auto placed = [&](int body, const std::vector<Vec2>& points) {
    const auto here = pose(body, now);
    std::vector<Vec2> list;
    for (const auto& p : points) list.push_back(here.place(p));
    return list;
  };
  const auto joint = std::ranges::find_if(
      shapes, [&](const FilmShape& s) { return s.kind == "loose" && s.name == surface.name; });
  const SurfaceLine line{placed(surface.body, surface.points), placed(surface.body, surface.nominal)};
  return joint == shapes.end() ? line.points
                               : line.magnified(magnify, pose(joint->body, now).place(joint->points.front()));
}

bool FilmRun::has_surfaces() const {
  return std::ranges::any_of(shapes, [](const FilmShape& s) { return is_surface(s.kind); });
}

std::vector<double> FilmRun::play(const FilmClearance& joint, const At& now) const {
  const auto value = [&](std::size_t k) { return between(joint.columns[k], now); };
  if (joint.kind == "journal") return {value(0) / joint.clearance, value(1) / joint.clearance};
  std::vector<double> ends;
  for (std::size_t k = 0; k + 1 < joint.columns.size(); k += 2)
    ends.push_back((value(k) - value(k + 1)) / (value(k) + value(k + 1)));
  return ends;
}

std::vector<int> FilmRun::shapes_of(const std::string& name) const {
  const auto named = [&](const std::string& n) {
    std::vector<int> discs, others;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const auto& s = shapes[i];
      if (s.name != n || s.kind == "mass" || s.kind == "support" || s.kind == "link" || s.kind == "outline" ||
          is_surface(s.kind))
        continue;
      (s.kind == "disc" ? discs : others).push_back(static_cast<int>(i));
    }
    if (others.empty())
      return discs.size() <= 2 ? discs : std::vector<int>();  // with many discs the disc is unknown
    others.resize(1);
    return others;
  };
  auto found = named(name);
  return found.empty() ? named(name.substr(0, name.rfind('.'))) : found;  // guide of a guide corner
}

Vec2 FilmRun::acts_at(const std::vector<int>& list, const At& now) const {
  const auto& s = shapes[static_cast<std::size_t>(list.front())];
  const Vec2 p = pose(s.body, now).place(s.points.front());
  if (s.kind == "line") return 0.5 * (p + pose(s.other, now).place(s.more));
  if (list.size() < 2) return p;
  const auto& other = shapes[static_cast<std::size_t>(list.back())];
  const Vec2 q = pose(other.body, now).place(other.points.front()), d = q - p;
  if (d.is_zero()) return p;
  return s.more.x() >= other.more.x() ? p + s.more.x() * d.direction() : q - other.more.x() * d.direction();
}

FilmRun film_run(const plots::RunFolder& folder, long frames) {
  const auto scene = plots::scene_of_run(folder.folder);
  FilmRun run;
  run.title = folder.title;
  run.events = read_events(folder.folder, 20'000);
  const auto data =
      motion(folder.folder, scene.get(), frames, hardest(run.events, static_cast<std::size_t>(frames / 4)));
  run.t = column_of(data["t"]);
  if (run.t.empty())
    throw SceneError((folder.folder / "trajectory.csv").string() + ": has no rows to animate");
  run.bodies = data["bodies"].get<std::vector<std::string>>();
  run.poses = columns_of(data["poses"]);
  run.shapes = shapes_of(data["shapes"]);
  run.beams = beams_of(data["beams"]);
  if (run.shapes.empty())  // the scene cannot be read: centres of the bodies
    for (std::size_t b = 0; b < run.bodies.size(); ++b)
      run.shapes.push_back({"mass", run.bodies[b], static_cast<int>(b), -1, {{0, 0}}, {0, 0}});
  for (const auto& joint : data["loose"]) {
    FilmClearance clearance_joint{joint["name"], joint["kind"], columns_of(joint["columns"]), 0};
    clearance_joint.clearance = clearance_of(clearance_joint);
    run.clearance_joint.push_back(std::move(clearance_joint));
  }
  for (const auto& force : data["arrows"]) {
    auto columns = columns_of(force["columns"]);
    const std::string name = force["name"];
    run.forces.push_back({name, std::move(columns[0]), std::move(columns[1]), run.shapes_of(name)});
  }
  run.usual_force = usual(run.forces);
  if (scene) run.crank = crank_of(*scene, run.bodies);
  return run;
}

}  // namespace freeplay::report

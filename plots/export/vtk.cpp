// The motion of a mechanism for ParaView: PolyData in VTK's XML text format, one file per frame.
// The cells are the shapes of the pose (io/scene/pose_file.hpp): points, links as lines through
// their corners, discs and bearings as circles.
//
//     CellData   shape, name    indices into the lists of texts shapes and names in the file
//     FieldData  TimeValue      s
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "dynamics/planar.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/scene/bearing_line.hpp"
#include "io/scene/pose_file.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/export/export.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay {
namespace {

using Path = std::filesystem::path;
using plots::Rows;

constexpr int circle_corners = 48;

/// Points and cells with their data.
struct Drawing {
  std::vector<Vec2> points;
  struct Cell {
    std::size_t first, count;  ///< range of points
    bool closed;
    std::size_t shape, name;
  };
  std::vector<Cell> verts, lines;
  std::vector<std::string> shapes, names;

  void add(std::vector<Cell>& cells, const PoseShape& of, const std::vector<Vec2>& corners, bool closed) {
    cells.push_back({points.size(), corners.size(), closed, plots::place_in(shapes, of.kind),
                     plots::place_in(names, of.name)});
    points.insert(points.end(), corners.begin(), corners.end());
  }
};

std::vector<Vec2> circle(const Vec2& middle, double radius) {
  std::vector<Vec2> corners;
  for (int i = 0; i < circle_corners; ++i) {
    const double phi = 2 * std::numbers::pi * i / circle_corners;
    corners.push_back(middle + radius * Vec2{std::cos(phi), std::sin(phi)});
  }
  return corners;
}

/// Half the diagonal of the bounding box of all positions.
double extent(const std::vector<PoseShape>& shapes) {
  constexpr double far = std::numeric_limits<double>::infinity();
  double low[] = {far, far}, high[] = {-far, -far};
  for (const auto& s : shapes)
    for (const int i : {0, 1}) {
      const double x = i == 0 ? s.at.x() : s.at.y();
      low[i] = std::min(low[i], x), high[i] = std::max(high[i], x);
    }
  return shapes.empty() ? 0 : 0.5 * std::hypot(high[0] - low[0], high[1] - low[1]);
}

/// `size` (m, the same in all frames): length of shapes that have a direction but no length.
Drawing drawn(const std::vector<PoseShape>& shapes, double size) {
  Drawing d;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto& s = shapes[i];
    if (s.kind == "link" || s.kind == "outline" || s.kind == "beam" ||
        is_surface(s.kind)) {  // consecutive rows make one line
      std::vector<Vec2> corners{s.at};
      while (i + 1 < shapes.size() && shapes[i + 1].kind == s.kind && shapes[i + 1].name == s.name)
        corners.push_back(shapes[++i].at);
      d.add(d.lines, s, corners, false);  // closed lines repeat their first point
    } else if ((s.kind == "disc" || s.kind == "loose") && s.more.x() > 0) {
      d.add(d.lines, s, circle(s.at, s.more.x()), true);
    } else if (s.kind == "slider" || s.kind == "wall") {
      const auto half = (s.kind == "wall" ? 1.0 : 0.15) * size * s.more;
      d.add(d.lines, s, {s.at - half, s.at + half}, false);
    } else if (s.kind == "line" || s.kind == "spring") {
      d.add(d.lines, s, {s.at, s.more}, false);
    } else {
      d.add(d.verts, s, {s.at}, false);
    }
  }
  return d;
}

/// The text of one frame.
class Frame {
 public:
  Frame(const Drawing& d, double t) : d_(d) {
    put("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
        "byte_order=\"LittleEndian\">\n<PolyData>\n");
    put("<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
        "format=\"ascii\">{}</DataArray>\n",
        t);
    words("shapes", d.shapes);
    words("names", d.names);
    put("</FieldData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" "
        "NumberOfStrips=\"0\" "
        "NumberOfPolys=\"0\">\n",
        d.points.size(), d.verts.size(), d.lines.size());
    put("<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n");
    for (const auto& p : d.points) put("{} {} 0\n", p.x(), p.y());
    put("</DataArray>\n</Points>\n");
    cells("Verts", d.verts);
    cells("Lines", d.lines);
    put("<CellData>\n");
    indices("shape", &Drawing::Cell::shape);
    indices("name", &Drawing::Cell::name);
    put("</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n");
  }
  const std::string& text() const { return text_; }

 private:
  template <class... X>
  void put(fmt::format_string<X...> form, X&&... x) {
    fmt::format_to(std::back_inserter(text_), form, std::forward<X>(x)...);
  }
  /// VTK writes texts as the numbers of their bytes, terminated by a zero, so that they contain no
  /// markup.
  void words(const char* name, const std::vector<std::string>& list) {
    put("<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"ascii\">\n", name, list.size());
    for (const auto& word : list) {
      for (const char c : word) put("{} ", static_cast<unsigned char>(c));
      put("0\n");
    }
    put("</Array>\n");
  }
  void cells(const char* name, const std::vector<Drawing::Cell>& list) {
    put("<{}>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n", name);
    for (const auto& cell : list) {
      for (std::size_t i = 0; i < cell.count; ++i) put("{} ", cell.first + i);
      if (cell.closed) put("{}", cell.first);
      put("\n");
    }
    put("</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n");
    std::size_t end = 0;
    for (const auto& cell : list) put("{} ", end += cell.count + (cell.closed ? 1 : 0));
    put("\n</DataArray>\n</{}>\n", name);
  }
  void indices(const char* name, std::size_t Drawing::Cell::*member) {
    put("<DataArray type=\"Int32\" Name=\"{}\" format=\"ascii\">\n", name);
    for (const auto* list : {&d_.verts, &d_.lines})
      for (const auto& cell : *list) put("{} ", cell.*member);
    put("\n</DataArray>\n");
  }

  const Drawing& d_;
  std::string text_;
};

/// Indices of the columns of trajectory.csv with the coordinates of all bodies.
std::vector<std::size_t> places_of(const Rows& rows, const Mechanism& m) {
  std::vector<std::size_t> places;
  for (std::size_t b = 0; b < m.bodies.size(); ++b)
    for (const auto* name : planar::names) places.push_back(rows.place(m.bodies[b].name + "." + name));
  return places;
}

/// More are refused with the advice to take fewer rows or images per second.
constexpr std::size_t most_frames = 20'000;

/// Number of frames. An additional pass over the trajectory finds it before any file is written.
std::size_t frames_of(const Path& trajectory, int every, const StopToken& stop) {
  Rows rows(trajectory);
  std::size_t count = 0;
  for (; rows.next(); ++count)
    if (count % 4096 == 0 && stop()) throw Interrupted();
  const auto step = static_cast<std::size_t>(every);
  const auto frames = (count + step - 1) / step;
  if (frames > most_frames)
    throw SceneError(
        fmt::format("--vtk: {} rows of {} would be {} files, more than {}: use --every {} or more", count,
                    trajectory.string(), frames, most_frames, (count + most_frames - 1) / most_frames));
  return frames;
}

}  // namespace

Exported export_vtk(const Path& folder, const Path& place, int every, StopToken stop) {
  const auto trajectory = folder / "trajectory.csv";
  if (!std::filesystem::exists(folder / "run.json") || !std::filesystem::exists(trajectory))
    throw SceneError(
        folder.string() + ": --vtk: contains no run; give the folder of one run" +
        (std::filesystem::exists(folder / "comparison.json") ? ", such as its penalty or nonsmooth" : ""));
  const auto scene = plots::scene_of_run(folder);
  if (!scene) throw SceneError((folder / "run.json").string() + ": has no scene that this version can read");
  const auto frames = frames_of(trajectory, every, stop);
  Rows rows(trajectory);
  const auto time = rows.place("t");
  const auto places = places_of(rows, scene->mechanism);
  ResultSet set(place, "export");
  OutputFile series(set.place() / "mechanism.pvd");
  series.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n");
  State state;
  state.q.resize(places.size());
  double size = -1;
  std::size_t frame = 0;
  for (std::size_t row = 0; rows.next(); ++row) {
    if (row % static_cast<std::size_t>(every) != 0) continue;
    if (stop()) throw Interrupted();
    for (std::size_t i = 0; i < places.size(); ++i) state.q[i] = rows.number(places[i]);
    const auto shapes = pose_shapes(*scene, state.q);
    if (size < 0) size = extent(shapes);
    const auto name = fmt::format("frame_{:06}.vtp", frame++);
    write_file(set.place() / name, Frame(drawn(shapes, size), rows.number(time)).text());
    series.write(fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", rows.number(time), name));
  }
  if (frame != frames)
    throw SceneError(trajectory.string() +
                     ": changed while it was read; export it when no other process writes there");
  series.write("</Collection>\n</VTKFile>\n");
  series.commit();
  set.commit();
  return {0, frames};
}

}  // namespace freeplay

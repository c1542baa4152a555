// Orbit of the journal's centre inside the clearance circle, in units of the clearance, for both formulations
// side by side: the last two revolutions (without a drive, the last tenth of the time).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/input_file.hpp"
#include "plots/figure.hpp"
#include "plots/table.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_joints = 12;

struct Span {
  double from, to;
  const char* name;
};

/// The journals in bearings of a trajectory, the first of too many. Of these alone gap and eccentricity add up to the same
/// in all rows; walls, teeth and stops have no circle to be drawn in.
std::vector<std::string> joints_of(const std::filesystem::path& file) {
  Rows rows(file);
  struct Contact {
    std::string name;
    std::size_t x, y, gap;
    double least = INFINITY, most = -INFINITY;
  };
  std::vector<Contact> all;
  for (const auto& name : rows.names())
    if (name.ends_with(".gap")) {
      const auto joint = name.substr(0, name.size() - 4);
      all.push_back({joint, rows.place(joint + ".ex"), rows.place(joint + ".ey"), rows.place(name)});
    }
  long seen = 0;
  for (; !all.empty() && seen < 5000 && rows.next(); ++seen)
    for (auto& c : all) {
      const double sum = rows.number(c.gap) + std::hypot(rows.number(c.x), rows.number(c.y));
      c.least = std::min(c.least, sum);
      c.most = std::max(c.most, sum);
    }
  std::vector<std::string> joints;
  for (const auto& c : all)
    if (seen > 1 && c.most - c.least <= 1e-9 * c.most && joints.size() < most_joints)
      joints.push_back(c.name);
  return joints;
}

/// Of each joint its orbit in each span. The clearance is the gap plus the eccentricity, in any row.
std::vector<Block> orbits(const std::filesystem::path& file, const std::vector<std::string>& joints,
                          const Span (&spans)[2]) {
  Rows rows(file);
  const auto t = rows.place("t");
  struct Place {
    std::size_t x, y, gap;
  };
  std::vector<Place> places;
  std::vector<Block> blocks;
  for (const auto& joint : joints) {
    places.push_back({rows.place(joint + ".ex"), rows.place(joint + ".ey"), rows.place(joint + ".gap")});
    for (std::size_t k = 0; k < std::size(spans); ++k) blocks.emplace_back(joint + ": e_x/c, e_y/c");
  }
  while (rows.next()) {
    const double time = rows.number(t);
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const double x = rows.number(places[j].x), y = rows.number(places[j].y);
      const double c = rows.number(places[j].gap) + std::hypot(x, y);
      for (std::size_t k = 0; k < std::size(spans); ++k)
        if (time >= spans[k].from && time <= spans[k].to) blocks[2 * j + k].row({x / c, y / c});
    }
  }
  return blocks;
}

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const auto trajectory = [&](const char* run) { return folder / run / "trajectory.csv"; };
  const auto joints = joints_of(trajectory("penalty"));
  if (joints.empty()) return {};

  const JsonFile comparison(folder / "comparison.json");
  const double counted = comparison.number("penalty.revolutions_counted");
  const double end = comparison.number("provenance.options.run.duration"),
               discard = comparison.number("provenance.options.run.discard");
  const double turn = counted > 0 ? (end - discard) / counted : 0.1 * end;
  const Span spans[] = {{0, std::min(turn, end), counted > 0 ? "first revolution" : "first tenth"},
                        {std::max(0.0, end - (counted > 0 ? 2 : 1) * turn), end,
                         counted > 0 ? "last two revolutions" : "last tenth"}};
  const char* const runs[] = {"penalty", "nonsmooth"};
  const std::vector<Block> drawn[] = {orbits(trajectory(runs[0]), joints, spans),
                                      orbits(trajectory(runs[1]), joints, spans)};

  Figure f{.name = "journal_orbit", .width_cm = 16, .source = "comparison.json"};
  const double rows = 2.0 * static_cast<double>(joints.size());
  f.height_cm = 8.2 * rows;
  f.script.add(
      "set multiplot layout {},2 margins 0.08,0.98,{:.3f},{:.3f} spacing 0.1,{:.3f}\nset size ratio -1\nset "
      "xrange [-1.15:1.15]\nset yrange [-1.15:1.15]\nset xtics 0.5\nset ytics 0.5\nset parametric\nset "
      "trange [0:2*pi]\nset samples 400\nset xlabel 'e_x / c' offset 0,0.5\nset ylabel 'e_y / c' offset "
      "1\nunset key\nset title offset 0,-0.5\n",
      rows, 0.14 / rows, 1 - 0.07 / rows, 0.24 / rows);
  for (std::size_t j = 0; j < joints.size(); ++j)
    for (std::size_t k = 0; k < std::size(spans); ++k)
      for (const std::size_t run : {0, 1}) {
        const auto index = f.blocks.size();
        f.blocks.push_back(drawn[run][2 * j + k]);
        f.script.add(
            "set title {} noenhanced\nplot cos(t),sin(t) with lines ls 4, DATA index {} using "
            "1:2 with lines ls {} lw 0.8 dt 1\n{}",
            fmt::format("{}, {}: {}", joints[j], runs[run], spans[k].name), index, run + 1,
            index == 0 ? Word("unset label 100\n") : Word(""));
      }
  f.script.add("unset multiplot\n");
  return {draw(f, folder)};
}

}  // namespace

const Drawing journal_orbit{{"comparison.json"}, draw_all};

}  // namespace freeplay::plots

// Orbit of the journal's centre inside the clearance circle, in units of the clearance, for both formulations
// side by side: the last two revolutions (without a drive, the last tenth of the time).
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

/// The clearance is the gap plus the eccentricity, in any row.
std::string orbit(const Csv& csv, const std::string& joint, double from, double to) {
  const auto t = csv.column("t"), x = csv.column(joint + ".ex"), y = csv.column(joint + ".ey"),
             gap = csv.column(joint + ".gap");
  std::string block = "# " + joint + ": e_x/c, e_y/c\n";
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double c = gap[i] + std::hypot(x[i], y[i]);
    if (t[i] >= from && t[i] <= to) block += fmt::format("{} {}\n", x[i] / c, y[i] / c);
  }
  return block;
}

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  std::vector<std::string> joints;
  const Csv penalty(folder / "penalty" / "trajectory.csv"),
      nonsmooth(folder / "nonsmooth" / "trajectory.csv");
  for (const auto& name : penalty.names())
    if (name.ends_with(".gap")) joints.push_back(name.substr(0, name.size() - 4));
  if (joints.empty() || penalty.rows() < 2) return {};

  std::ifstream in(folder / "comparison.json");
  const auto document = nlohmann::json::parse(in);
  const double counted = document.at("penalty").at("revolutions_counted");
  const auto& asked = document.at("provenance").at("options").at("run");
  const double end = asked.at("duration"), discard = asked.at("discard");
  const double turn = counted > 0 ? (end - discard) / counted : 0.1 * end;
  struct Span {
    double from, to;
    const char* name;
  };
  const Span spans[] = {{0, std::min(turn, end), counted > 0 ? "first revolution" : "first tenth"},
                        {std::max(0.0, end - (counted > 0 ? 2 : 1) * turn), end,
                         counted > 0 ? "last two revolutions" : "last tenth"}};

  Figure f;
  f.name = "journal_orbit";
  f.source = "comparison.json";
  f.width_cm = 16;
  const double rows = 2.0 * static_cast<double>(joints.size());
  f.height_cm = 8.2 * rows;
  f.script = fmt::format(
      "set multiplot layout {},2 margins 0.08,0.98,{:.3f},{:.3f} spacing 0.1,{:.3f}\nset size ratio -1\nset "
      "xrange [-1.15:1.15]\nset yrange [-1.15:1.15]\nset xtics 0.5\nset ytics 0.5\nset parametric\nset "
      "trange [0:2*pi]\nset samples 400\nset xlabel 'e_x / c' offset 0,0.5\nset ylabel 'e_y / c' offset "
      "1\nunset key\nset title offset 0,-0.5\n",
      rows, 0.14 / rows, 1 - 0.07 / rows, 0.24 / rows);
  int index = 0;
  for (const auto& joint : joints)
    for (const auto& span : spans)
      for (int run : {1, 2}) {
        f.blocks.push_back(orbit(run == 1 ? penalty : nonsmooth, joint, span.from, span.to));
        f.script += fmt::format(
            "set title '{}, {}: {}' noenhanced\nplot cos(t),sin(t) with lines ls 4, 'DATA' index {} using "
            "1:2 with lines ls {} lw 0.8 dt 1\n{}",
            joint, run == 1 ? "penalty" : "nonsmooth", span.name, index, run,
            index == 0 ? "unset label 100\n" : "");
        ++index;
      }
  f.script += "unset multiplot\n";
  return {draw(f, folder)};
}

}  // namespace

const Drawing journal_orbit{{"comparison.json"}, draw_all};

}  // namespace freeplay::plots

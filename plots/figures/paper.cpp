// Figures 5 and 11 of Flores et al. 2011, from the last turns in traces.csv: position and
// acceleration of the slider with the ideal joint and with clearance; its velocity and acceleration
// for each clearance. The velocity is the difference quotient of the position signal,
//
//     v_i = (x_{i+1} − x_{i−1}) n/60 · 360/(φ_{i+1} − φ_{i−1}),    n: rpm, φ: degrees of the crank.
#include "plots/figures/paper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "mechanism/error.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// The last turn of a run: degrees, m, m/s, m/s².
struct LastTurn {
  std::vector<double> angle, position, velocity, acceleration;
};

/// Last turns at the speed of figures 5 and 11, by clearance (m) and formulation or "ideal".
struct Turns {
  double speed = 0;  ///< rpm
  std::map<double, std::map<std::string, LastTurn>> at;
};

double closest(const std::set<double>& values, double x) {
  return *std::ranges::min_element(values, {}, [x](double v) { return std::abs(v - x); });
}

Turns read_turns(const std::filesystem::path& folder, const std::string& variant) {
  const Table table(folder / "traces.csv", {"variant", "formulation"},
                    {"clearance", "speed", "angle", "acceleration", "position"});
  const auto &variants = table.text("variant"), &formulation = table.text("formulation");
  const auto &clearance = table.column("clearance"), &speed = table.column("speed"),
             &angle = table.column("angle"), &acceleration = table.column("acceleration"),
             &position = table.column("position");
  std::set<double> speeds;
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (variants[i] == variant) speeds.insert(speed[i]);
  if (speeds.empty())
    throw SceneError(fmt::format("{}: has no row of variant {}", (folder / "traces.csv").string(), variant));
  constexpr double speed_of_paper = 200;
  Turns turns{closest(speeds, speed_of_paper), {}};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (variants[i] != variant || speed[i] != turns.speed) continue;
    auto& turn = turns.at[clearance[i]][formulation[i]];
    turn.angle.push_back(angle[i]);
    turn.position.push_back(position[i]);
    turn.acceleration.push_back(acceleration[i]);
  }
  for (auto& [c, all] : turns.at)
    for (auto& [name, turn] : all)
      for (std::size_t i = 0; i < turn.angle.size(); ++i) {
        const auto before = i > 0 ? i - 1 : i, after = std::min(i + 1, turn.angle.size() - 1);
        const double degrees = turn.angle[after] - turn.angle[before];
        turn.velocity.push_back(degrees > 0 ? (turn.position[after] - turn.position[before]) * turns.speed /
                                                  60 * 360 / degrees
                                            : NAN);
      }
  return turns;
}

using Quantity = std::vector<double> LastTurn::*;

/// One panel: title, label of the ordinate, and the curves of these formulations.
void add_panel(Figure& f, const std::map<std::string, LastTurn>& turns, Quantity quantity,
               const Script& title, const Word& label, const std::vector<const char*>& names, bool keyed) {
  constexpr std::pair<std::string_view, int> styles[] = {{"ideal", 3}, {"penalty", 1}, {"nonsmooth", 2}};
  f.script.add("set title {} offset 0,-0.8\nset ylabel '{}'\n", title, label);
  Script plot;
  for (const char* name : names) {
    const auto it = turns.find(name);
    if (it == turns.end()) continue;
    Block block(fmt::format("{}: crank angle (degrees), value", name));
    for (std::size_t i = 0; i < it->second.angle.size(); ++i)
      block.row({it->second.angle[i], (it->second.*quantity)[i]});
    const auto* style = std::ranges::find(styles, name, &std::pair<std::string_view, int>::first);
    plot.add("{}DATA index {} using 1:2 with lines ls {} ", plot.empty() ? Word("plot ") : Word(", "),
             f.blocks.size(), style->second);
    if (keyed)
      plot.add("title {}", name);
    else
      plot.add("notitle");
    f.blocks.push_back(std::move(block));
  }
  f.script.add("{}\n", plot);
}

constexpr Word axes_of_angle = "set xrange [0:360]\nset xtics 90\nset xlabel 'Crank angle (°)'\n";
constexpr Word key_above_panel = "set key at graph 1,screen 1-Y(0.15) horizontal maxrows 1\n";
constexpr Word key_on_top = "set key at screen 1-X(0.4),1-Y(0.15) horizontal maxrows 1\n";

std::filesystem::path figure_5(const std::filesystem::path& folder, const Turns& turns,
                               const std::string& source) {
  Figure f{.name = "figure_05", .height_cm = 13, .source = source};
  std::set<double> clearances;
  for (const auto& [c, all] : turns.at) clearances.insert(c);
  constexpr double clearance_of_paper = 0.25e-3;
  const double c = closest(clearances, clearance_of_paper);
  const auto& here = turns.at.at(c);
  f.script.add("set multiplot layout 2,2 margins X(1.9),1-X(0.4),Y(1.5),1-Y(1.3) spacing X(2.1),Y(2)\n{}{}",
               axes_of_angle, key_above_panel);
  double least = INFINITY, most = -INFINITY;
  for (const auto& [name, turn] : here)
    for (const double x : turn.position) least = std::min(least, x), most = std::max(most, x);
  const auto positions = axis_of(least, most);
  f.script.add("set yrange [{:.6g}:{:.6g}]\n", positions.low, positions.high);
  const std::vector<const char*> ideal{"ideal"}, both{"penalty", "nonsmooth"};
  const auto loose = [&](const Word& letter) {
    return Script().add("'{} {:.2f} mm, {:.0f} rpm'", letter, 1e3 * c, turns.speed);
  };
  const auto tight = [&](const Word& letter) {
    return Script().add("'{} ideal joint, {:.0f} rpm'", letter, turns.speed);
  };
  add_panel(f, here, &LastTurn::position, tight("(a)"), "Position (m)", ideal, true);
  add_panel(f, here, &LastTurn::position, loose("(b)"), "Position (m)", both, true);
  f.script.add("unset key\nset yrange [*:*]\n");
  add_panel(f, here, &LastTurn::acceleration, tight("(c)"), "Acceleration (m/s²)", ideal, false);
  add_panel(f, here, &LastTurn::acceleration, loose("(d)"), "Acceleration (m/s²)", both, false);
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

std::filesystem::path figure_11(const std::filesystem::path& folder, const Turns& turns,
                                const std::string& source) {
  constexpr std::size_t most = 4;  // clearances
  constexpr Word letters_11[][2] = {{"(a)", "(b)"}, {"(c)", "(d)"}, {"(e)", "(f)"}, {"(g)", "(h)"}};
  const auto rows = std::min(turns.at.size(), most);
  Figure f{.name = "figure_11", .height_cm = 2.8 + 4.6 * static_cast<double>(rows), .source = source};
  f.script.add(
      "set multiplot layout {},2 margins X(1.9),1-X(0.4),Y(1.5),1-Y(1.3) spacing X(2.1),Y(1.1)\n{}{}set format "
      "x ''\nunset xlabel\n",
      rows, axes_of_angle, key_on_top);
  const std::vector<const char*> all{"ideal", "penalty", "nonsmooth"};
  std::size_t row = 0;
  for (const auto& [c, here] : turns.at) {
    if (row == rows) break;
    if (row + 1 == rows) f.script.add("set format x\nset xlabel 'Crank angle (°)'\n");
    const auto title = [&, c = c](int column) {
      return Script().add("'{} {:.2f} mm, {:.0f} rpm'", letters_11[row][column], 1e3 * c, turns.speed);
    };
    add_panel(f, here, &LastTurn::velocity, title(0), "Velocity (m/s)", all, row == 0);
    f.script.add("unset key\n");
    add_panel(f, here, &LastTurn::acceleration, title(1), "Acceleration (m/s²)", all, false);
    ++row;
  }
  f.script.add("unset multiplot\n");
  return draw(f, folder);
}

std::vector<std::filesystem::path> draw_paper(const std::filesystem::path& folder) {
  return draw_flores2011(folder, "paper.json");
}

}  // namespace

std::vector<std::filesystem::path> draw_flores2011(const std::filesystem::path& folder,
                                                   const std::string& source) {
  const auto variant = variant_to_draw(folder);
  if (variant.empty())
    throw SceneError(fmt::format("{}: has no rows to draw", (folder / "cells.csv").string()));
  const auto turns = read_turns(folder, variant);
  auto made = draw_matrix_of_paper(folder, variant, source);
  made.push_back(figure_5(folder, turns, source));
  made.push_back(figure_11(folder, turns, source));
  std::ranges::sort(made);
  return made;
}

const Drawing paper_figures{{"paper.json"}, draw_paper};

}  // namespace freeplay::plots

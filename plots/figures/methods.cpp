#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"
#include "values/family.hpp"

namespace freeplay::plots {

// Constraint error and residual of the energy balance over time, for every stabilisation.

namespace {

std::vector<std::filesystem::path> draw_drift(const std::filesystem::path& folder) {
  const ReadTable table(folder / "drift.csv", {"stabilisation"}, {"t", "length", "closure"});
  const auto& kind = table.text("stabilisation");
  const auto &t = table.column("t"), &length = table.column("length"), &closure = table.column("closure");
  // A logarithmic axis cannot show zero: the rounding error of a position replaces it.
  constexpr double least = 1e-17;
  Figure f{.name = "drift", .source = "drift.json"};
  std::vector<std::string> names;
  Limits time, lengths, closures;
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (names.empty() || names.back() != kind[i]) {
      names.push_back(kind[i]);
      f.blocks.emplace_back(kind[i] + ": t (s), constraint error (m), |closure| (J)");
    }
    f.blocks.back().row({t[i], length[i], std::abs(closure[i])});
    time.hold(t[i]);
    lengths.hold(std::max(length[i], least));
    closures.hold(std::max(std::abs(closure[i]), least));
  }
  const auto panel = [&](AxisTitle title, const Limits& limits, int column) {
    Panel p{.title = std::move(title), .axis = decades_of(limits.least, limits.most), .curves = {}};
    for (std::size_t i = 0; i < names.size(); ++i)
      p.curves.push_back({Script().add("DATA index {0} using 1:(${1} > {2} ? ${1} : {2}) with lines ls {3}",
                                       i, column, least, i + 1),
                          column == 2 ? names[i] : ""});
    return p;
  };
  return {draw_panels(f, folder,
                      {.abscissa = {time_title(), {time.least, time.most}},
                       .panels = {panel(AxisTitle::of("constraint error", "m"), lengths, 2),
                                  panel(AxisTitle::of("error of energy", "J"), closures, 3)},
                       .each = 4.6})};
}

// Processor time per step over the size of the mechanism, with the slopes predicted by the
// algorithms.

std::vector<std::filesystem::path> draw_scaling(const std::filesystem::path& folder) {
  Rows rows(folder / "scaling.csv");
  const auto scene = rows.place("scene"), count = rows.place("count"), cost = rows.place("microseconds"),
             predicted = rows.place("predicted");
  Figure f{.name = "scaling", .height_cm = 10, .source = "scaling.json"};
  std::vector<std::string> names;
  while (rows.next()) {
    if (names.empty() || names.back() != rows.name(scene)) {
      names.push_back(rows.name(scene));
      f.blocks.emplace_back(names.back() + ": count, processor time (us), predicted (us)");
    }
    f.blocks.back().row({rows.number(count), rows.number(cost), rows.maybe_number(predicted)});
  }
  if (names.empty()) return {};
  f.script.add(
      "set logscale xy\nset format y {}\nset xlabel 'Joints, links or bodies'\n"
      "set ylabel 'Processor time per step (µs)'\nset key top left\nplot ",
      powers_of_ten);
  for (std::size_t i = 0; i < names.size(); ++i)
    f.script.add(
        "{0}DATA index {1} using 1:2 with linespoints lw 1.5 pt 7 ps 0.5 lc rgb C{2} title {3} noenhanced, "
        "'' index {1} using 1:3 with lines ls 4 dt 2 {4}",
        i ? Word(", ") : Word(""), i, i + 1, names[i], i ? Word("notitle") : Word("title 'predicted'"));
  f.script.add("\n");
  return {draw(f, folder)};
}

// Work–precision diagrams: error over evaluations of the right-hand side and over CPU time, one
// figure per scene of a trade-off. A line marks the model error of the penalty formulation.

constexpr Word method_colours[] = {"C1", "C4", "C9", "C6", "C2", "C5", "C8", "C3", "C7"};
constexpr std::size_t most_scenes = 64;  ///< at most; one figure per scene

/// The rows of a trade-off and its lists of scenes and methods.
struct Tradeoff {
  explicit Tradeoff(const std::filesystem::path& folder)
      : table(folder / "tradeoff.csv", {"scene", "method", "formulation"},
              {"events", "state", "rhs", "cpu_s"}),
        document(folder / "tradeoff.json") {
    const auto collect = [&](const char* column, std::vector<std::string>& list) {
      for (const auto& name : table.text(column)) place_in(list, name);
    };
    collect("scene", scenes);
    collect("method", methods);
    if (scenes.size() > most_scenes)
      throw SceneError(fmt::format("{}: has {} scenes; figures show at most {}",
                                   (folder / "tradeoff.csv").string(), scenes.size(), most_scenes));
  }
  ReadTable table;
  JsonFile document;
  std::vector<std::string> scenes, methods;
};

/// A note on the formulation that the figure of a scene omits, with the reason; empty if none is
/// omitted.
std::string left_out(const Tradeoff& t, const std::string& name) {
  // `events` of a formulation is NaN throughout if there are no contact onsets to compare; infinity
  // means a missed onset.
  std::vector<std::string> all, assessed;
  for (std::size_t i = 0; i < t.table.rows(); ++i) {
    if (t.table.text("scene")[i] != name) continue;
    all.push_back(t.table.text("formulation")[i]);
    if (!std::isnan(t.table.column("events")[i])) assessed.push_back(all.back());
  }
  for (const auto& one : family_names())
    if (!assessed.empty() && std::ranges::find(all, one) != all.end() &&
        std::ranges::find(assessed, one) == assessed.end())
      return fmt::format("{}: omitted, no contact event for comparison", one);
  return "";
}

/// Adds the panel over CPU time or over right-hand sides. Returns false if there is nothing to
/// show.
bool add_panel(const Tradeoff& t, const std::string& name, bool touches, bool time, double model_error,
               const std::string& omitted, Figure& f) {
  const auto& error = t.table.column(touches ? "events" : "state");
  const auto& cost = t.table.column(time ? "cpu_s" : "rhs");
  Script plot;
  for (std::size_t k = 0; k < t.methods.size(); ++k) {
    Block block(t.methods[k]);
    for (std::size_t i = 0; i < t.table.rows(); ++i)
      if (t.table.text("scene")[i] == name && t.table.text("method")[i] == t.methods[k] &&
          std::isfinite(error[i]))
        block.row({time ? 1e3 * cost[i] : cost[i], error[i]});
    if (block.empty()) continue;
    plot.add(
        "{}DATA index {} using 1:($2 > 1e-16 ? $2 : 1e-16) with linespoints lw 1.2 dt {} pt {} lc rgb {} ",
        plot.empty() ? Word("plot ") : Word(", "), f.blocks.size(), 1 + k % 4, 1 + k,
        method_colours[k % std::size(method_colours)]);
    if (time)
      plot.add("notitle");
    else
      plot.add("title {} noenhanced", t.methods[k]);
    f.blocks.push_back(block);
  }
  if (plot.empty()) return false;
  f.script.add("unset label 2\n");
  if (model_error > 0)  // due to its finite stiffness; named in the key
    plot.add(", {} with lines lw 1.4 dt (8,5) lc rgb 0x555555 {}", model_error,
             time ? Word("notitle") : Word("title 'penalty: model error'"));
  if (!omitted.empty())
    f.script.add("set label 2 {} at graph 0, graph 1.02 font TINY tc rgb 0x555555 noenhanced\n", omitted);
  f.script.add("set xlabel {}\n{}\nunset ylabel\n", time ? "CPU (ms)" : "RHS evaluations", plot);
  return true;
}

std::vector<std::filesystem::path> draw_tradeoff(const std::filesystem::path& folder) {
  const Tradeoff t(folder);
  std::vector<std::filesystem::path> made;
  for (const auto& name : t.scenes) {
    Figure f{.name = file_name("tradeoff", name), .height_cm = 10.4, .source = "tradeoff.json"};
    if (t.document.find("scenes." + name + ".scene_file"))
      f.scene_file = t.document.text("scenes." + name + ".scene_file");
    bool touches = false;
    for (std::size_t i = 0; i < t.table.rows(); ++i)
      touches = touches || (t.table.text("scene")[i] == name && !std::isnan(t.table.column("events")[i]));
    const auto* model = t.document.find("scenes." + name + ".model_error_of_penalty");
    const double model_error = touches && model && model->is_number() ? model->get<double>() : 0;
    f.script.add(
        "set multiplot layout 1,2 margins X(1.8),1-X(0.4),Y(3.1),1-Y(0.5) spacing X(1.6),0\nset logscale "
        "xy\nset format "
        "{}\nset key at "
        "screen 0.5,Y(0.35) center bottom vertical maxrows 4 font SMALL\nset ylabel {}\n",
        powers_of_ten, touches ? "Error of contact events (relative)" : "Error of velocities (relative)");
    const auto omitted = left_out(t, name);
    for (const bool time : {false, true})
      if (!add_panel(t, name, touches, time, model_error, omitted, f)) break;
    f.script.add("unset multiplot\n");
    if (!f.blocks.empty()) made.push_back(draw(f, folder));
  }
  return made;
}

}  // namespace

const Drawing drift{{"drift.json"}, draw_drift};
const Drawing scaling{{"scaling.csv"}, draw_scaling};
const Drawing tradeoff{{"tradeoff.json"}, draw_tradeoff};

}  // namespace freeplay::plots

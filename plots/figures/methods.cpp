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

/// For a logarithmic axis.
void hold_positive(Limits& limits, double x) {
  if (x > 0) limits.hold(x);
}

// Processor time per step over the size of the mechanism, with the slopes predicted by the
// algorithms.

std::vector<std::filesystem::path> draw_scaling(const std::filesystem::path& folder) {
  Rows rows(folder / "scaling.csv");
  const auto scene = rows.place("scene"), count = rows.place("count"), cost = rows.place("microseconds"),
             predicted = rows.place("predicted");
  Figure f{.name = "scaling", .source = "scaling.json"};
  std::vector<std::string> names;
  Limits counts, costs;
  while (rows.next()) {
    if (names.empty() || names.back() != rows.name(scene)) {
      names.push_back(rows.name(scene));
      f.blocks.emplace_back(names.back() + ": count, processor time (us), predicted (us)");
    }
    const double n = rows.number(count), own = rows.number(cost), line = rows.maybe_number(predicted);
    f.blocks.back().row({n, own, line});
    hold_positive(counts, n);
    for (const double y : {own, line}) hold_positive(costs, y);
  }
  if (names.empty()) return {};
  Panel panel{.title = AxisTitle::of("processor time per step", "µs"),
              .axis = decades_of(costs.least, costs.most),
              .curves = {}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    panel.curves.push_back(
        {Script().add("DATA index {0} using 1:2 with linespoints lw 1.5 pt 7 ps 0.5 lc rgb C{1}", i, i + 1),
         names[i]});
    panel.curves.push_back({Script().add("DATA index {} using 1:3 with lines ls 4 dt 2", i),
                            i + 1 < names.size() ? "" : "predicted"});
  }
  return {draw_panels(
      f, folder,
      {.abscissa = {AxisTitle::of("joints, links or bodies", ""), decades_of(counts.least, counts.most)},
       .panels = {std::move(panel)},
       .each = 7.5})};
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

/// A formulation without contact onsets for comparison, which the figure of a scene omits; empty if
/// none is omitted.
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
      return one;
  return "";
}

/// The panels over right-hand sides and over CPU time, and their key; no curves if there is nothing to show.
PanelStack panels_of(const Tradeoff& t, const std::string& name, bool touches, double model_error,
                     Figure& f) {
  constexpr double least_error = 1e-16;  // a logarithmic axis cannot show zero
  const auto& error = t.table.column(touches ? "events" : "state");
  const auto title = touches ? AxisTitle::of("relative error of contact events", "")
                             : AxisTitle::of("relative error of velocities", "");
  PanelStack stack{.abscissa = {}, .panels = {}, .each = 6.0, .columns = 2};
  Limits errors;
  hold_positive(errors, model_error);
  for (const bool time : {false, true}) {
    Panel panel{.title = title, .axis = {}, .curves = {}};
    Limits costs;
    for (std::size_t k = 0; k < t.methods.size(); ++k) {
      Block block(t.methods[k]);
      for (std::size_t i = 0; i < t.table.rows(); ++i) {
        if (t.table.text("scene")[i] != name || t.table.text("method")[i] != t.methods[k] ||
            !std::isfinite(error[i]))
          continue;
        const double cost = time ? 1e3 * t.table.column("cpu_s")[i] : t.table.column("rhs")[i];
        block.row({cost, error[i]});
        hold_positive(costs, cost);
        errors.hold(std::max(error[i], least_error));
      }
      if (block.empty()) continue;
      const auto how = Script().add("with linespoints lw 1.2 dt {} pt {} lc rgb {}", 1 + k % 4, 1 + k,
                                    method_colours[k % std::size(method_colours)]);
      panel.curves.push_back({Script().add("DATA index {0} using 1:($2 > {1} ? $2 : {1}) {2}",
                                           f.blocks.size(), least_error, how),
                              ""});
      if (!time) stack.key.push_back({how, t.methods[k]});
      f.blocks.push_back(block);
    }
    if (panel.curves.empty()) return stack;
    if (model_error > 0) {  // due to its finite stiffness
      constexpr Word how = "with lines lw 1.4 dt (8,5) lc rgb 0x555555";
      panel.curves.push_back({Script().add("{} {}", model_error, how), ""});
      if (!time) stack.key.push_back({Script().add("{}", how), "penalty: model error"});
    }
    panel.abscissa = {time ? AxisTitle::of("CPU time", "ms") : AxisTitle::of("RHS evaluations", ""),
                      costs.most > 0 ? decades_of(costs.least, costs.most) : Axis{}};
    stack.panels.push_back(std::move(panel));
  }
  for (auto& panel : stack.panels) panel.axis = decades_of(errors.least, errors.most);
  return stack;
}

std::vector<std::filesystem::path> draw_tradeoff(const std::filesystem::path& folder) {
  const Tradeoff t(folder);
  std::vector<std::filesystem::path> made;
  for (const auto& name : t.scenes) {
    Figure f{.name = file_name("tradeoff", name), .source = "tradeoff.json"};
    if (t.document.find("scenes." + name + ".scene_file"))
      f.scene_file = t.document.text("scenes." + name + ".scene_file");
    bool touches = false;
    for (std::size_t i = 0; i < t.table.rows(); ++i)
      touches = touches || (t.table.text("scene")[i] == name && !std::isnan(t.table.column("events")[i]));
    const auto* model = t.document.find("scenes." + name + ".model_error_of_penalty");
    const double model_error = touches && model && model->is_number() ? model->get<double>() : 0;
    auto stack = panels_of(t, name, touches, model_error, f);
    if (stack.panels.empty()) continue;
    if (const auto omitted = left_out(t, name); !omitted.empty()) {
      stack.panels.front().name = omitted + ": no contact events";
      f.caption = fmt::format("{}: omitted, no contact event for comparison.", omitted);
    }
    made.push_back(draw_panels(f, folder, std::move(stack)));
  }
  return made;
}

}  // namespace

const Drawing drift{{"drift.json"}, draw_drift};
const Drawing scaling{{"scaling.csv"}, draw_scaling};
const Drawing tradeoff{{"tradeoff.json"}, draw_tradeoff};

}  // namespace freeplay::plots

// Measured time series with those of the formulations after a calibration: a figure for each target, over its
// column `against`, as the loop of a force over a displacement, or over time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// The rows of a target in one formulation.
struct SeriesRows {
  std::string formulation;
  std::vector<double> t, against, measured, model;
};

struct MeasuredTarget {
  std::string name;
  std::vector<SeriesRows> models;
};

std::vector<MeasuredTarget> targets_in(const std::filesystem::path& file) {
  std::vector<MeasuredTarget> all;
  Rows rows(file);
  const auto target = rows.place("target"), formulation = rows.place("formulation"), t = rows.place("t"),
             against = rows.place("against"), measured = rows.place("measured"), model = rows.place("model");
  while (rows.next()) {
    if (all.empty() || all.back().name != rows.name(target)) all.push_back({rows.name(target), {}});
    auto& models = all.back().models;
    if (models.empty() || models.back().formulation != rows.name(formulation))
      models.push_back({rows.name(formulation), {}, {}, {}, {}});
    auto& m = models.back();
    m.t.push_back(rows.number(t));
    m.against.push_back(rows.number(against));
    m.measured.push_back(rows.number(measured));
    m.model.push_back(rows.number(model));
  }
  return all;
}

std::filesystem::path draw_target(const std::filesystem::path& folder, const MeasuredTarget& target,
                                  const JsonFile& document) {
  const auto text = [&](const char* key) {
    return document.text(fmt::format("targets.{}.{}", target.name, key));
  };
  const bool loop = std::isfinite(target.models.front().against.front());
  const auto across_of = [&](const SeriesRows& m) -> const std::vector<double>& {
    return loop ? m.against : m.t;
  };
  Limits across, up;
  for (const auto& m : target.models) {
    for (const double x : across_of(m)) across.hold(x);
    for (const auto* list : {&m.measured, &m.model})
      for (const double y : *list) up.hold(y);
  }
  const auto channel = text("channel");
  const auto x_unit = loop ? fitting_unit(text("against_unit"), across.size()) : ShownUnit{"s", 1},
             y_unit = fitting_unit(unit_of_column(channel), up.size());
  Figure f{.name = file_name("series", target.name), .width_cm = 8.4, .source = "calibration.json"};
  Panel panel{.title = AxisTitle::plain(channel, printed(y_unit.name)),
              .axis = axis_of(up.least / y_unit.size, up.most / y_unit.size),
              .curves = {}};
  const auto add = [&](const SeriesRows& m, const std::vector<double>& y, const Script& how,
                       const std::string& name) {
    Block block(fmt::format("{}, {}: {}, {}", target.name, name, loop ? "against" : "t", channel));
    for (std::size_t i = 0; i < y.size(); ++i) block.row({across_of(m)[i] / x_unit.size, y[i] / y_unit.size});
    add_curve(f, panel, std::move(block), how, name);
  };
  const auto& first = target.models.front();
  add(first, first.measured, Script().add("using 1:2 with lines lw 1 lc rgb 0xA0A0A0"), "measured");
  for (const auto& m : target.models)
    add(m, m.model, Script().add("using 1:2 with lines ls {} lw 1", m.formulation == "penalty" ? 1 : 2),
        m.formulation);
  PanelStack stack{.abscissa = {loop ? AxisTitle::plain(text("against"), printed(x_unit.name)) : time_title(),
                                axis_of(across.least / x_unit.size, across.most / x_unit.size)},
                   .panels = {},
                   .each = 6};
  stack.panels.push_back(std::move(panel));
  return draw_panels(f, folder, std::move(stack));
}

std::vector<std::filesystem::path> draw_series(const std::filesystem::path& folder) {
  const JsonFile document(folder / "calibration.json");
  std::vector<std::filesystem::path> all;
  for (const auto& target : targets_in(folder / "series.csv"))
    all.push_back(draw_target(folder, target, document));
  return all;
}

}  // namespace

const Drawing series{{"series.csv"}, draw_series};

}  // namespace freeplay::plots

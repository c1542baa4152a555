// Curves of a sweep over one axis, and maps over two.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "mechanism/error.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/curve_look.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/heat_map.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/drawing/style.hpp"
#include "plots/studies/study_plot.hpp"
#include "plots/studies/sweep_runs.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_sweep_curves = 18, most_sweep_panels = 4;
constexpr double most_linear = 100;  ///< ratio of the values of a linear ordinate

/// Cells that share everything but the axes of the abscissae.
struct Group {
  std::string variant, formulation;
  std::vector<double> others;  ///< values of the other axes
  std::vector<const SweepCell*> cells = {};
};

/// The groups of a figure over some axes. Other axes with drawn values vary within a group, since
/// no two cells share such a value.
class Groups {
 public:
  Groups(const SweepRuns& runs, const std::vector<std::size_t>& over) : runs_(&runs) {
    for (std::size_t i = 0; i < runs.axes().size(); ++i)
      if (std::ranges::find(over, i) == over.end() && !runs.axes()[i].drawn) other_axes_.push_back(i);
    std::map<std::tuple<std::string, std::string, std::vector<double>>, std::size_t> places;
    for (const auto& cell : runs.cells()) {
      std::vector<double> others;
      for (const auto i : other_axes_) others.push_back(cell.values[i]);
      const auto [at, added] = places.try_emplace({cell.variant, cell.formulation, others}, list_.size());
      if (added) list_.push_back({cell.variant, cell.formulation, others});
      list_[at->second].cells.push_back(&cell);
      variants_.insert(cell.variant);
      formulations_.insert(cell.formulation);
    }
    // Curves that differ in the formulation only are neighbours.
    std::ranges::stable_sort(list_, {}, [](const Group& g) { return std::tie(g.variant, g.others); });
    for (std::size_t k = 0; k < other_axes_.size(); ++k) {
      std::set<double> values;
      for (const auto& g : list_) values.insert(g.others[k]);
      varies_.push_back(values.size() > 1);
    }
  }
  const std::vector<Group>& list() const { return list_; }

  /// What distinguishes the group from others, apart from the formulation.
  std::string title(const Group& g) const {
    std::vector<std::string> parts;
    if (variants_.size() > 1) parts.push_back(g.variant);
    for (std::size_t k = 0; k < other_axes_.size(); ++k) {
      if (!varies_[k]) continue;
      const auto& axis = runs_->axes()[other_axes_[k]];
      parts.push_back(fmt::format("{} = {:.4g}{}{}", axis.name, g.others[k] * axis.scale,
                                  axis.unit.empty() ? "" : " ", axis.unit));
    }
    return fmt::format("{}", fmt::join(parts, ", "));
  }
  std::string full_title(const Group& g) const {
    auto text = title(g);
    if (formulations_.size() > 1 || text.empty()) text += (text.empty() ? "" : ", ") + g.formulation;
    return text;
  }

 private:
  const SweepRuns* runs_;
  std::vector<std::size_t> other_axes_;
  std::vector<bool> varies_;
  std::set<std::string> variants_, formulations_;
  std::vector<Group> list_;
};

std::string label_of_axis(const SweepAxis& axis) { return name_with_unit(axis.name, axis.unit); }

AxisTitle title_of_axis(const SweepAxis& axis) { return AxisTitle::plain(axis.name, axis.unit); }

/// Title of a quantity: the words of a number of run.json, else its name.
AxisTitle title_of_quantity(const SweepQuantity& q) {
  if (!q.column.empty()) return title_of_number(q.column, q.unit);
  auto name = q.name;
  if (q.of == SweepQuantity::Of::statistic) std::ranges::replace(name, '_', ' ');
  return AxisTitle::plain(name, q.unit);
}

/// Quantities of the plot.
std::vector<SweepQuantity> quantities_of(const StudyPlot& plot, const SweepRuns& runs) {
  std::vector<SweepQuantity> list;
  for (const auto& name : plot.y) list.push_back(runs.quantity(name));
  return list;
}

std::filesystem::path sweep_curves(const StudyPlot& plot, const SweepRuns& runs, std::size_t x) {
  const auto quantities = quantities_of(plot, runs);
  if (quantities.size() > most_sweep_panels)
    throw SceneError(fmt::format("{} measures, but a figure has at most {} panels; draw several figures",
                                 quantities.size(), most_sweep_panels));
  const Groups groups(runs, {x});
  if (groups.list().size() > most_sweep_curves)
    throw SceneError(fmt::format(
        "{} curves over {}, but a figure has at most {}; choose another --x AXIS, or --x AXIS,AXIS for "
        "a map",
        groups.list().size(), runs.axes()[x].name, most_sweep_curves));
  const auto& axis = runs.axes()[x];
  const bool scattered = std::ranges::any_of(runs.axes(), &SweepAxis::drawn);
  std::vector<double> abscissae;
  for (const auto& cell : runs.cells()) abscissae.push_back(cell.values[x] * axis.scale);
  Figure f{.name = name_of_plot(plot, "sweep", "_" + axis.name),
           .source = "sweep.json",
           .title = plot.title,
           .formats = plot.formats};
  f.caption = fmt::format("{} over {}.", fmt::join(plot.y, ", "), axis.name);
  const bool keyed = groups.list().size() > 1;
  auto across = axis_at(abscissae);
  if (across.low == across.high)
    across = axis_of(across.low, across.high);
  else if (across.logarithmic)
    across.low /= std::pow(across.high / across.low, 0.02),
        across.high *= std::pow(across.high / across.low, 0.02);
  else if (const double margin = 0.02 * (across.high - across.low); margin > 0)
    across.low -= margin, across.high += margin;
  PanelStack stack{.abscissa = {title_of_axis(axis), across}, .panels = {}, .each = 5.0};
  for (const auto& q : quantities) {
    Panel panel{.title = title_of_quantity(q), .axis = {}, .curves = {}};
    Limits means, ends;
    std::string past;
    std::size_t colour = 0;
    for (const auto& g : groups.list()) {
      const auto title = groups.title(g);
      if (colour == 0 || title != past) ++colour;
      past = title;
      Block block(fmt::format("{}, {}: {}, mean, 95 % interval, starts", name_with_unit(q.name, q.unit),
                              groups.full_title(g), label_of_axis(axis)));
      for (const auto* cell : g.cells) {
        const auto s = runs.at(*cell, q);
        if (s.count == 0) continue;
        block.row({cell->values[x] * axis.scale, s.mean, s.low, s.high, static_cast<double>(s.count)});
        means.hold(s.mean);
        for (const double x : {s.mean, s.low, s.high}) ends.hold(x);
      }
      if (block.empty()) continue;
      // One pair of curves has the styles of the formulations, further ones a colour for each pair.
      const bool penalty = g.formulation == "penalty";
      const bool single = title.empty();
      const auto own = curve_look(colour - 1, penalty);
      const Script look = single
                              ? Script().add("ls {}", penalty ? 1 : 2)
                              : Script().add("lc rgb C{} dt {} pt {} lw 1.3", own.colour, own.dash, own.mark);
      panel.curves.push_back(
          {Script().add("DATA index {} using 1:2:3:4 with yerrorbars lc rgb C{} dt 1 ps 0", f.blocks.size(),
                        single ? (penalty ? std::size_t{1} : std::size_t{2}) : own.colour),
           ""});
      // The first panel names the curves of all.
      panel.curves.push_back({Script().add("DATA index {} using 1:2 with {} {}", f.blocks.size(),
                                           scattered ? Word("points") : Word("linespoints"), look),
                              keyed && stack.panels.empty() ? groups.full_title(g) : ""});
      f.blocks.push_back(std::move(block));
    }
    if (panel.curves.empty()) throw SceneError(fmt::format("--y {}: no run has a value", q.name));
    // On a logarithmic axis, intervals may extend below the least mean by any factor and are cut.
    panel.axis = means.least > 0 && ends.most > most_linear * means.least ? decades_of(means.least, ends.most)
                                                                          : axis_of(ends.least, ends.most);
    stack.panels.push_back(std::move(panel));
  }
  return draw_panels(f, plot.folder, std::move(stack));
}

std::filesystem::path sweep_map(const StudyPlot& plot, const SweepRuns& runs, std::size_t x, std::size_t y) {
  const auto &x_axis = runs.axes()[x], &y_axis = runs.axes()[y];
  const Groups groups(runs, {x, y});
  HeatMap map{.x = title_of_axis(x_axis),
              .y = title_of_axis(y_axis),
              .grid = std::ranges::none_of(runs.axes(), &SweepAxis::drawn),
              .heading = fmt::format("{}, {}, mean, 95 % interval, starts", label_of_axis(x_axis),
                                     label_of_axis(y_axis)),
              .panels = {}};
  for (const auto& q : quantities_of(plot, runs))
    for (const auto& g : groups.list()) {
      auto& panel = map.panels.emplace_back(HeatPanel{groups.list().size() > 1 ? groups.full_title(g) : "",
                                                      name_with_unit(q.name, q.unit),
                                                      title_of_quantity(q),
                                                      {}});
      for (const auto* cell : g.cells) {
        const auto s = runs.at(*cell, q);
        panel.cells.push_back({cell->values[x] * x_axis.scale, cell->values[y] * y_axis.scale, s.mean, s.low,
                               s.high, static_cast<double>(s.count)});
      }
    }
  Figure f{.name = name_of_plot(plot, "sweep", fmt::format("_{}-{}", x_axis.name, y_axis.name)),
           .source = "sweep.json",
           .title = plot.title,
           .formats = plot.formats};
  f.caption = fmt::format("{} over {} and {}.", fmt::join(plot.y, ", "), x_axis.name, y_axis.name);
  if (map.panels.size() == 1) f.width_cm = 12;
  add_heat_map(f, map, style_of(plot.folder));
  return draw(f, plot.folder);
}

}  // namespace

std::filesystem::path draw_sweep(const StudyPlot& plot) {
  const SweepRuns runs(plot.folder);
  std::vector<std::size_t> over;
  for (const auto& name : plot.x) over.push_back(runs.axis(name));
  if (over.empty())
    for (std::size_t i = 0; i < runs.axes().size(); ++i) over.push_back(i);
  if (plot.x.empty() && over.size() > 2) over.resize(1);
  if (over.empty())
    throw SceneError(plot.folder.string() +
                     ": the study has no axes to plot over; its values are in sweep.db");
  if (over.size() > 2 || (over.size() == 2 && over[0] == over[1]))
    throw SceneError(fmt::format("--x {}: must name one axis for curves, or two different ones for a map",
                                 fmt::join(plot.x, ",")));
  return over.size() == 1 ? sweep_curves(plot, runs, over[0]) : sweep_map(plot, runs, over[0], over[1]);
}

}  // namespace freeplay::plots

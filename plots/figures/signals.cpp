// Signals of the instruments of a run: each channel over time, and its spectrum after the
// transient.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/drawing/spectrum.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t most_channels = 6, most_points = 8000;
constexpr double most_samples = 1 << 18;  ///< at most, per spectrum

struct Channel {
  std::string name, unit;
  ColumnQuantity quantity;
  Points points;  ///< values over t
};

/// Time between the first two samples of each channel (s).
std::map<std::string, double> intervals(const std::filesystem::path& file) {
  Rows rows(file);
  const auto channel = rows.place("channel"), t = rows.place("t");
  std::map<std::string, double> first, list;
  for (long i = 0; i < 100'000 && rows.next(); ++i) {
    const auto& name = rows.name(channel);
    const auto [it, is_first] = first.emplace(name, rows.number(t));
    if (!is_first) list.emplace(name, rows.number(t) - it->second);
  }
  for (const auto& [name, time] : first) list.emplace(name, INFINITY);
  return list;
}

/// Draws stacked panels, one per channel.
std::filesystem::path stacked(const char* name, const std::filesystem::path& folder,
                              const std::vector<Channel>& channels, const std::vector<Points>& curves,
                              const Abscissa& abscissa, bool logarithmic, const std::string& caption) {
  Figure f{.name = name, .source = "run.json", .caption = caption};
  PanelStack stack{.abscissa = abscissa, .panels = {}, .each = channels.size() == 1 ? 6.0 : 3.2};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& [channel, si, quantity, points] = channels[i];
    const auto& y = curves[i].y;
    const auto [least, most] = std::ranges::minmax(y);
    const auto unit =
        logarithmic ? ShownUnit{printed(si), 1} : fitting_unit(si, std::max(std::abs(least), std::abs(most)));
    Block block(fmt::format("{}, {} ({})", abscissa.title.unit, channel, unit.name));
    for (std::size_t k = 0; k < y.size(); ++k) block.row({curves[i].x[k], y[k] / unit.size});
    Script what;
    what.add("'{}{}{}'", quantity.name, *quantity.symbol.text() ? Word(" ") : Word(""), quantity.symbol);
    const auto length = letters(quantity.name.text()) + letters(quantity.symbol.text()) + 1;
    stack.panels.push_back(
        {.title = length > 1 ? AxisTitle{what, length, unit.name} : AxisTitle::plain(channel, unit.name),
         .axis = logarithmic ? decades_of(least, most) : axis_of(least / unit.size, most / unit.size),
         .curves = {{Script().add("DATA index {} using 1:2 with lines lw 1 lc rgb C{}", i, 1 + i), ""}},
         .name = channels.size() > 1 || length == 1 ? channel : ""});
    f.blocks.push_back(std::move(block));
  }
  add_panels(f, style_of(folder), std::move(stack));
  return draw(f, folder);
}

std::vector<std::filesystem::path> spectra(const std::filesystem::path& folder,
                                           const std::vector<Channel>& channels) {
  std::vector<Channel> drawn;
  std::vector<Points> curves;
  for (const auto& c : channels) {
    if (c.points.x.size() < 16) continue;
    const double sampling =
        static_cast<double>(c.points.x.size() - 1) / (c.points.x.back() - c.points.x.front());
    auto s = spectrum_of(c.points.y, sampling);
    if (std::ranges::all_of(s.amplitude, [](double a) { return !(a > 0); })) continue;
    for (auto& a : s.amplitude) a = std::max(a, 1e-300);  // the axis is logarithmic
    drawn.push_back(c);
    curves.push_back(thinned({std::move(s.frequency), std::move(s.amplitude)}, most_points));
  }
  if (drawn.empty()) return {};
  double top = 0;
  for (const auto& c : curves) top = std::max(top, c.x.back());
  // Spectral lines due to rounding, far below the greatest, must not widen the range.
  for (auto& c : curves) {
    const double least = 1e-9 * *std::ranges::max_element(c.y);
    for (auto& a : c.y) a = std::max(a, least);
  }
  return {stacked("spectra", folder, drawn, curves,
                  {AxisTitle::of({"frequency f", "frequency $f$"}, "Hz"), {0, top}}, true,
                  "Amplitude spectra of the instruments, Hann window.")};
}

std::vector<std::filesystem::path> draw_signals(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "comparison.json") || runs_in(folder).empty() ||
      !std::filesystem::exists(folder / "signals.csv"))
    return {};
  const RunColumns columns(folder);
  const auto* t = columns.find("t");
  const double end = end_of(folder), discard = discard_of(folder);
  const auto turn = turn_of(scene_of_run(folder).get());
  const Span span = turn && end > 5 * *turn ? last_part(turn, end, 2) : Span{0, end, "whole run"};
  const auto interval = intervals(folder / "signals.csv");
  std::vector<Channel> channels;
  std::vector<Points> curves;
  for (const auto& c : columns.all()) {
    if (c.channel.empty() || channels.size() == most_channels) continue;
    auto shown = thinned(columns.read(*t, c, span.from, span.to, {}), most_points);
    if (shown.x.size() < 2) continue;
    curves.push_back(std::move(shown));
    const double begin = std::max(discard < end ? discard : 0, end - most_samples * interval.at(c.channel));
    channels.push_back({c.name, c.unit, c.quantity, columns.read(*t, c, begin, end, {})});
  }
  if (channels.empty()) return {};
  std::vector<std::filesystem::path> made{stacked("signals", folder, channels, curves,
                                                  {time_title(), {span.from, span.to}}, false,
                                                  fmt::format("Signals of the instruments: {}.", span.name))};
  for (auto& path : spectra(folder, channels)) made.push_back(std::move(path));
  return made;
}

}  // namespace

const Drawing signals{{"run.json"}, draw_signals};

}  // namespace freeplay::plots

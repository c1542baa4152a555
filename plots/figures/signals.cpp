// Signals of the instruments of a run: each channel over time, its spectrum after the transient, and the
// accelerometer over the last turn.

#include "plots/figures/signals.hpp"

#include <fmt/format.h>
#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <numeric>

#include "io/files/input_file.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

bool is_easy(std::size_t n) {
  for (const std::size_t p : {2, 3, 5})
    while (n % p == 0) n /= p;
  return n == 1;
}

}  // namespace

Spectrum spectrum_of(const std::vector<double>& samples, double sampling) {
  if (samples.size() < 16) return {};
  auto n = samples.size();
  while (n % 2 != 0 || !is_easy(n)) --n;
  std::vector<double> s(samples.end() - static_cast<std::ptrdiff_t>(n), samples.end());
  const double mean = std::accumulate(s.begin(), s.end(), 0.0) / static_cast<double>(n);
  double weight = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w =
        std::pow(std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(n)), 2);
    s[i] = w * (s[i] - mean);
    weight += w;
  }
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> lines;
  fft.fwd(lines, s);
  Spectrum out;
  for (std::size_t k = 0; k <= n / 2; ++k) {
    out.frequency.push_back(static_cast<double>(k) * sampling / static_cast<double>(n));
    out.amplitude.push_back(2 * std::abs(lines[k]) / weight);
  }
  return out;
}

// Signal of the scene's accelerometer over the crank angle of the last whole revolution: both
// formulations and the ideal joint.

namespace {

constexpr double turn = 2 * std::numbers::pi;

struct Trace {
  std::string channel;
  bool turns = false;  ///< whether the crank angle is known and not constant
  Limits range = {};   ///< m/s²
  Block block{"angle (degrees) or t (s), acceleration (m/s^2)"};
};

/// The first accelerometer of the scene of a run; "" if there is none or the scene cannot be read.
/// Other channels are not accelerations.
std::string accelerometer(const std::filesystem::path& run) {
  if (!std::filesystem::exists(run / "run.json")) return "";
  if (const auto scene = scene_in(JsonFile(run / "run.json")))
    for (const auto& i : scene->instruments)
      if (i.kind == Instrument::Kind::accelerometer) return i.name;
  return "";
}

/// The signal of the accelerometer over the last whole turn of the crank; without a crank over the
/// last tenth of the time. The file is read twice, because the start of the turn is known only at
/// the end of the file.
Trace last_turn(const std::filesystem::path& file) {
  Trace trace{.channel = accelerometer(file.parent_path())};
  const auto each = [&](const auto& take) {
    Rows rows(file);
    const auto channel = rows.place("channel"), t = rows.place("t"), angle = rows.place("crank_angle"),
               value = rows.place("value");
    while (rows.next()) take(rows.name(channel), rows.number(t), rows.number(angle), rows.number(value));
  };
  double front = NAN, back = NAN, end = 0;
  each([&](const std::string&, double t, double angle, double) {
    if (std::isnan(front)) front = angle;
    back = angle;
    end = t;
  });
  trace.turns = back < front || back > front;
  if (trace.channel.empty()) return trace;
  const double sense = trace.turns && back < front ? -1 : 1;
  const double last = sense * back / turn, start = sense * front / turn;
  const double whole = std::floor(last + 1e-9 * (last - start)) - 1;
  const double first = std::max(whole, std::floor(start + 1e-9));
  each([&](const std::string& channel, double t, double angle, double value) {
    if (channel != trace.channel) return;
    const double along = sense * angle / turn - first;
    if (trace.turns ? along < 0 || along > 1 : t < 0.9 * end) return;
    trace.range.hold(value);
    trace.block.row({trace.turns ? 360 * (sense > 0 ? along : 1 - along) : t, value});
  });
  return trace;
}

std::vector<std::filesystem::path> draw_acceleration(const std::filesystem::path& folder) {
  const auto file = [&](const char* run) { return folder / run / "signals.csv"; };
  if (!std::filesystem::exists(file("penalty"))) return {};
  Figure f{.name = "acceleration", .source = "comparison.json"};
  const char* const titles[][2] = {
      {"penalty", "penalty"}, {"nonsmooth", "nonsmooth"}, {"ideal", "ideal joint"}};
  Panel panel{.title = {}, .axis = {}, .curves = {}};
  std::string channel;
  bool turns = false;
  double end = 0, start = INFINITY;
  Limits up;
  for (int i = 0; i < 3; ++i) {
    if (!std::filesystem::exists(file(titles[i][0]))) continue;
    const auto trace = last_turn(file(titles[i][0]));
    if (i == 0) turns = trace.turns;
    if (trace.block.empty()) continue;
    channel = trace.channel;
    up.hold(trace.range.least), up.hold(trace.range.most);
    end = std::max(end, end_of(folder / titles[i][0])), start = std::min(start, 0.9 * end);
    add_curve(f, panel, trace.block, Script().add("using 1:2 with lines ls {}", i + 1), titles[i][1]);
  }
  if (panel.curves.empty()) return {};
  f.caption = fmt::format("Signal of {}, {}.", channel, turns ? "last whole turn" : "last tenth of the time");
  panel.title = AxisTitle::of({"acceleration a", "acceleration $a$"}, "m/s²");
  panel.axis = axis_of(up.least, up.most);
  PanelStack stack{.abscissa = turns ? Abscissa{crank_title(), {.low = 0, .high = 360, .turn = true}}
                                     : Abscissa{time_title(), {start, end}},
                   .panels = {std::move(panel)},
                   .each = 6.5};
  return {draw_panels(f, folder, std::move(stack))};
}

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
  return draw_panels(f, folder, std::move(stack));
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

const Drawing acceleration{{"comparison.json"}, draw_acceleration};
const Drawing signals{{"run.json"}, draw_signals};

}  // namespace freeplay::plots

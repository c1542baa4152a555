// Signal of the scene's accelerometer over the crank angle of the last whole revolution: both
// formulations and the ideal joint.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "io/files/input_file.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/run_facts.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
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
  add_panels(f, style_of(folder), std::move(stack));
  return {draw(f, folder)};
}

}  // namespace

const Drawing acceleration{{"comparison.json"}, draw_acceleration};

}  // namespace freeplay::plots

// Acceleration through the scene's accelerometer over the crank angle of the last whole revolution: both
// formulations and the ideal joint.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "model/scene.hpp"
#include "plots/figure.hpp"

namespace freeplay::plots {
namespace {

constexpr double turn = 2 * std::numbers::pi;

struct Trace {
  std::string channel, block;
  std::size_t points = 0;
};

/// The first accelerometer of the scene that a run was made of; of an unreadable one the first channel.
std::string accelerometer(const std::filesystem::path& run, const Csv& csv) {
  std::string first = csv.rows() ? csv.text("channel").front() : "";
  try {
    std::ifstream in(run / "run.json");
    const auto source = nlohmann::json::parse(in).at("provenance");
    const auto scene = parse_scene(source.at("scene"), source.at("scene_file"), source.at("overrides"));
    for (const auto& i : scene.instruments)
      if (i.kind == Instrument::Kind::accelerometer) return i.name;
    return "";
  } catch (const std::exception&) {
    return first;
  }
}

/// The last whole turn of the accelerometer; without a drive the last tenth of the time.
Trace last_turn(const std::filesystem::path& file) {
  const Csv csv(file);
  Trace trace{accelerometer(file.parent_path(), csv), "# angle (degrees) or t (s), acceleration (m/s^2)\n",
              0};
  if (csv.rows() == 0 || trace.channel.empty()) return trace;
  const auto t = csv.column("t"), angle = csv.column("crank_angle"), value = csv.column("value");
  const double turned = std::abs(angle.back());
  const double first = turn * std::max(0.0, std::floor(turned / turn * (1 + 1e-9)) - 1);
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (csv.text("channel")[i] != trace.channel) continue;
    const double a = std::abs(angle[i]) - first;
    if (turned > 0 ? a < 0 || a > turn : t[i] < 0.9 * t.back()) continue;
    trace.block += fmt::format("{:.6g} {:.6g}\n", turned > 0 ? a * 360 / turn : t[i], value[i]);
    ++trace.points;
  }
  return trace;
}

bool driven(const std::filesystem::path& file) {
  const auto angle = Csv(file).column("crank_angle");
  return !angle.empty() && angle.back() != 0;
}

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const auto file = [&](const char* run) { return folder / run / "signals.csv"; };
  if (!std::filesystem::exists(file("penalty"))) return {};
  Figure f;
  f.name = "acceleration";
  f.source = "comparison.json";
  std::string plot;
  const char* const titles[][2] = {
      {"penalty", "penalty"}, {"nonsmooth", "nonsmooth"}, {"ideal", "ideal joint"}};
  Trace trace;
  for (int i = 0; i < 3; ++i) {
    if (!std::filesystem::exists(file(titles[i][0]))) continue;
    trace = last_turn(file(titles[i][0]));
    if (trace.points == 0) continue;
    plot += fmt::format("{}'DATA' index {} using 1:2 with lines ls {} title '{}'",
                        plot.empty() ? "plot " : ", ", f.blocks.size(), i + 1, titles[i][1]);
    f.blocks.push_back(trace.block);
  }
  if (plot.empty()) return {};
  f.script = driven(file("penalty")) ? "set xlabel 'Crank angle (°)'\nset xrange [0:360]\nset xtics 45\n"
                                     : "set xlabel 'Time (s)'\n";
  f.script += fmt::format(
      "set ylabel 'Acceleration, {} (m/s²)' noenhanced\nset key outside top center horizontal\n{}\n",
      trace.channel, plot);
  return {draw(f, folder)};
}

}  // namespace

const Drawing acceleration{{"comparison.json"}, draw_all};

}  // namespace freeplay::plots

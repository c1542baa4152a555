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

/// The first accelerometer of the scene that a run was made of; "" where there is none, or none can be known: another
/// channel is no acceleration.
std::string accelerometer(const std::filesystem::path& run) {
  try {
    std::ifstream in(run / "run.json");
    const auto source = nlohmann::json::parse(in).at("provenance");
    const auto scene = parse_scene(source.at("scene"), source.at("scene_file"), source.at("overrides"));
    for (const auto& i : scene.instruments)
      if (i.kind == Instrument::Kind::accelerometer) return i.name;
  } catch (const std::exception&) {
  }
  return "";
}

/// Whether the crank's angle is known, and grows or falls.
bool driven(const std::vector<double>& angle) { return !angle.empty() && angle.back() != angle.front(); }

/// The last whole turn of the accelerometer, at the crank's own angles; without a crank the last tenth of the time.
Trace last_turn(const std::filesystem::path& file) {
  const Csv csv(file);
  Trace trace{accelerometer(file.parent_path()), "# angle (degrees) or t (s), acceleration (m/s^2)\n", 0};
  if (csv.rows() == 0 || trace.channel.empty()) return trace;
  const auto t = csv.column("t"), angle = csv.column("crank_angle"), value = csv.column("value");
  const bool turns = driven(angle);
  const double sense = turns && angle.back() < angle.front() ? -1 : 1;
  const double last = sense * angle.back() / turn, start = sense * angle.front() / turn;
  const double whole = std::floor(last + 1e-9 * (last - start)) - 1;
  const double first = std::max(whole, std::floor(start + 1e-9));
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (csv.text("channel")[i] != trace.channel) continue;
    const double along = sense * angle[i] / turn - first;
    if (turns ? along < 0 || along > 1 : t[i] < 0.9 * t.back()) continue;
    const double degrees = 360 * (sense > 0 ? along : 1 - along);
    trace.block += fmt::format("{} {}\n", turns ? degrees : t[i], value[i]);
    ++trace.points;
  }
  return trace;
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
  f.script = driven(Csv(file("penalty")).column("crank_angle"))
                 ? "set xlabel 'Crank angle (°)'\nset xrange [0:360]\nset xtics 45\n"
                 : "set xlabel 'Time (s)'\n";
  f.script += fmt::format(
      "set ylabel 'Acceleration, {} (m/s²)' noenhanced\nset key outside top center horizontal\n{}\n",
      trace.channel, plot);
  return {draw(f, folder)};
}

}  // namespace

const Drawing acceleration{{"comparison.json"}, draw_all};

}  // namespace freeplay::plots

// Work–precision figures: error over right-hand sides, one figure for each scene of a trade-off.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plots/figure.hpp"

namespace freeplay::plots {

namespace {
constexpr const char* colours[] = {"#0b3c8c", "#1a7f37", "#3d9be0", "#b8860b", "#c8500a",
                                   "#7b3fa0", "#cf222e", "#000000", "#8a6d3b"};
}

std::vector<std::filesystem::path> tradeoff(const std::filesystem::path& folder) {
  const Csv csv(folder / "tradeoff.csv");
  const auto &scene = csv.text("scene"), &method = csv.text("method");
  const auto events = csv.column("events"), state = csv.column("state"), rhs = csv.column("rhs"),
             cpu = csv.column("cpu_s");
  std::vector<std::string> scenes, methods;
  for (std::size_t i = 0; i < csv.rows(); ++i) {
    if (std::ranges::find(scenes, scene[i]) == scenes.end()) scenes.push_back(scene[i]);
    if (std::ranges::find(methods, method[i]) == methods.end()) methods.push_back(method[i]);
  }
  std::vector<std::filesystem::path> made;
  for (const auto& name : scenes) {
    Figure f;
    f.name = "tradeoff_" + name;
    f.height_cm = 10;
    bool touches = false;
    for (std::size_t i = 0; i < csv.rows(); ++i) touches = touches || (scene[i] == name && events[i] > 0);
    f.script = fmt::format(
        "set multiplot layout 1,2 margins 0.1,0.98,0.24,0.96 spacing 0.1,0\nset logscale xy\nset format "
        "'10^{{%T}}'\nset key at "
        "screen 0.5,0.02 center bottom vertical maxrows 3 font ',7'\nset ylabel '{}'\n",
        touches ? "Error of touches (relative)" : "Error of velocities (relative)");
    for (const bool time : {false, true}) {
      std::string plot;
      for (std::size_t k = 0; k < methods.size(); ++k) {
        std::string block;
        for (std::size_t i = 0; i < csv.rows(); ++i) {
          const double error = touches ? events[i] : state[i];
          if (scene[i] == name && method[i] == methods[k] && std::isfinite(error))
            block += fmt::format("{} {}\n", time ? 1e3 * cpu[i] : rhs[i], std::max(error, 1e-16));
        }
        if (block.empty()) continue;
        f.blocks.push_back("# " + methods[k] + "\n" + block);
        plot += fmt::format("{}'DATA' index {} using 1:2 with linespoints lw 1.2 dt {} pt {} lc rgb '{}' {}",
                            plot.empty() ? "plot " : ", ", f.blocks.size() - 1, 1 + k % 4, 1 + k,
                            colours[k % std::size(colours)],
                            time ? "notitle" : fmt::format("title '{}' noenhanced", methods[k]));
      }
      if (plot.empty()) break;
      f.script +=
          fmt::format("set xlabel '{}'\n{}\nunset ylabel\n", time ? "CPU (ms)" : "Right-hand sides", plot);
    }
    f.script += "unset multiplot\n";
    if (!f.blocks.empty()) made.push_back(draw(f, folder));
  }
  return made;
}

}  // namespace freeplay::plots

// Work–precision figures: error over right-hand sides, one figure for each scene of a trade-off; a line where
// the penalty formulation's model, not its numerics, stands.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "plots/figure.hpp"
#include "values/family.hpp"

namespace freeplay::plots {

namespace {

constexpr const char* colours[] = {"#0b3c8c", "#1a7f37", "#3d9be0", "#b8860b", "#c8500a",
                                   "#7b3fa0", "#cf222e", "#000000", "#8a6d3b"};

/// What tradeoff.json says of a scene; empty where it says nothing.
nlohmann::json about(const std::filesystem::path& folder, const std::string& scene) {
  std::ifstream in(folder / "tradeoff.json");
  const auto document = nlohmann::json::parse(in, nullptr, false);
  if (document.is_discarded()) return nlohmann::json::object();
  return document.value("scenes", nlohmann::json::object()).value(scene, nlohmann::json::object());
}

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const Csv csv(folder / "tradeoff.csv");
  const auto &scene = csv.text("scene"), &method = csv.text("method"), &formulation = csv.text("formulation");
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
    f.source = "tradeoff.json";
    f.height_cm = 10;
    const auto facts = about(folder, name);
    f.scene_file = facts.value("scene_file", "");
    // Without judged touches a formulation's `events` is NaN throughout (an infinity is a touch missed).
    std::vector<std::string> all, judged;
    for (std::size_t i = 0; i < csv.rows(); ++i) {
      if (scene[i] != name) continue;
      all.push_back(formulation[i]);
      if (!std::isnan(events[i])) judged.push_back(formulation[i]);
    }
    const bool touches = !judged.empty();
    std::string left_out;
    for (const auto& one : family_names())
      if (touches && std::ranges::find(all, one) != all.end() &&
          std::ranges::find(judged, one) == judged.end())
        left_out = fmt::format("{}: no touch to judge by, left out", one);
    const auto model = facts.find("model_error_of_penalty");
    const double model_error =
        touches && model != facts.end() && model->is_number() ? model->get<double>() : std::nan("");
    f.script = fmt::format(
        "set multiplot layout 1,2 margins 0.1,0.98,0.24,0.96 spacing 0.1,0\nset logscale xy\nset format "
        "'10^{{%T}}'\nset key at "
        "screen 0.5,0.035 center bottom vertical maxrows 3 font ',7'\nset ylabel '{}'\n",
        touches ? "Error of touches (relative)" : "Error of velocities (relative)");
    for (const bool time : {false, true}) {
      std::string plot;
      for (std::size_t k = 0; k < methods.size(); ++k) {
        std::string block;
        for (std::size_t i = 0; i < csv.rows(); ++i) {
          const double error = touches ? events[i] : state[i];
          if (scene[i] == name && method[i] == methods[k] && std::isfinite(error))
            block += fmt::format("{} {}\n", time ? 1e3 * cpu[i] : rhs[i], error);
        }
        if (block.empty()) continue;
        f.blocks.push_back("# " + methods[k] + "\n" + block);
        plot += fmt::format(
            "{}'DATA' index {} using 1:($2 > 1e-16 ? $2 : 1e-16) with linespoints lw 1.2 dt {} pt {} lc rgb '{}' {}",
            plot.empty() ? "plot " : ", ", f.blocks.size() - 1, 1 + k % 4, 1 + k,
            colours[k % std::size(colours)],
            time ? "notitle" : fmt::format("title '{}' noenhanced", methods[k]));
      }
      if (plot.empty()) break;
      f.script += "unset label 1\nunset label 2\n";
      if (model_error > 0) {
        plot += fmt::format(", {} with lines lw 1.4 dt (8,5) lc rgb '#555555' notitle", model_error);
        f.script += fmt::format(
            "set label 1 'model error of penalty (finite stiffness)' at graph 0.02, first {} left offset "
            "0,0.5 font ',6' tc rgb '#555555'\n",
            model_error);
      }
      if (!left_out.empty())
        f.script +=
            fmt::format("set label 2 '{}' at graph 0, graph 1.02 font ',6' tc rgb '#555555'\n", left_out);
      f.script +=
          fmt::format("set xlabel '{}'\n{}\nunset ylabel\n", time ? "CPU (ms)" : "Right-hand sides", plot);
    }
    f.script += "unset multiplot\n";
    if (!f.blocks.empty()) made.push_back(draw(f, folder));
  }
  return made;
}

}  // namespace

const Drawing tradeoff{{"tradeoff.json"}, draw_all};

}  // namespace freeplay::plots

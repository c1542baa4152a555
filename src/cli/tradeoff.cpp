// freeplay tradeoff: cost and accuracy of all settings on the scenes of a study.
#include "study/comparison/tradeoff.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "plots/drawing/figure.hpp"
#include "study/settings/study.hpp"

namespace freeplay::cli {
namespace {

struct TradeoffRequest : Request {
  std::string scene;  ///< study file
  Reach reach = Reach::beside;
  int repeats = 3;       ///< runs of each setting
  std::string output;    ///< result folder
  std::string document;  ///< folder for tradeoff.md and its figures
};

int tradeoff(const TradeoffRequest& request) {
  const auto study = read_study(request.scene, request.reach);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  std::vector<std::shared_ptr<const Scene>> scenes;  // read all before any run
  for (const auto& v : study.variants) scenes.push_back(open_scene(v.scene, v.overrides));
  auto origin = provenance(study);
  origin["scene_file"] = study.file.string();
  ResultSet set(folder, "tradeoff");
  std::vector<TradeoffScene> measured;
  Progress progress;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto& v = study.variants[i];
    const Sampling sampling{v.starts, v.revolutions, study.starts.seed, study.starts.perturbation};
    auto t = trade_off(*scenes[i], request.conduct(), request.repeats, sampling,
                       [&](double done) { progress.show(v.name, done); });
    progress.clear();
    if (request.stop()) return interrupted(Kept::nothing);
    t.name = v.name;
    t.file = v.scene;
    t.variant = v.title;
    fmt::print("{}", tradeoff_text(t));
    std::fflush(stdout);
    measured.push_back(std::move(t));
  }
  write_json(set.place() / "tradeoff.json", to_json(measured), origin);
  write_file(set.place() / "tradeoff.csv", tradeoff_table(measured).csv());
  set.commit();
  const auto figures = plots::all(folder);
  if (!request.document.empty()) {
    const auto place = real_folder(request.document);
    const auto lock = lock_document(place, folder, "tradeoff");
    const auto command = fmt::format("freeplay tradeoff {}{}", request.scene,
                                     request.reach == Reach::anywhere ? " --allow-outside" : "");
    const auto with_events = std::ranges::find_if(measured, [](const TradeoffScene& t) {
      return !(t.penalty.touches.empty() && t.nonsmooth.touches.empty());
    });
    const auto first =
        with_events == measured.end() ? "" : plots::file_name("tradeoff", with_events->name) + ".png";
    write_file(place / "tradeoff.md",
               tradeoff_page(measured, copy_figures(figures, place), first, command, request.repeats));
  }
  fmt::print("results in {}\n", folder.string());
  return 0;
}

}  // namespace

void tradeoff_verb(Program& program) {
  auto [options, request] = program.verb(
      "tradeoff", "measure the cost of accuracy: all settings on the scenes of a study", tradeoff);
  options.add("study", request.scene, "study file").required();
  options.add("--repeats", request.repeats, "runs of each setting, interleaved").between(1, 1000);
  options.output(request.output, "result folder; default out/NAME");
  options.allow_outside(request.reach);
  options.add("--document", request.document, "write tradeoff.md and its figures into this folder")
      .takes("FOLDER");
}

}  // namespace freeplay::cli

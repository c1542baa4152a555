#include "study/runs/turn_feed.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/files/visible.hpp"
#include "io/scene/read_section.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

int instrument(const Study& study, const Scene& scene, const std::string& name, Instrument::Kind kind,
               const char* key) {
  for (std::size_t i = 0; i < scene.instruments.size(); ++i)
    if (scene.instruments[i].name == name && scene.instruments[i].kind == kind) return static_cast<int>(i);
  std::vector<std::string> names;
  for (const auto& i : scene.instruments)
    if (i.kind == kind) names.push_back(i.name);
  throw error_at(
      study, {key},
      fmt::format("\"{}\" is not an instrument of {}; {}", visible(name), scene.file.string(),
                  names.empty() ? "it has none" : fmt::format("it has {}", fmt::join(names, ", "))));
}

}  // namespace

std::pair<int, int> channels(const Study& study, const Scene& scene, TurnRules& rules) {
  const int a = study.accelerometer.empty() ? -1
                                            : instrument(study, scene, study.accelerometer,
                                                         Instrument::Kind::accelerometer, "accelerometer");
  const int x = study.position.empty()
                    ? -1
                    : instrument(study, scene, study.position, Instrument::Kind::lvdt, "position");
  if (a >= 0 || x >= 0) rules.sampling = scene.instruments[a >= 0 ? a : x].sampling;
  if (x >= 0 && scene.instruments[x].sampling != rules.sampling)
    throw SceneError(
        fmt::format("{}: accelerometer and position must have the same sampling", scene.file.string()));
  return {a, x};
}

}  // namespace freeplay

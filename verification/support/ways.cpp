#include "verification/support/ways.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"

namespace freeplay::test {

void Way::choose(Scene& scene) const {
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step.reset();
  if (fixed()) scene.nonsmooth.step = step;
}

Scene scene_by(const Way& way, const std::string& text, const std::vector<std::string>& more) {
  auto options = way.options;
  options.insert(options.end(), more.begin(), more.end());
  auto scene = parse_scene(text, "s.toml", options);
  way.choose(scene);
  return scene;
}

Scene read_short(const std::filesystem::path& file, double duration,
                 const std::vector<std::string>& overrides) {
  auto scene = read_scene(file, overrides);
  scene.run.duration = duration;
  scene.run.discard = 0;
  return scene;
}

namespace {

Result checked(Result run) {
  if (run.ending.status != Ending::Status::finished)
    throw std::runtime_error(
        fmt::format("the {} run did not finish: {}", run.formulation, run.ending.reason));
  return run;
}

}  // namespace

Result finished(const Scene& scene, Family family) { return checked(simulate(scene, family)); }

Result finished(const Way& way, Scene scene) {
  way.choose(scene);
  return finished(scene, way.family);
}

Result finished(const Way& way, const std::string& text, const std::vector<std::string>& more) {
  return finished(way, scene_by(way, text, more));
}

Result finished(Simulation& simulation, std::vector<Observer*> observers) {
  return checked(simulation.run({.observers = std::move(observers)}));
}

Result watch_steps(Simulation& simulation, const std::function<void(const Step&)>& look) {
  Listener listener;
  listener.want.forces = true;
  listener.on_step = look;
  return finished(simulation, {&listener});
}

}  // namespace freeplay::test

// Helpers of tests: paths of the scenes, and short ways to run a scene.
#pragma once

#include <sys/types.h>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "simulation/observer.hpp"
#include "values/event.hpp"
#include "values/family.hpp"
#include "values/result.hpp"

namespace freeplay {
struct ContactFacts;
struct Scene;
struct Surface;
}  // namespace freeplay

namespace freeplay::test {

/// Folder of the scenes of claims and tests: the one that the program was built from. Throws
/// SceneError if it does not exist, as may be the case for an installed program.
std::filesystem::path source_folder();
inline std::filesystem::path flores() { return source_folder() / "cases/flores2011/scene.toml"; }
inline std::filesystem::path scene_file(const std::string& name) {
  return source_folder() / "verification/scenes" / (name + ".toml");
}
/// The scene of a published case.
inline std::filesystem::path published(const std::string& name) {
  return source_folder() / "cases/published" / name / "scene.toml";
}
/// All scenes of the source folder. Studies, in the same folders, have no bodies.
std::vector<std::filesystem::path> all_scenes();

/// One run in memory.
using freeplay::name_of;
Result simulate(const Scene& scene, Family family);

/// Quantities that the model computes for a scene.
double kinetic_energy(const Scene& scene, const State& state);
ContactFacts first_contact(const Scene& scene);
/// At the assembled start.
std::vector<int> redundant_rows(const Scene& scene);

/// Calls functions with events and samples.
class Listener final : public Observer {
 public:
  std::function<void(const Event&)> on_event;
  std::function<void(std::size_t, double, double)> on_sample;
  std::function<void(const Step&)> on_step;
  Wants want{};
  Wants wants() const override {
    return {want.forces, want.samples || on_sample != nullptr, on_step != nullptr};
  }
  void event(const Event& e) override {
    if (on_event) on_event(e);
  }
  void sample(std::size_t channel, double t, double value) override {
    if (on_sample) on_sample(channel, t, value);
  }
  void step(const Step& step) override {
    if (on_step) on_step(step);
  }
};

/// The forces of the elements at the end of the last step.
class LastForces final : public Observer {
 public:
  Wants wants() const override { return {.forces = true, .steps = true}; }
  void begin(const Layout& layout, const State&) override { elements = layout.forces; }
  void step(const Step& step) override { step.forces(step.t1, now); }
  /// Normal force of an element (N); NaN if there is none of this name.
  double normal(const std::string& name) const {
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (elements[i].name == name) return now.elements.at(i).fn;
    return NAN;
  }
  std::vector<ForceElement> elements;
  Forces now;
};

/// Contact onsets (impacts and beginnings of lasting contact) in the order of time.
inline std::vector<ContactEvent> touches(const Result& run) {
  std::vector<ContactEvent> list;
  for (const auto& e : run.events)
    if (e.kind != EventKind::separation) list.push_back(e);
  return list;
}

/// The i-th contact onset (from 0), or an error that states their number.
ContactEvent touch(const Result& run, std::size_t i);

/// Slope of log y over log x, least squares through all points: an observed order.
double observed_order(const std::vector<double>& x, const std::vector<double>& y);

/// Steel with a restitution, frictionless.
Surface steel(double restitution);

/// A row of N four-bars that share their uprights (IFToMM benchmark A02: links of 1 m and 1 kg,
/// gravity, the first upright turning at 1 rad/s), with clearance in the joint between every
/// coupler and the upright behind it.
Scene row_of_four_bars(int count, double clearance);

/// All bytes of a file. Throws std::runtime_error if it cannot be read.
std::string file_text(const std::filesystem::path& file);

/// A folder that is removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Runs the freeplay program; its output on both streams, and its exit status.
struct Outcome {
  int status;
  std::string out, err;
};
Outcome freeplay(const std::string& arguments);
/// Starts it as a process without input and output, which can receive signals. `prepare` is called
/// in the process before.
pid_t start_freeplay(const std::vector<std::string>& words, void (*prepare)() = nullptr);

}  // namespace freeplay::test

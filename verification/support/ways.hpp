// Methods to run a scene, and runs that have to finish.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/options.hpp"
#include "values/family.hpp"
#include "values/result.hpp"

namespace freeplay {
class Observer;
class Simulation;
struct Scene;
class Step;
}  // namespace freeplay

namespace freeplay::test {

/// A formulation, for the nonsmooth one a scheme, and the options that a scene is run with.
struct Way {
  const char* name;
  Family family = Family::nonsmooth;
  std::optional<Scheme> scheme = {};
  double step = 0;  ///< s, of fixed steps; 0: adaptive steps
  std::vector<std::string> options = {};

  bool penalty() const { return family == Family::penalty; }
  bool stepping() const { return scheme == Scheme::moreau_jean; }
  bool fixed() const { return step > 0; }
  bool chosen() const { return stepping() && !fixed(); }
  /// Sets scheme and step, and no option.
  void choose(Scene& scene) const;
};

inline const Way penalty{"penalty", Family::penalty};
inline const Way event_driven{"event-driven", Family::nonsmooth, Scheme::event_driven};
inline const Way automatic{"automatic", Family::nonsmooth, Scheme::automatic};
inline const Way chosen_steps{"Moreau–Jean, adaptive steps", Family::nonsmooth, Scheme::moreau_jean};
inline Way fixed_steps(double h, const char* name = "Moreau–Jean") {
  return {name, Family::nonsmooth, Scheme::moreau_jean, h};
}

/// A scene's text by a method; `more`: options after those of the method.
Scene scene_by(const Way& way, const std::string& text, const std::vector<std::string>& more = {});
/// A scene's file with a run of this duration (s) without a discarded part.
Scene read_short(const std::filesystem::path& file, double duration,
                 const std::vector<std::string>& overrides = {});
/// Runs in memory. Throws with the reason if the run does not finish.
Result finished(const Scene& scene, Family family);
Result finished(const Way& way, Scene scene);
Result finished(const Way& way, const std::string& text, const std::vector<std::string>& more = {});
Result finished(Simulation& simulation, std::vector<Observer*> observers = {});
/// The same; `look` is called with each step and may read its forces.
Result watch_steps(Simulation& simulation, const std::function<void(const Step&)>& look);

}  // namespace freeplay::test

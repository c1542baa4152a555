// A key of a scene as the parameter of variational equations: its value, and the scenes and systems at
// displaced values beside it (formulations/variation/sensitivity.hpp).
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "io/scene/scene_text.hpp"
#include "mechanism/scene.hpp"
#include "values/state.hpp"

namespace freeplay {

/// A scene with another value of a key, with its system.
struct DisplacedScene {
  explicit DisplacedScene(Scene s) : scene(std::move(s)), system(scene.mechanism) {}
  Scene scene;
  System system;
};
/// The displaced scenes of keys, each built once.
class DisplacedScenes {
 public:
  const DisplacedScene& at(const Parameter& key, double value) {
    auto& one = list_[{key.path(), value}];
    if (!one) one = std::make_unique<DisplacedScene>(key.at(value));
    return *one;
  }

 private:
  std::map<std::pair<std::string, double>, std::unique_ptr<DisplacedScene>> list_;
};

/// Start and end of a run as functions of a key.
struct VariedStart {
  State start;
  double end = 0;  ///< s
  /// (q, v, z) of the start in a displaced scene. A ModelError means that it has none.
  std::function<std::vector<double>(const Scene&, const System&)> of;
  /// s, end of the run in a displaced scene
  std::function<double(const Scene&, const System&)> end_of;
};

/// (q, v, z) of a state.
inline std::vector<double> all_of(const State& s) {
  auto all = s.q;
  all.insert(all.end(), s.v.begin(), s.v.end());
  all.insert(all.end(), s.z.begin(), s.z.end());
  return all;
}

/// The number `name` (KEY, or KEY[i] or KEY[i][j] within a list) as a property of the mechanism. Throws
/// ModelError if it is none.
Parameter property(const Scene& scene, const std::string& name, Family family);

/// Builds the displaced scenes of a key. A key at the end of its range, or one whose start cannot be
/// assembled beside it, has no derivative. The key refers to `displaced`. `share`: of the spacing of the
/// displaced values.
VariedKey vary(const Scene& scene, const System& system, const VariedStart& from, const std::string& name,
               Family family, DisplacedScenes& displaced, double share = 1);

}  // namespace freeplay

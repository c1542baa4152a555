// Scenes of verification/scenes and penalty methods by their names.
#pragma once

#include <string>

#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::test {

/// The text of a scene of verification/scenes.
inline std::string scene_named(const std::string& name) { return file_text(scene_file(name)); }

inline Result finished(const Way& way, const std::filesystem::path& scene,
                       const std::vector<std::string>& more = {}) {
  return finished(way, file_text(scene), more);
}

inline constexpr const char* adaptive_integrators[] = {"dopri5", "bulirsch_stoer", "adams_bashforth_moulton",
                                                       "rosenbrock4"};

/// The penalty formulation with an integrator.
inline Way penalty_by(const char* integrator) {
  return {integrator, Family::penalty, {}, 0, {std::string("penalty.integrator=") + integrator}};
}

/// Some methods, and the penalty formulation with each adaptive integrator.
inline std::vector<Way> with_integrators(std::vector<Way> ways) {
  for (const char* integrator : adaptive_integrators) ways.push_back(penalty_by(integrator));
  return ways;
}

}  // namespace freeplay::test

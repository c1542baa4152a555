#include "study/runs/near_pose.hpp"

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/identify.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/shared_results.hpp"

namespace freeplay {

std::vector<double> near_pose(const Scene& scene, const StopToken& stop) {
  using Start = RunOptions::Start;
  if (scene.run.start == Start::given || scene.run.start == Start::equilibrium) return {};
  try {
    auto ideal = idealised(scene.mechanism);
    ideal.assembly.approximate = true;  // stated positions may be those with clearance
    auto q = assemble(ideal, scene.run.start, nullptr, stop).q;
    const System system(ideal);
    const auto independent = static_cast<std::size_t>(system.rows()) - redundant_rows(system, q).size();
    if (independent < q.size()) return {};
    return q;
  } catch (const ModelError&) {
    // A scene that closes only with displaced joints: the caller that displaces them reports
    // errors.
    return {};
  }
}

std::vector<double> near_pose(const Scene& scene, const StopToken& stop, SharedResults& shared) {
  Scene ideal = scene;
  ideal.mechanism = idealised(scene.mechanism);
  ideal.instruments.clear();
  return shared.poses(identify(ideal, "penalty", false).digest(), [&] { return near_pose(scene, stop); });
}

}  // namespace freeplay

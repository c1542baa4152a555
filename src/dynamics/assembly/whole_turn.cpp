#include "dynamics/assembly/whole_turn.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

constexpr int places = 72;
constexpr double resolution = 1e-3;  // relative to an interval

/// Sum of the clearances of the joints (m).
double play(const Mechanism& m) {
  double sum = 0;
  for (const auto& joint : m.joints) {
    if (const auto* r = std::get_if<RevoluteJoint>(&joint); r && r->clearance) sum += r->clearance->radial;
    if (const auto* t = std::get_if<TranslationalJoint>(&joint); t && t->clearance)
      sum += t->clearance->half_play;
  }
  return sum;
}

}  // namespace

std::optional<DeadPoint> dead_point(const Mechanism& mechanism, double duration) {
  const auto* drive = main_drive(mechanism);
  if (!drive || drive->speed == 0 || mechanism.bodies.size() > most_followed) return {};
  const auto ideal = idealised(mechanism);
  const System system(ideal);
  std::vector<double> q;
  try {
    q = assemble(ideal, RunOptions::Start::ideal).q;
  } catch (const ModelError&) {
    return {};  // the run reports this error
  }
  const double length = std::max(system.longest_arm(), 1e-18), allowed = play(mechanism) + 1e-6 * length;
  const double turn = 2 * std::numbers::pi / std::abs(drive->speed);
  const double step = std::min(turn, duration) / places;
  const auto open_at = [&](double t, std::vector<double>& pose) -> std::optional<OpenJoint> {
    best_pose(system, length, true, pose, t);
    const auto open = open_joints(system, pose, length, t);
    if (open.empty()) return {};
    double gap = 0;  // the best pose distributes the gap over the joints of the loop
    for (const auto& o : open) gap += (o.angular ? length : 1) * o.amount;
    return gap > allowed ? std::optional(open.front()) : std::nullopt;
  };
  double t = 0;
  for (double h = step; t < places * step * (1 - 1e-9); h = std::min(step, 2 * h)) {
    auto pose = q;
    const double next = std::min(t + h, places * step);
    auto open = open_at(next, pose);
    while (open && h > resolution * step) {  // retry from nearer
      h /= 2;
      pose = q;
      open = open_at(t + h, pose);
    }
    if (open) return DeadPoint{t, std::abs(drive->speed) * t, *open};
    t = std::min(t + h, places * step);
    q = pose;
  }
  return {};
}

}  // namespace freeplay

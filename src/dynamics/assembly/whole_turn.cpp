#include "dynamics/assembly/whole_turn.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

constexpr int places = 72;
constexpr double most_unexpected = 0.3;  // rad, deviation of an angle from uniform motion

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

/// The greatest difference of a body's angle (rad) between two poses.
double most_turned(const System& system, const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (int c = 0; c < system.n(); ++c)
    if (system.is_angle(c)) most = std::max(most, std::abs(a[c] - b[c]));
  return most;
}

}  // namespace

FollowedTurn follow_turn(const System& system, std::vector<double> q, const Following& how) {
  constexpr int most_poses = 800;
  int poses = 0;
  const auto open_at = [&](double t, std::vector<double>& pose) -> std::optional<OpenJoint> {
    ++poses;
    best_pose(system, how.length, true, pose, t, {}, near_pose);
    const auto open = open_joints(system, pose, how.length, t);
    if (open.empty()) return {};
    double gap = 0;  // the best pose distributes the gap over the joints of the loop
    for (const auto& o : open) gap += (o.angular ? how.length : 1) * o.amount;
    return gap > how.allowed ? std::optional(open.front()) : std::nullopt;
  };
  const double step = std::abs(how.interval), sign = how.interval < 0 ? -1 : 1;
  const double all = how.intervals * step, least = how.resolution * step;
  FollowedTurn turn{{0}, {q}};
  double t = 0, last = 0;
  auto before = q;
  // The first intervals are short, so that fast gears are on the right tooth.
  for (double h = step / 64; t < all * (1 - 1e-9) && poses < most_poses; h = std::min(step, 2 * h)) {
    h = std::min(h, all - t);
    std::vector<double> expected(q), pose;
    std::optional<OpenJoint> open;
    const auto solve = [&] {
      for (std::size_t c = 0; c < q.size(); ++c)
        expected[c] = q[c] + (last > 0 ? (q[c] - before[c]) * h / last : 0);
      pose = expected;
      open = open_at(sign * (t + h), pose);
      // A pose far from the expected one may belong to another branch.
      return open || (last > 0 && most_turned(system, pose, expected) > most_unexpected);
    };
    while (solve() && h > least) h /= 2;
    if (open) {
      turn.open = open;
      return turn;
    }
    t += h, last = h;
    before = std::exchange(q, pose);
    turn.t.push_back(sign * t);
    turn.q.push_back(q);
  }
  return turn;
}

std::optional<DeadPoint> dead_point(const Mechanism& mechanism, double duration,
                                    std::optional<IdealStart>* start) {
  const auto* drive = main_drive(mechanism);
  if (!drive || drive->speed == 0 || mechanism.bodies.size() > most_followed) return {};
  const auto ideal = idealised(mechanism);
  const System system(ideal);
  IdealStart found;
  try {
    found.state = assemble(ideal, RunOptions::Start::ideal, &found.assumed);
  } catch (const ModelError&) {
    return {};  // the run reports this error
  }
  const double length = std::max(system.longest_arm(), 1e-18), allowed = play(mechanism) + 1e-6 * length;
  const double whole = 2 * std::numbers::pi / std::abs(drive->speed);
  const auto turn = follow_turn(system, found.state.q,
                                {.length = length,
                                 .allowed = allowed,
                                 .interval = std::min(whole, duration) / places,
                                 .intervals = places});
  if (start) *start = std::move(found);
  if (!turn.open) return {};
  return DeadPoint{turn.t.back(), std::abs(drive->speed) * turn.t.back(), *turn.open};
}

}  // namespace freeplay

#include "dynamics/assembly/mobility.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/joint_places.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/saddle_point.hpp"

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
    best_pose(system, how.length, true, pose, t);
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
  const System system(with_full_beams(ideal));  // beams limit no position
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

namespace {

using Row = std::vector<double>;

/// A coordinate with its gradient; an empty gradient: none.
struct Candidate {
  std::string name;
  Row row;
};

double product(const Row& a, const Row& b) {
  double sum = 0;
  for (std::size_t c = 0; c < a.size(); ++c) sum += a[c] * b[c];
  return sum;
}

Candidate of_joint(const Joint& joint, const std::vector<double>& q) {
  const auto pair = bodies_of(joint);
  Candidate found{{}, {}};
  const auto add = [&](int body, const Vec2& along, double turn) {
    if (body == ground) return;
    const auto c = static_cast<std::size_t>(planar::first(body));
    found.row[c] += along.x(), found.row[c + 1] += along.y(), found.row[c + 2] += turn;
  };
  if (std::holds_alternative<RevoluteJoint>(joint)) {
    found = {"rotation at " + name_of(joint), Row(q.size(), 0.0)};
    add(pair[0], {0, 0}, -1), add(pair[1], {0, 0}, 1);
  } else if (const auto* slider = std::get_if<TranslationalJoint>(&joint)) {
    found = {"sliding at " + name_of(joint), Row(q.size(), 0.0)};
    const Vec2 axis = place_of(q, pair[0], slider->axis) - place_of(q, pair[0], {0, 0});
    const auto arm = [&](int end) { return end_place(joint, end, q) - place_of(q, pair[end], {0, 0}); };
    add(pair[0], -axis, -cross(arm(0), axis)), add(pair[1], axis, cross(arm(1), axis));
  }
  return found;
}

std::vector<Candidate> candidates(const Mechanism& m, const std::vector<double>& q) {
  std::vector<Candidate> list;
  for (const bool with_ground : {true, false})
    for (const auto& joint : m.joints) {
      const auto pair = bodies_of(joint);
      if ((pair[0] == ground || pair[1] == ground) != with_ground) continue;
      if (auto found = of_joint(joint, q); !found.row.empty()) list.push_back(std::move(found));
    }
  for (std::size_t c = 0; c < q.size(); ++c) {
    list.push_back({fmt::format("{} of {}", planar::name(static_cast<int>(c)),
                                m.bodies[static_cast<std::size_t>(planar::body_of(c))].name),
                    Row(q.size(), 0.0)});
    list.back().row[c] = 1;
  }
  return list;
}

}  // namespace

UndrivenMotions undriven_motions(const Mechanism& mechanism, const std::vector<double>& q) {
  constexpr double tolerance = 1e-9;  // of the squared share of a response
  auto ideal = idealised(mechanism);
  ideal.loads.clear();
  const System system(ideal);
  auto e = system.make_evaluation();
  system.place(0, q.data(), e);
  SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic,
                     {!redundant_rows(system, q).empty()});
  UndrivenMotions found;
  if (!saddle.factor(e.G.data())) return found;
  const Row none(e.phi.size(), 0.0);
  Row lambda(e.phi.size());
  const auto response = [&](const Row& row) {
    Row a(q.size());
    saddle.solve(row.data(), none.data(), a.data(), lambda.data());
    return a;
  };
  std::vector<std::pair<Row, double>> held;  // responses, and their squares in the metric
  for (const auto& candidate : candidates(ideal, q)) {
    double all = 0;  // w M⁻¹ wᵀ
    for (std::size_t c = 0; c < q.size(); ++c) all += candidate.row[c] * candidate.row[c] / system.mass()[c];
    Row a = response(candidate.row);
    for (const auto& [one, square] : held) {
      // (a, one) in the metric of M
      double share = 0;
      for (std::size_t c = 0; c < q.size(); ++c) share += a[c] * system.mass()[c] * one[c];
      for (std::size_t c = 0; c < q.size(); ++c) a[c] -= share / square * one[c];
    }
    const double square = product(candidate.row, a);
    if (!(square > tolerance * all)) continue;
    found.coordinates.push_back(candidate.name);
    held.emplace_back(std::move(a), square);
  }
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b)
    for (std::size_t c = planar::coordinates * b; c < planar::coordinates * (b + 1); ++c) {
      double share = 0;
      for (const auto& [one, square] : held) share += one[c] * one[c] / square;
      if (share * system.mass()[c] > tolerance) {
        found.bodies.push_back(static_cast<int>(b));
        break;
      }
    }
  return found;
}

}  // namespace freeplay

#include "dynamics/assembly/turn_survey.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "dynamics/assembly/joint_places.hpp"
#include "dynamics/assembly/mobility.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

const Joint& joint_of(const Mechanism& m, int k) { return m.joints[static_cast<std::size_t>(k)]; }
bool is_pin(const Joint& joint) { return std::holds_alternative<RevoluteJoint>(joint); }
bool is_guide(const Joint& joint) { return std::holds_alternative<TranslationalJoint>(joint); }

/// Rows by which an ideal joint holds one body to the other, with those of its drives.
int rows_of(const Mechanism& m, int k) {
  const auto& joint = joint_of(m, k);
  const int own = is_pin(joint) || is_guide(joint) ? 2 : std::holds_alternative<RigidJoint>(joint) ? 3 : 1;
  return own + static_cast<int>(std::ranges::count_if(m.drives, [&](const Drive& d) {
           const auto* speed = std::get_if<SpeedDrive>(&d);
           const auto* motion = std::get_if<MotionDrive>(&d);
           return (speed && speed->joint == k) || (motion && motion->joint == k);
         }));
}

/// Two bodies with a common joint J that two bodies of known motion carry, by a pin or a guide each. A
/// massless rod and a guided or pinned body are a dyad, too. Known are the ground, the bodies of
/// prescribed motion, and in turn every body that joints to known bodies fix by three rows, and both
/// bodies of a dyad.
struct Dyad {
  int joint = -1;                ///< J: index into Mechanism::joints
  std::array<int, 2> bodies{};   ///< equal for a rod and a body
  std::array<int, 2> carried{};  ///< the joints that carry them; the rod itself for a rod
};

/// The search for the dyads of an ideal mechanism, beginning at the ground.
class Growth {
 public:
  explicit Growth(const Mechanism& m) : m_(m), known_(m.bodies.size(), 0) {}

  std::vector<Dyad> grow() {
    while (add_body() || add_dyad()) {
    }
    return std::move(found_);
  }

 private:
  bool known(int body) const { return body == ground || known_[static_cast<std::size_t>(body)]; }
  int joints() const { return static_cast<int>(m_.joints.size()); }
  /// Joints between a body and known bodies.
  std::vector<int> to_known(int body) const {
    std::vector<int> list;
    for (int k = 0; k < joints(); ++k) {
      const auto pair = bodies_of(joint_of(m_, k));
      if ((pair[0] == body && known(pair[1])) || (pair[1] == body && known(pair[0]))) list.push_back(k);
    }
    return list;
  }
  bool add_body() {
    for (int b = 0; b < static_cast<int>(m_.bodies.size()); ++b) {
      if (known(b)) continue;
      int rows = m_.bodies[static_cast<std::size_t>(b)].point ? 1 : 0, rod = -1, carrier = -1;
      for (const int k : to_known(b)) {
        rows += rows_of(m_, k);
        if (std::holds_alternative<RodJoint>(joint_of(m_, k))) rod = k;
        if (is_pin(joint_of(m_, k)) || is_guide(joint_of(m_, k))) carrier = k;
      }
      if (rows < 3) continue;
      if (rod >= 0 && carrier >= 0 && rows_of(m_, carrier) == 2)
        found_.push_back({rod, {b, b}, {rod, carrier}});
      known_[static_cast<std::size_t>(b)] = 1;
      return true;
    }
    return false;
  }
  bool add_dyad() {
    for (int J = 0; J < joints(); ++J) {
      const auto [i, j] = bodies_of(joint_of(m_, J));
      if (known(i) || known(j) || !(is_pin(joint_of(m_, J)) || is_guide(joint_of(m_, J)))) continue;
      const auto K = to_known(i), L = to_known(j);
      const auto carries = [&](const std::vector<int>& list) {
        return list.size() == 1 && (is_pin(joint_of(m_, list[0])) || is_guide(joint_of(m_, list[0])));
      };
      if (!carries(K) || !carries(L)) continue;
      if (is_pin(joint_of(m_, J))) found_.push_back({J, {i, j}, {K[0], L[0]}});
      known_[static_cast<std::size_t>(i)] = known_[static_cast<std::size_t>(j)] = 1;
      return true;
    }
    return false;
  }

  const Mechanism& m_;
  std::vector<char> known_;
  std::vector<Dyad> found_;
};

/// Transmission angle (rad, from 0 to π/2) of a dyad in the pose q.
double transmission_angle(const Mechanism& m, const Dyad& dyad, const std::vector<double>& q) {
  const auto end_on = [&](int joint, int body) {
    return end_place(joint_of(m, joint), bodies_of(joint_of(m, joint))[0] == body ? 0 : 1, q);
  };
  const Vec2 p = end_on(dyad.joint, dyad.bodies[1]);
  std::array<Vec2, 2> along;
  for (std::size_t n = 0; n < 2; ++n) {
    const auto& joint = joint_of(m, dyad.carried[n]);
    if (const auto* guide = std::get_if<TranslationalJoint>(&joint))
      along[n] = perp(place_of(q, guide->between[0], guide->axis) - place_of(q, guide->between[0], {0, 0}));
    else if (dyad.carried[n] == dyad.joint)  // the other end of a rod
      along[n] = end_place(joint, bodies_of(joint)[0] == dyad.bodies[1] ? 1 : 0, q) - p;
    else
      along[n] = end_on(dyad.carried[n], dyad.bodies[n]) - p;
  }
  return std::atan2(std::abs(cross(along[0], along[1])), std::abs(dot(along[0], along[1])));
}

constexpr double full_turn = 2 * std::numbers::pi;
constexpr int intervals = 72;
/// Greatest number of outputs and of dyads that are examined.
constexpr std::size_t most_examined = 4;
/// Dead centres that are located for each output.
constexpr std::size_t most_located = 8;

double relative_angle(const Joint& joint, const std::vector<double>& q) {
  const auto pair = bodies_of(joint);
  const auto angle = [&](int body) { return body == ground ? 0 : planar::angle(q.data(), body); };
  return angle(pair[1]) - angle(pair[0]);
}

/// Rate of the driven angle by the drives' time (rad/s).
struct Surveyed {
  Mechanism mechanism;
  double speed = 1;
};

/// The ideal mechanism in which the joint turns at a constant speed. Empty if other prescribed
/// motions then have no defined time.
std::optional<Surveyed> turning(const Mechanism& mechanism, int joint, const std::vector<double>& q) {
  Surveyed s{with_full_beams(idealised(mechanism))};  // beams limit no position
  auto& m = s.mechanism;
  m.loads.clear();
  const auto* drive = main_drive(m);
  if (drive && drive->joint == joint && drive->speed != 0) {
    s.speed = drive->speed;
    return s;
  }
  std::erase_if(m.drives, [&](const Drive& d) {
    const bool prescribed = std::holds_alternative<SpeedDrive>(d) || std::holds_alternative<MotionDrive>(d);
    return !prescribed || std::visit([&](const auto& x) { return x.joint == joint; }, d);
  });
  const bool timed = std::ranges::any_of(m.drives, [](const Drive& d) {
    const auto* motion = std::get_if<MotionDrive>(&d);
    const auto* speed = std::get_if<SpeedDrive>(&d);
    return (motion && motion->of < 0) || (speed && speed->speed != 0);
  });
  if (timed) return {};
  SpeedDrive turn;
  turn.name = name_of(m.joints[static_cast<std::size_t>(joint)]);
  turn.joint = joint;
  turn.speed = 1;
  turn.initial_angle = relative_angle(m.joints[static_cast<std::size_t>(joint)], q);
  m.drives.emplace_back(turn);
  return s;
}

/// Poses along the range of the driven angle, in increasing order, and solutions between them.
class Turn {
 public:
  Turn(const System& system, double length, double speed, double start)
      : system_(system), length_(length), speed_(speed), start_(start) {}

  void append(double t, const std::vector<double>& q) { samples_.emplace_back(start_ + speed_ * t, q); }
  /// Sorts the samples by the driven angle.
  void finish() {
    std::ranges::sort(samples_, {}, [](const auto& s) { return s.first; });
  }
  std::size_t size() const { return samples_.size(); }
  /// The samples at the start and a full turn from it, the lesser angle first; otherwise the ends.
  std::size_t first() const { return speed_ > 0 ? start_sample() : 0; }
  std::size_t last() const { return speed_ > 0 ? size() - 1 : start_sample(); }
  double angle(std::size_t i) const { return samples_[i].first; }
  const std::vector<double>& pose(std::size_t i) const { return samples_[i].second; }
  /// The pose at an angle between the neighbours of sample i.
  std::vector<double> pose_near(std::size_t i, double at) const {
    const std::size_t low = (at < angle(i) && i > 0) || i + 1 == size() ? i - 1 : i;
    const double share = (at - angle(low)) / (angle(low + 1) - angle(low));
    auto q = pose(low);
    for (std::size_t c = 0; c < q.size(); ++c) q[c] += share * (pose(low + 1)[c] - q[c]);
    best_pose(system_, length_, true, q, (at - start_) / speed_);
    return q;
  }

  /// Locates the greatest value of f(pose) between the neighbours of sample i.
  TurnExtreme locate(std::size_t i, const auto& f) const {
    constexpr double golden = 0.6180339887498949;
    constexpr int sections = 9;
    const std::size_t first = i > 0 ? i - 1 : i, last = std::min(i + 1, size() - 1);
    double a = angle(first), b = angle(last);
    const auto value = [&](double x) { return f(pose_near(i, x)); };
    double x = b - golden * (b - a), y = a + golden * (b - a);
    double fx = value(x), fy = value(y);
    for (int n = 0; n < sections; ++n) {
      if (fx > fy) {
        b = std::exchange(y, x), fy = fx;
        x = b - golden * (b - a), fx = value(x);
      } else {
        a = std::exchange(x, y), fx = fy;
        y = a + golden * (b - a), fy = value(y);
      }
    }
    // The vertex of the parabola through three points.
    const double middle = (a + b) / 2, h = (b - a) / 2;
    const double f0 = value(a), f1 = value(middle), f2 = value(b), bend = f0 - 2 * f1 + f2;
    TurnExtreme best{middle, f1};
    for (const auto& [at, found] : {std::pair{a, f0}, {b, f2}, {x, fx}, {y, fy}})
      if (found > best.value) best = {at, found};
    if (const double shift = h * (f0 - f2) / (2 * bend); bend < 0 && std::abs(shift) < h)
      if (const double found = value(middle + shift); found >= best.value) best = {middle + shift, found};
    return best;
  }

 private:
  std::size_t start_sample() const {
    const auto at = std::ranges::find(samples_, start_, [](const auto& s) { return s.first; });
    return static_cast<std::size_t>(at - samples_.begin());
  }

  const System& system_;
  double length_, speed_, start_;
  std::vector<std::pair<double, std::vector<double>>> samples_;
};

/// Position of a joint: its angle, or its place along its axis.
double coordinate(const Joint& joint, const std::vector<double>& q) {
  const auto* slider = std::get_if<TranslationalJoint>(&joint);
  if (!slider) return relative_angle(joint, q);
  const Vec2 axis = place_of(q, slider->between[0], slider->axis) - place_of(q, slider->between[0], {0, 0});
  return dot(axis, end_place(joint, 1, q) - end_place(joint, 0, q));
}

/// Joints of the ground, other than the driven one, whose position changes over the turn.
std::vector<OutputMotion> outputs_of(const Mechanism& m, const Turn& turn, int driven, double length) {
  std::vector<OutputMotion> list;
  for (std::size_t k = 0; k < m.joints.size() && list.size() < most_examined; ++k) {
    const auto& joint = m.joints[k];
    const auto pair = bodies_of(joint);
    const bool slides = std::holds_alternative<TranslationalJoint>(joint);
    if ((pair[0] != ground && pair[1] != ground) || static_cast<int>(k) == driven) continue;
    if (!slides && !std::holds_alternative<RevoluteJoint>(joint)) continue;
    std::vector<double> s;
    for (std::size_t i = 0; i < turn.size(); ++i) s.push_back(coordinate(joint, turn.pose(i)));
    auto [low, high] = std::ranges::minmax(s);
    if (!(high - low > 1e-6 * (slides ? length : 1))) continue;  // at rest
    OutputMotion output;
    output.joint = name_of(joint), output.slides = slides;
    for (std::size_t i = 1; i + 1 < s.size() && output.dead_centres.size() < most_located; ++i) {
      const double before = s[i - 1], here = s[i], after = s[i + 1];
      const double sign = here > before && here >= after ? 1 : here < before && here <= after ? -1 : 0;
      if (sign == 0) continue;
      auto found = turn.locate(i, [&](const auto& q) { return sign * coordinate(joint, q); });
      found.value *= sign;
      low = std::min(low, found.value), high = std::max(high, found.value);
      // The first interval of a full turn repeats the last.
      if (std::ranges::none_of(output.dead_centres, [&](const TurnExtreme& d) {
            return std::abs(std::remainder(d.angle - found.angle, full_turn)) < 1e-3;
          }))
        output.dead_centres.push_back(found);
    }
    output.travel = high - low;
    if (!slides) output.turns = (s[turn.last()] - s[turn.first()]) / full_turn;
    list.push_back(std::move(output));
  }
  return list;
}

std::vector<TransmissionAngle> transmission_of(const Mechanism& m, const Turn& turn) {
  std::vector<TransmissionAngle> list;
  for (const auto& dyad : Growth(m).grow()) {
    if (list.size() == most_examined) break;
    const auto extreme = [&](double sign) {
      const auto f = [&](const auto& q) { return sign * transmission_angle(m, dyad, q); };
      std::size_t most = 0;
      for (std::size_t i = 1; i < turn.size(); ++i)
        if (f(turn.pose(i)) > f(turn.pose(most)) + 1e-12) most = i;
      const TurnExtreme sample{turn.angle(most), f(turn.pose(most))};
      auto found = turn.locate(most, f);
      if (!(found.value > sample.value + 1e-12)) found = sample;
      found.value *= sign;
      return found;
    };
    list.push_back({name_of(m.joints[static_cast<std::size_t>(dyad.joint)]), extreme(-1), extreme(1)});
  }
  return list;
}

}  // namespace

std::optional<TurnSurvey> survey_turn(const Mechanism& mechanism, const std::vector<double>& start) {
  const int joint = crank_joint(mechanism);
  if (joint < 0 || mechanism.bodies.size() > most_followed) return {};
  const auto turned = turning(mechanism, joint, start);
  if (!turned) return {};
  const auto& m = turned->mechanism;
  const System system(m);
  const double length = std::max(system.longest_arm(), 1e-18);
  auto q = start;
  best_pose(system, length, true, q);
  Following how{.length = length,
                .allowed = 1e-6 * length,
                .interval = full_turn / std::abs(turned->speed) / intervals,
                .intervals = intervals,
                .resolution = 1e-6};
  double gap = 0;
  for (const auto& o : open_joints(system, q, length)) gap += (o.angular ? length : 1) * o.amount;
  if (!(gap <= how.allowed)) return {};

  const auto& crank = m.joints[static_cast<std::size_t>(joint)];
  Turn turn(system, length, turned->speed, relative_angle(crank, q));
  const auto forward = follow_turn(system, q, how);
  TurnSurvey survey;
  survey.joint = name_of(crank);
  survey.full = !forward.open;
  // Of a full turn, one interval before the start, so that extrema at the start are inside.
  how.interval = -how.interval;
  if (survey.full) how.intervals = 1;
  const auto back = follow_turn(system, q, how);
  for (std::size_t i = 0; i < forward.t.size(); ++i) turn.append(forward.t[i], forward.q[i]);
  for (std::size_t i = 1; i < back.t.size(); ++i) turn.append(back.t[i], back.q[i]);
  turn.finish();
  survey.lower = turn.angle(0), survey.upper = turn.angle(turn.size() - 1);
  const bool rises = turned->speed > 0;
  survey.below = rises ? back.open : forward.open;
  survey.above = rises ? forward.open : back.open;
  survey.outputs = outputs_of(m, turn, joint, length);
  survey.transmission = transmission_of(m, turn);
  return survey;
}

}  // namespace freeplay

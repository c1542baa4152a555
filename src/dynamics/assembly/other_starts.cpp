#include "dynamics/assembly/other_starts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

#include "dynamics/assembly/joint_places.hpp"

namespace freeplay {
namespace {

constexpr std::size_t most_dyads = 5;
constexpr int most_drawn = 48;
constexpr std::size_t most_work = 4000;  // bodies times poses

const Joint& joint_at(const Mechanism& m, int k) { return m.joints[static_cast<std::size_t>(k)]; }

/// The end of a joint that is on the body.
int end_in(const Joint& joint, int body) { return bodies_of(joint)[0] == body ? 0 : 1; }

/// The relative angle (rad), θ of the second body minus θ of the first, if a joint or its drive
/// fixes it, or a ratio to such a joint. Returns false if the joint turns freely.
bool held_angle(const Mechanism& m, int joint, double& angle, int most_ratios = 8) {
  const bool held = std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.angle + 0.0; }) {
          angle = j.angle;
          return true;
        } else {
          return false;
        }
      },
      joint_at(m, joint));
  if (held) return true;
  for (const auto& other : m.joints)
    if (const auto* r = std::get_if<RatioJoint>(&other); r && most_ratios > 0 && r->joint == joint &&
                                                         !r->slider(m) &&
                                                         held_angle(m, r->of, angle, most_ratios - 1)) {
      angle = r->ratio * angle + r->offset;
      return true;
    }
  for (const auto& drive : m.drives)
    if (std::visit(
            [&](const auto& d) {
              if constexpr (requires { d.initial_angle + 0.0; }) {
                if (d.joint != joint) return false;
                angle = d.initial_angle;
                return true;
              } else {
                return false;
              }
            },
            drive))
      return true;
  return false;
}

/// The direction, in the world, in which a joint lets its second body slide; zero if it does not.
Vec2 slide_of(const Joint& joint, const std::vector<double>& q) {
  return std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.axis.x(); })
          return place_of(q, j.between[0], j.axis) - place_of(q, j.between[0], {0, 0});
        else
          return Vec2{0, 0};
      },
      joint);
}

void put(std::vector<double>& q, int body, const Vec2& position, double angle) {
  const auto c = static_cast<std::size_t>(planar::first(body));
  q[c] = position.x();
  q[c + 1] = position.y();
  q[c + 2] = angle;
}

/// Places a body so that its end of `joint` is at `p`.
void hang(std::vector<double>& q, int body, const Joint& joint, const Vec2& p, double angle) {
  put(q, body, {0, 0}, angle);
  put(q, body, p - place_of(q, body, end_of(joint, end_in(joint, body))), angle);
}

double fraction(double x) { return x - std::floor(x); }

/// The place of a joint's other end, if another body that is placed carries it.
std::optional<Vec2> carried(const Mechanism& m, const std::vector<char>& placed, int k, int end,
                            const std::vector<double>& q) {
  const auto& joint = joint_at(m, k);
  const int other = bodies_of(joint)[1 - end];
  if (!std::holds_alternative<RevoluteJoint>(joint) ||
      (other != ground && !placed[static_cast<std::size_t>(other)]))
    return std::nullopt;
  return end_place(joint, 1 - end, q);
}

/// Attaches all bodies without a stated position that joints connect with placed ones, first the
/// ground and the bodies of stated position and angle, each to one nearer to them. The angle of a body
/// is its stated one, that of a joint or drive, that of a second pin whose place is known, or
/// angle_of(body); bodies of the last kind wait for the others. Guides come last, because they leave a
/// displacement open: slide_by(body). Bodies of stated position get such an angle likewise.
std::vector<double> hang_all(const Mechanism& m, std::vector<double> q, const auto& angle_of,
                             const auto& slide_by) {
  const auto body_at = [&](int b) -> const Body& { return m.bodies[static_cast<std::size_t>(b)]; };
  std::vector<char> placed(m.bodies.size(), 0);
  for (std::size_t b = 0; b < placed.size(); ++b)
    placed[b] = m.bodies[b].position && (m.bodies[b].angle || m.bodies[b].point);
  const auto before = [&](int body) { return body == ground || placed[static_cast<std::size_t>(body)]; };
  /// Angle of a body about `from` of its frame at p, from another pin of it that fits so.
  const auto angle_about = [&](int body, const Vec2& from, const Vec2& p, double fits,
                               double otherwise) -> std::optional<double> {
    for (std::size_t k = 0; k < m.joints.size(); ++k) {
      const auto& joint = m.joints[k];
      const int end = end_in(joint, body);
      if (bodies_of(joint)[end] != body) continue;
      const auto place = carried(m, placed, static_cast<int>(k), end, q);
      if (!place) continue;
      const Vec2 arm = end_of(joint, end) - from, line = *place - p;
      if (arm.is_zero() || line.is_zero()) continue;
      if (std::abs(line.norm() - arm.norm()) > fits * arm.norm()) continue;
      const Vec2 turned{std::cos(otherwise), std::sin(otherwise)};
      const Vec2 now{turned.x() * arm.x() - turned.y() * arm.y(),
                     turned.y() * arm.x() + turned.x() * arm.y()};
      if ((now - line).norm() <= 1e-9 * arm.norm()) return otherwise;  // keeps its digits
      return std::atan2(cross(arm, line), dot(arm, line));
    }
    return std::nullopt;
  };
  enum class Which { known_angles, any_angle, guides };
  const auto attach = [&](Which which) {
    bool more = false;
    auto now = placed;
    for (std::size_t k = 0; k < m.joints.size(); ++k) {
      const auto& joint = m.joints[k];
      if (std::holds_alternative<GearJoint>(joint) || std::holds_alternative<RackJoint>(joint) ||
          std::holds_alternative<RatioJoint>(joint))
        continue;
      const auto pair = bodies_of(joint);
      if (before(pair[0]) == before(pair[1])) continue;
      const int end = before(pair[0]) ? 1 : 0, body = pair[end], hung_on = pair[1 - end];
      const Vec2 slide = slide_of(joint, q);
      const auto& facts = body_at(body);
      if (now[static_cast<std::size_t>(body)] ||
          (!slide.is_zero() && !facts.position && which != Which::guides))
        continue;
      double relative = 0;
      const double otherwise = angle_of(body);
      auto known = facts.angle;
      if (!known && held_angle(m, static_cast<int>(k), relative))
        known =
            (hung_on == ground ? 0 : planar::angle(q.data(), hung_on)) + (end == 1 ? relative : -relative);
      else if (!known && facts.position)
        known = angle_about(body, {0, 0}, *facts.position, INFINITY, otherwise).value_or(otherwise);
      else if (!known && std::holds_alternative<RevoluteJoint>(joint))
        known = angle_about(body, end_of(joint, end), end_place(joint, 1 - end, q), 1e-6, otherwise);
      if (!known && which == Which::known_angles) continue;
      const double angle = known.value_or(otherwise);
      now[static_cast<std::size_t>(body)] = 1;
      more = true;
      if (facts.position) {
        put(q, body, *facts.position, angle);
        continue;
      }
      hang(q, body, joint, end_place(joint, 1 - end, q), angle);
      if (const auto* rod = std::get_if<RodJoint>(&joint))
        hang(q, body, joint,
             end_place(joint, 1 - end, q) + rod->length * Vec2{std::cos(angle), std::sin(angle)}, angle);
      if (!slide.is_zero())
        hang(q, body, joint, end_place(joint, 1 - end, q) + slide_by(body) * slide, angle);
    }
    placed = now;
    return more;
  };
  while (attach(Which::known_angles) || attach(Which::any_angle) || attach(Which::guides)) {
  }
  return q;
}

}  // namespace

std::vector<double> hung(const Mechanism& m, const std::vector<double>& q) {
  return hang_all(
      m, q, [&](int body) { return planar::angle(q.data(), body); }, [](int) { return 0.0; });
}

bool states_pose(const Mechanism& m) {
  return std::ranges::any_of(m.bodies, [](const Body& b) { return b.position || b.angle; }) ||
         std::ranges::any_of(m.drives, [](const Drive& drive) {
           return std::visit(
               [](const auto& d) {
                 if constexpr (requires { d.initial_angle != 0; })
                   return d.initial_angle != 0;
                 else
                   return false;
               },
               drive);
         });
}

void unwind(const Mechanism& m, const std::vector<double>& given, std::vector<double>& q) {
  std::vector<char> held(m.bodies.size(), 0);
  for (std::size_t k = 0; k < m.joints.size(); ++k) {
    double angle = 0;
    // A ratio couples full turns, too.
    if (held_angle(m, static_cast<int>(k), angle) || std::holds_alternative<RatioJoint>(m.joints[k]))
      for (const int body : bodies_of(m.joints[k]))
        if (body != ground) held[static_cast<std::size_t>(body)] = 1;
  }
  for (std::size_t b = 0; b < held.size(); ++b) {
    auto& angle = q[planar::first(b) + 2];
    const double turns = std::round((angle - planar::angle(given.data(), b)) / (2 * std::numbers::pi));
    if (!held[b] && turns != 0) angle -= 2 * std::numbers::pi * turns;
  }
}

OtherStarts::OtherStarts(const Mechanism& mechanism, std::vector<double> near, double length)
    : m_(mechanism), near_(std::move(near)), length_(length) {
  find_dyads();
  for (unsigned set = 1; set < (1U << dyads_.size()); ++set) order_.push_back(set);
  std::ranges::stable_sort(order_, {}, [](unsigned set) { return std::popcount(set); });
  const auto bodies = std::max<std::size_t>(1, m_.bodies.size());
  const int most = std::max(4, static_cast<int>(most_work / bodies));
  flips_ = std::min(static_cast<int>(order_.size()), most);
  drawn_ = std::min(most_drawn, most);
}

void OtherStarts::find_dyads() {
  std::vector<std::vector<int>> of(m_.bodies.size());
  for (std::size_t k = 0; k < m_.joints.size(); ++k)
    for (const int body : bodies_of(m_.joints[k]))
      if (body != ground) of[static_cast<std::size_t>(body)].push_back(static_cast<int>(k));
  const auto another = [&](int body, int J, int not_to) {
    for (const int k : of[static_cast<std::size_t>(body)]) {
      const auto pair = bodies_of(joint_at(m_, k));
      if (k != J && pair[0] != not_to && pair[1] != not_to) return k;
    }
    return -1;
  };
  for (std::size_t k = 0; k < m_.joints.size() && dyads_.size() < most_dyads; ++k) {
    const auto [i, j] = bodies_of(m_.joints[k]);
    double angle = 0;
    const auto J = static_cast<int>(k);
    if (i == ground || j == ground || held_angle(m_, J, angle)) continue;
    const int K = another(i, J, j), L = another(j, J, i);
    // A link whose angle to the ground is driven cannot be mirrored.
    if (K < 0 || L < 0 || (held_angle(m_, K, angle) && slide_of(joint_at(m_, K), near_).is_zero()) ||
        (held_angle(m_, L, angle) && slide_of(joint_at(m_, L), near_).is_zero()))
      continue;
    dyads_.push_back({i, j, J, K, L});
  }
}

void OtherStarts::turn_over(const Dyad& d, std::vector<double>& q) const {
  const Joint &J = joint_at(m_, d.J), &K = joint_at(m_, d.K), &L = joint_at(m_, d.L);
  const Vec2 p = joint_place(J, q), k = end_place(K, end_in(K, d.i), q), l = end_place(L, end_in(L, d.j), q);
  const Vec2 along_k = slide_of(K, q), along_l = slide_of(L, q);
  // The mirror line passes through a fixed joint or, for a slider, is perpendicular to its guide.
  const Vec2 from = !along_k.is_zero() ? l : k;
  const Vec2 line = !along_l.is_zero() ? perp(along_l) : !along_k.is_zero() ? perp(along_k) : l - k;
  if (!(line.squared_norm() > 0)) return;
  const Vec2 r = p - from, mirrored = from + 2 * (dot(r, line) / line.squared_norm()) * line - r;
  const auto move = [&](int body, const Joint& other, const Vec2& pivot, bool slides) {
    double angle = planar::angle(q.data(), body);
    if (!slides) {
      const Vec2 before = p - pivot, after = mirrored - pivot;
      angle += std::atan2(cross(before, after), dot(before, after));
      hang(q, body, other, pivot, angle);
    } else {
      hang(q, body, J, mirrored, angle);
    }
  };
  move(d.i, K, k, !along_k.is_zero());
  move(d.j, L, l, !along_l.is_zero());
}

std::vector<double> OtherStarts::drawn(int n) const {
  // φ for as many dimensions as bodies: φ^(d+1) = φ + 1, by fixed-point iteration.
  const auto bodies = static_cast<int>(m_.bodies.size());
  double phi = 2;
  for (int i = 0; i < 60; ++i) phi = std::pow(1 + phi, 1.0 / (bodies + 1));
  const auto share = [&](int body) { return fraction(0.5 + (n + 1) * std::pow(phi, -(body + 1))); };
  return hang_all(
      m_, near_, [&](int body) { return 2 * std::numbers::pi * share(body); },
      [&](int body) { return length_ * (2 * share(body) - 1); });
}

std::vector<double> OtherStarts::pose(int n) const {
  if (n >= flips_) return drawn(n - flips_);
  auto q = near_;
  for (std::size_t d = 0; d < dyads_.size(); ++d)
    if (order_[static_cast<std::size_t>(n)] & (1U << d)) turn_over(dyads_[d], q);
  return q;
}

std::string OtherStarts::what(int n) const {
  if (n >= flips_) return fmt::format("random angles, set {} of {}", n - flips_ + 1, drawn_);
  std::string names;
  for (std::size_t d = 0; d < dyads_.size(); ++d)
    if (order_[static_cast<std::size_t>(n)] & (1U << d))
      names += fmt::format("{}{} and {}", names.empty() ? "" : ", ",
                           m_.bodies[static_cast<std::size_t>(dyads_[d].i)].name,
                           m_.bodies[static_cast<std::size_t>(dyads_[d].j)].name);
  return names + " mirrored";
}

}  // namespace freeplay

#include "dynamics/assembly/four_bar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dynamics/assembly/joint_places.hpp"
#include "mechanism/configuration.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

constexpr std::size_t most_loops = 1000;

/// A revolute joint from the viewpoint of one of its bodies.
struct Side {
  int joint, other, end;  ///< `end`: the end of the joint on that body
};

std::vector<std::vector<Side>> sides_of(const Mechanism& m) {
  std::vector<std::vector<Side>> sides(m.bodies.size() + 1);  // the ground first
  for (std::size_t k = 0; k < m.joints.size(); ++k)
    if (std::holds_alternative<RevoluteJoint>(m.joints[k])) {
      const auto pair = bodies_of(m.joints[k]);
      for (const int end : {0, 1})
        sides[static_cast<std::size_t>(pair[end]) + 1].push_back({static_cast<int>(k), pair[1 - end], end});
    }
  return sides;
}

bool is_driven(const Mechanism& m, int joint) {
  return std::ranges::any_of(m.drives, [&](const Drive& drive) {
    return std::visit([&](const auto& d) { return d.joint == joint; }, drive);
  });
}

/// The point of a joint in the frame of one of its bodies.
Vec2 point_in(const Mechanism& m, int joint, int body) {
  const auto& j = m.joints[static_cast<std::size_t>(joint)];
  return end_of(j, bodies_of(j)[0] == body ? 0 : 1);
}

std::string body_name(const Mechanism& m, int body) {
  return body == ground ? "ground" : m.bodies[static_cast<std::size_t>(body)].name;
}

FourBar loop_of(const Mechanism& m, std::array<int, 4> joints, std::array<int, 4> bodies) {
  const auto [A, B, C, D] = joints;
  const bool backwards = is_driven(m, D) != is_driven(m, A) ? is_driven(m, D) : D < A;
  FourBar loop{joints, bodies, {}};
  if (backwards) {
    loop.joints = {D, C, B, A};
    loop.bodies = {bodies[0], bodies[3], bodies[2], bodies[1]};
  }
  const auto link = [&](int body, int a, int b) {
    return (point_in(m, a, body) - point_in(m, b, body)).norm();
  };
  const auto& j = loop.joints;
  const auto& b = loop.bodies;
  loop.lengths = {link(b[0], j[0], j[3]), link(b[1], j[0], j[1]), link(b[2], j[1], j[2]),
                  link(b[3], j[2], j[3])};
  return loop;
}

/// Indices of the links from the shortest to the longest. Among equal links the fixed one counts as
/// the shortest, then the order applies.
std::array<int, 4> by_length(const FourBar& loop) {
  std::array<int, 4> order{0, 1, 2, 3};
  std::ranges::stable_sort(order, {}, [&](int i) { return loop.lengths[static_cast<std::size_t>(i)]; });
  return order;
}
double length(const FourBar& loop, int link) { return loop.lengths[static_cast<std::size_t>(link)]; }

}  // namespace

double FourBar::shortest_and_longest() const {
  const auto o = by_length(*this);
  return length(*this, o[0]) + length(*this, o[3]);
}
double FourBar::other_two() const {
  const auto o = by_length(*this);
  return length(*this, o[1]) + length(*this, o[2]);
}

std::vector<FourBar> four_bars(const Mechanism& m) {
  const auto sides = sides_of(m);
  std::vector<FourBar> loops;
  const auto at = [&](int body) -> const std::vector<Side>& {
    return sides[static_cast<std::size_t>(body) + 1];
  };
  // The first body of a loop has the least index of its four. A path from a body with many joints,
  // such as the ground, is therefore abandoned as soon as it returns to that body.
  for (int fixed = ground; fixed < static_cast<int>(m.bodies.size()); ++fixed)
    for (const auto& A : at(fixed)) {
      if (A.other < fixed) continue;
      for (const auto& B : at(A.other)) {
        if (B.other <= fixed || B.other == A.other) continue;
        for (const auto& C : at(B.other)) {
          if (C.other <= fixed || C.other == A.other) continue;
          for (const auto& D : at(C.other)) {
            if (D.other != fixed || A.joint >= D.joint) continue;
            const std::array<int, 4> bodies{fixed, A.other, B.other, C.other};
            const auto loop = loop_of(m, {A.joint, B.joint, C.joint, D.joint}, bodies);
            if (std::ranges::all_of(loop.lengths, [](double l) { return l > 0; })) loops.push_back(loop);
            if (loops.size() == most_loops) return loops;
          }
        }
      }
    }
  return loops;
}

Grashof type_of(const FourBar& loop) {
  const double outer = loop.shortest_and_longest(), inner = loop.other_two(), sum = outer + inner;
  const auto order = by_length(loop);
  const double longest = length(loop, order[3]);
  if (longest - (sum - longest) > 1e-9 * sum) return Grashof::unclosable;
  if (std::abs(outer - inner) <= 1e-9 * sum) return Grashof::change_point;
  if (outer > inner) return Grashof::triple_rocker;
  if (order[0] == 0) return Grashof::double_crank;
  return order[0] == 2 ? Grashof::double_rocker : Grashof::crank_rocker;
}

std::string describe(const Mechanism& m, const FourBar& loop, Grashof type) {
  const auto shortest = body_name(m, loop.bodies[static_cast<std::size_t>(by_length(loop)[0])]);
  switch (type) {
    case Grashof::crank_rocker:
      return fmt::format("crank-rocker: {}, the shortest link, makes full turns", shortest);
    case Grashof::double_crank:
      return fmt::format("double-crank: {} is the shortest link, and both adjacent links make full turns",
                         shortest);
    case Grashof::double_rocker:
      return fmt::format("double-rocker: {}, the coupler, is the shortest link and makes full turns",
                         shortest);
    case Grashof::change_point:
      return "change point: the links can align and continue open or crossed from there";
    case Grashof::triple_rocker:
      return "double-rocker (triple-rocker): no link makes full turns";
    case Grashof::unclosable:
      break;
  }
  return "cannot close: " + too_long(m, loop);
}

std::string too_long(const Mechanism& m, const FourBar& loop) {
  if (type_of(loop) != Grashof::unclosable) return "";
  const int longest = by_length(loop)[3];
  const double l = length(loop, longest),
               others = std::accumulate(loop.lengths.begin(), loop.lengths.end(), 0.0) - l;
  return fmt::format("link {} of {:.6g} m is {:.4g} m longer than the other three of its loop together",
                     body_name(m, loop.bodies[static_cast<std::size_t>(longest)]), l, l - others);
}

double openness(const Mechanism& m, const FourBar& loop, const std::vector<double>& q) {
  std::array<Vec2, 4> p;
  for (std::size_t i = 0; i < 4; ++i)
    p[i] = joint_place(m.joints[static_cast<std::size_t>(loop.joints[i])], q);
  const Vec2 line = p[3] - p[1];
  return -cross(line, p[0] - p[1]) * cross(line, p[2] - p[1]);
}

namespace {

/// The vectors from B to A and from B to C.
std::array<Vec2, 2> legs(const Mechanism& m, const JointAngle& angle, const std::vector<double>& q) {
  std::array<Vec2, 3> p;
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = joint_place(m.joints[static_cast<std::size_t>(angle.joints[i])], q);
  return {p[0] - p[1], p[2] - p[1]};
}

}  // namespace

double sine_of(const Mechanism& m, const JointAngle& angle, const std::vector<double>& q) {
  const auto [a, c] = legs(m, angle, q);
  const double product = a.norm() * c.norm();
  return product > 0 ? cross(a, c) / product : 0;
}

double angle_of(const Mechanism& m, const JointAngle& angle, const std::vector<double>& q) {
  const auto [a, c] = legs(m, angle, q);
  return std::atan2(cross(a, c), dot(a, c));
}

std::string spelt(const Mechanism& m, const JointAngle& angle) {
  std::string text;
  for (const int j : angle.joints)
    text += (text.empty() ? "" : "-") + name_of(m.joints[static_cast<std::size_t>(j)]);
  return text;
}

Mismatch mismatch(const Mechanism& m, const std::vector<double>& q) {
  const auto& requested = m.assembly;
  if (requested.branch) {
    const auto loops = four_bars(m);
    if (loops.size() != 1)
      throw ModelError(
          "assembly.branch",
          fmt::format("needs exactly one four-bar loop (four bodies and four revolute joints), and there "
                      "{}; give an angle of the pose in assembly.positive or .negative",
                      loops.empty() ? "is none" : fmt::format("are {}", loops.size())));
    const bool open = openness(m, loops[0], q) > 0;
    if (open != (*requested.branch == Configuration::Branch::open))
      return {"assembly.branch", fmt::format("\"{}\" is requested, but the pose found is {}",
                                             text_of(*requested.branch), open ? "open" : "crossed")};
  }
  const auto signs = [&](const char* key, const std::vector<JointAngle>& angles, double sign) -> Mismatch {
    for (const auto& angle : angles)
      if (!(sign * sine_of(m, angle, q) > 0))
        return {fmt::format("assembly.{}", key), fmt::format("angle {} is {:.4g} rad in the pose found",
                                                             spelt(m, angle), angle_of(m, angle, q))};
    return {};
  };
  if (auto wrong = signs("positive", requested.positive, 1); !wrong.key.empty()) return wrong;
  return signs("negative", requested.negative, -1);
}

}  // namespace freeplay

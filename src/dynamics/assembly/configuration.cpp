#include "mechanism/configuration.hpp"

#include <fmt/format.h>

#include <cmath>

#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/assembly/joint_places.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
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

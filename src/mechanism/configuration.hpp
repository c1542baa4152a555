// The requested pose of a mechanism that can be assembled in several ways. For a four-bar loop it
// is the open or the crossed branch (dynamics/assembly/four_bar.hpp). For any other loop it is the
// sign of angles A-B-C between joints: the angle at B from BA to BC, counterclockwise, between −π
// and π.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mechanism/keys.hpp"

namespace freeplay {

struct Mechanism;

/// The angle at joint `joints[1]`.
struct JointAngle {
  std::array<int, 3> joints{};  ///< indices into Mechanism::joints
};

/// Choice between the poses in which a mechanism can be assembled.
struct Configuration {
  /// Assembly branch of a closed loop.
  enum class Branch { open, crossed };
  static constexpr std::string_view what = "[assembly]";
  std::optional<Branch> branch = {};                     ///< of the only four-bar loop
  std::vector<JointAngle> positive = {}, negative = {};  ///< angles required to have this sign
  bool approximate = false;  ///< stated initial values may change by more than 1 % of their scale

  /// Whether anything is requested.
  bool asks() const { return branch || !positive.empty() || !negative.empty() || approximate; }

  static void keys(auto& k, auto& c) {
    k.choose({"branch", "", "pose of the mechanism's only four-bar loop: "}, c.branch);
    k.angles(
        {"positive", "",
         "list of angles \"A-B-C\" at joint B, from joint A to joint C counterclockwise, that are positive "
         "in the requested pose"},
        c.positive);
    k.angles({"negative", "", "likewise, angles that are negative"}, c.negative);
    k.flag({"approximate", "",
            "true: stated initial values are approximate, and the start changes them as little as possible; "
            "false: a change by more than 1 % is refused"},
           c.approximate);
  }
};

inline constexpr auto branch_names = complete<Configuration::Branch>(
    {{Configuration::Branch::open, "open",
      "the first pivot and the coupler's far joint on either side of the line between the other two"},
     {Configuration::Branch::crossed, "crossed", "on the same side"}});
constexpr std::span<const Choice<Configuration::Branch>> choices(Configuration::Branch) {
  return branch_names;
}

/// Sine of a named angle in a pose; 0 if two of its joints coincide.
double sine_of(const Mechanism& mechanism, const JointAngle& angle, const std::vector<double>& q);
/// The angle (rad), between −π and π.
double angle_of(const Mechanism& mechanism, const JointAngle& angle, const std::vector<double>& q);
/// The angle's name "A-B-C".
std::string spelt(const Mechanism& mechanism, const JointAngle& angle);

/// A difference between a pose and the requested one: the key and a description. Both are empty if
/// the pose is as requested.
struct Mismatch {
  /// key of the scene, and description
  std::string key, what;
};
/// The first difference between the pose q (Shapes: freeplay.hpp) and the requested one.
Mismatch mismatch(const Mechanism& mechanism, const std::vector<double>& q);

}  // namespace freeplay

// Ranges of outputs of a mechanism within its clearances.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace freeplay {

/// An output coordinate: a coordinate of a body or of one of its points, a distance of two points, or the
/// angle or position of a joint.
struct PlayOutput {
  /// What the coordinate is.
  enum class Kind { x, y, angle, distance, slide };
  std::string name;     ///< as it was asked for
  Kind kind = Kind::x;  ///< determines the unit
  /// Whether the unit is rad.
  bool is_angle() const { return kind == Kind::angle; }
  /// Of all values of the output.
  const char* unit() const { return is_angle() ? "rad" : "m"; }
  /// The name in tables, whose names have no commas: distance:P:Q for distance(P, Q).
  std::string column() const {
    if (kind != Kind::distance) return name;
    std::string text;
    for (const char c : name) {
      if (c == '(' || c == ',')
        text += ':';
      else if (c != ' ' && c != ')')
        text += c;
    }
    return text;
  }
};

/// A loose joint, or a pair of its opposite contacts.
struct PlayClearance {
  std::string joint;     ///< name
  std::string part;      ///< of a slider: rear or front
  bool disc = false;     ///< a revolute joint; otherwise two opposite contacts
  double clearance = 0;  ///< m: radius of the disc; half of the sum of the gaps at the first pose
};

/// A tolerance that quantiles contain.
struct PlayTolerance {
  std::string key;           ///< of the number
  double lower = 0;          ///< limit of the deviation, in the unit of the key
  double upper = 0;          ///< limit of the deviation, in the unit of the key
  std::string distribution;  ///< uniform, normal or truncated
};

/// Where journals and teeth are.
enum class PlayPlace { within, rim };

/// Random places of journals and teeth.
struct PlaySampling {
  int samples = 0;                      ///< number of random states of the joints; 0: none
  PlayPlace place = PlayPlace::within;  ///< uniform within the clearances, or at their rim
};

/// Shares of the quantiles: median, 95 % and, for a normal distribution, three standard deviations.
inline constexpr std::array<double, 5> play_shares{0.00135, 0.025, 0.5, 0.975, 0.99865};

/// Quantiles of an output at one position.
struct PlayQuantiles {
  std::array<double, 5> value{};  ///< at play_shares
  std::array<double, 5> error{};  ///< their standard errors
  int failed = 0;                 ///< samples that did not close; 0 within a region
};

/// Range of one output at one position, in m or rad.
struct PlayRange {
  double ideal = 0;           ///< value without clearances
  double linear = 0;          ///< sum of the influences of all joints to first order
  double least = 0;           ///< found within the clearances
  double greatest = 0;        ///< found within the clearances
  double bound_least = 0;     ///< no position within the clearances is below
  double bound_greatest = 0;  ///< no position within the clearances is above
  std::vector<double> parts;  ///< of the components in greatest − least
  /// of the components and the tolerances in the variance to first order; they sum to 1
  std::vector<double> variance;
  std::vector<double> at_least, at_greatest;  ///< poses q
  bool settled = true;                        ///< whether both searches converged
  std::optional<PlayQuantiles> quantiles;     ///< with samples
  /// greatest − least.
  double width() const { return greatest - least; }
  /// Σ of both differences of bounds and values found, relative to the width.
  double gap() const {
    const double open = bound_greatest - greatest + (least - bound_least);
    return width() > 0 ? open / width() : open;
  }
};

/// Equilibrium under the loads at one position, with rigid contacts and without friction.
struct LoadedPose {
  std::string failure;            ///< why there is none; empty: there is one
  std::vector<double> q;          ///< the pose
  std::vector<double> values;     ///< of the quantities
  std::vector<double> reactions;  ///< fx, fy (N) and m (N m) of each element of Play::reactions
};

/// One position of the driven joint.
struct PlayPosition {
  double coordinate = 0;          ///< of the driven joint, rad or m
  std::string refusal;            ///< why no range is given; empty: `ranges` has one for each quantity
  std::vector<PlayRange> ranges;  ///< in the order of Play::quantities
  std::vector<double> pose;       ///< ideal
  LoadedPose up, down;            ///< approached from the position before, and from the next one
};

/// The farthest place of a point in a direction.
struct FarthestPlace {
  double direction = 0;  ///< φ (rad), from the x axis
  double x = 0;          ///< m
  double y = 0;          ///< m
  double bound = 0;      ///< m: no place is farther than this from the ideal one along φ
};

/// The reachable region of a point at one position. The farthest places determine the convex hull of the region,
/// which differs from it by about clearance²/length.
struct PointRegion {
  std::string point;                    ///< BODY or BODY.POINT
  std::size_t position = 0;             ///< index in Play::positions
  double ideal_x = 0;                   ///< m, without clearances
  double ideal_y = 0;                   ///< m, without clearances
  std::vector<FarthestPlace> farthest;  ///< in directions all around
};

/// A journal or tooth that changes sides between two neighbouring positions.
struct PlayJump {
  std::string joint;  ///< name
  double from = 0;    ///< coordinate, in the order of the approach
  double to = 0;      ///< coordinate, in the order of the approach
  bool up = true;     ///< approached from the first position
};

/// Ranges of outputs over positions of a driven joint.
struct Play {
  std::string joint;                        ///< the driven joint; "" if there is none
  bool slides = false;                      ///< whether its coordinate is a position (m), not an angle (rad)
  std::vector<PlayClearance> components;    ///< the loose joints
  std::vector<PlayTolerance> tolerances;    ///< that the quantiles contain
  std::vector<PlayOutput> quantities;       ///< in the order of the request
  std::vector<PlayPosition> positions;      ///< in the order of the coordinate
  std::vector<std::string> notes;           ///< what is not considered
  bool sampled = false;                     ///< whether ranges have quantiles
  bool loaded = false;                      ///< whether positions have loaded poses
  std::vector<std::string> reactions = {};  ///< joints whose reactions they have
  std::vector<PlayJump> jumps = {};         ///< of the loaded poses
  std::vector<PointRegion> regions = {};    ///< of points both of whose coordinates are quantities
};

}  // namespace freeplay

// The mechanism as its author states it: facts only, in SI units, nothing about how it will be solved.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "values/vec2.hpp"

namespace freeplay {

/// Index of the ground wherever a body is named by its index.
inline constexpr int ground = -1;

struct Body {
  std::string name;
  double mass = 0;              ///< kg, > 0
  double inertia = 0;           ///< kg m², about the centre of mass, > 0
  Vec2 position{0, 0};          ///< m, centre of mass at the start; may be rough
  double angle = 0;             ///< rad, at the start; may be rough
  Vec2 velocity{0, 0};          ///< m/s, of the centre of mass at the start; may be rough
  double angular_velocity = 0;  ///< rad/s, at the start; may be rough
};

/// A pair of like materials in contact. What is left out is not modelled: without `friction` the contact
/// has no tangent row, without `young` no penalty law can be made from it.
struct Surface {
  std::string name;
  std::optional<double> young = {};        ///< Pa, > 0
  std::optional<double> poisson = {};      ///< in [0, 0.5]
  std::optional<double> restitution = {};  ///< asked for, in [0, 1]
  std::optional<double> friction = {};     ///< Coulomb's μ, ≥ 0
  double tangential_restitution = 0;       ///< e_T in [0, 1], of impact laws
};

/// What fills a clearance. Only the penalty formulation has a model of it.
struct Lubricant {
  enum class Film { short_bearing, long_bearing };
  std::string name;
  double viscosity = 0;  ///< Pa s, > 0
  Film film = Film::short_bearing;
  bool cavitation = true;  ///< no tension in the film
  std::optional<double> hand_over =
      {};  ///< m: film thickness below which dry contact takes over; default 0.01 clearance
};

/// Play of a revolute joint. The bearing is on the first body, the journal on the second.
struct Clearance {
  double radial = 0;          ///< m, > 0: bearing radius less journal radius
  double bearing_radius = 0;  ///< m, > radial
  int surface = -1;           ///< index into Mechanism::surfaces
  std::optional<double> bearing_length =
      {};              ///< m, > 0: length of the bearing; line contacts and films need it
  int lubricant = -1;  ///< index into Mechanism::lubricants, −1: dry
};

/// Two points kept together, each in its body's frame (ground: world), m from the centre of mass.
struct RevoluteJoint {
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  std::optional<Clearance> clearance = {};  ///< absent: an ideal joint
};

/// Play of a translational joint: a rectangular slider, centred on the second body's point, between two
/// parallel walls of the first body. Its four corners can touch.
struct SliderClearance {
  double half_play = 0;           ///< m, > 0: half the distance of the walls less half the slider's height
  double length = 0, height = 0;  ///< m, of the slider along and across the axis, > 0
  std::optional<double> corner_radius =
      {};            ///< m, of the rounded corners: for the stiffness of penalty contacts
  int surface = -1;  ///< index into Mechanism::surfaces
};

/// The second body slides along an axis of the first without turning relative to it.
struct TranslationalJoint {
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  Vec2 axis{1, 0};                                ///< unit vector in the first body's frame
  double angle = 0;                               ///< rad, θ of the second body less θ of the first
  std::optional<SliderClearance> clearance = {};  ///< absent: an ideal joint
};

/// A disc (or a point) of the second body against a straight wall of the first.
struct PlaneContact {
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< a point of the wall, the disc's centre
  Vec2 axis{1, 0};    ///< unit vector along the wall, in the first body's frame; free space lies on its left
  double radius = 0;  ///< m, ≥ 0
  int surface = -1;
};

/// Two discs that may touch from outside.
struct DiscContact {
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< centres
  std::array<double, 2> radii{0, 0};               ///< m, > 0
  int surface = -1;
};

/// Two bodies welded together at a point, at a fixed relative angle.
struct RigidJoint {
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  double angle = 0;  ///< rad, θ of the second body less θ of the first
};

using Joint = std::variant<RevoluteJoint, TranslationalJoint, RigidJoint>;
using Contact = std::variant<PlaneContact, DiscContact>;

inline const std::string& name_of(const Joint& joint) {
  return std::visit([](const auto& j) -> const std::string& { return j.name; }, joint);
}
inline const std::array<int, 2>& bodies_of(const Joint& joint) {
  return std::visit([](const auto& j) -> const std::array<int, 2>& { return j.between; }, joint);
}

/// Prescribed relative speed of a joint's two bodies: θ_second − θ_first = initial_angle + speed·t.
struct SpeedDrive {
  std::string name;
  int joint = -1;
  double speed = 0;          ///< rad/s
  double initial_angle = 0;  ///< rad, at t = 0
};

/// Torque between a joint's two bodies, positive when it turns the second one counter-clockwise.
struct TorqueDrive {
  enum class Against { time, angle };
  std::string name;
  int joint = -1;
  Against against = Against::time;
  /// (t in s or joint angle in rad, torque in N m), increasing; linear between, constant outside in time,
  /// repeated every 2π in angle. One point: a constant torque.
  std::vector<std::pair<double, double>> table;
  /// s, > 0: the torque z follows the table's u with a first-order lag from 0, lag·ż = u − z. Absent: z = u.
  std::optional<double> lag = {};
};

using Drive = std::variant<SpeedDrive, TorqueDrive>;

inline const std::string& name_of(const Drive& drive) {
  return std::visit([](const auto& d) -> const std::string& { return d.name; }, drive);
}

/// Constant force in the world's directions on a point of a body.
struct ForceLoad {
  std::string name;
  int body = ground;
  Vec2 at{0, 0};     ///< m, in the body's frame
  Vec2 force{0, 0};  ///< N
};
/// Constant torque on a body.
struct TorqueLoad {
  std::string name;
  int body = ground;
  double torque = 0;  ///< N m
};
/// Pulls its two points together with stiffness·(length − free_length) + damping·d(length)/dt.
struct SpringDamper {
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  double stiffness = 0;    ///< N/m
  double damping = 0;      ///< N s/m
  double free_length = 0;  ///< m
};
/// Turns its two bodies towards a relative angle.
struct TorsionalSpringDamper {
  std::string name;
  std::array<int, 2> between{ground, ground};
  double stiffness = 0;   ///< N m/rad
  double damping = 0;     ///< N m s/rad
  double free_angle = 0;  ///< rad, of θ_second − θ_first
};
/// Coulomb friction of a preloaded translational joint: a force of fixed bound against sliding.
struct JointFriction {
  std::string name;
  int joint = -1;
  double force = 0;  ///< N, the bound, ≥ 0
  std::optional<double> regularisation =
      {};  ///< m/s: below it the penalty formulation's force is linear in speed
};

using Load = std::variant<ForceLoad, TorqueLoad, SpringDamper, TorsionalSpringDamper, JointFriction>;

struct Mechanism {
  std::string title;
  Vec2 gravity{0, 0};  ///< m/s²
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Contact> contacts;
  std::vector<Surface> surfaces;
  std::vector<Lubricant> lubricants;
  std::vector<Drive> drives;
  std::vector<Load> loads;
};

/// The same mechanism with every clearance closed, and without contacts between bodies.
Mechanism idealised(Mechanism mechanism);

}  // namespace freeplay

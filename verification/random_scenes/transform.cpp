#include "verification/random_scenes/transform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "dynamics/assembly/assembly.hpp"
#include "verification/random_scenes/curve_scaling.hpp"
#include "verification/random_scenes/numbers.hpp"

namespace freeplay::verification::random_scenes {
namespace {

Vec2 turned(Vec2 p, double a) {
  return {p.x() * std::cos(a) - p.y() * std::sin(a), p.x() * std::sin(a) + p.y() * std::cos(a)};
}
Vec2 flip(Vec2 p) { return {-p.x(), p.y()}; }
/// Mirrors a wall, whose free space is on its left.
Vec2 flip_wall(Vec2 axis) { return {axis.x(), -axis.y()}; }

/// To 1e-12, so that numbers drawn in 1024ths are unchanged after mirroring twice.
double on_grid(double x) { return std::round(x * 0x1p40) * 0x1p-40; }

void swap_flank(Flank& flank) { flank = flank == Flank::forward ? Flank::backward : Flank::forward; }
void turn_limits(auto& limits) {
  std::swap(limits.lower, limits.upper);
  for (auto* x : {&limits.lower, &limits.upper})
    if (*x) **x = -**x;
}
void flip_ends(std::array<Vec2, 2>& at) {
  for (auto& p : at) p = flip(p);
}
void turn_table(SpringTable& table) {
  for (auto& [at, force] : table) at = -at, force = -force;
  std::ranges::reverse(table);
}
/// Of a spring over an angle, whose sign changes.
void flip(SpringLaw& law) {
  if (law.preload) law.preload = -*law.preload;
  if (law.one_way) law.one_way = *law.one_way == OneWay::pull ? OneWay::push : OneWay::pull;
  turn_table(law.table), turn_table(law.damping_table);
}
/// Angles change their sign; positions along the mirrored axis do not.
void flip(JointRatio& r, const Mechanism& m) { r.slider(m) ? r.ratio = -r.ratio : r.offset = -r.offset; }
/// Angles on a cam, φ' = π − φ.
void flip(CamContact& c) {
  flip_ends(c.at);
  c.axis = flip_wall(c.axis);
  c.start = M_PI - (c.start + c.rise + c.dwell + c.fall);
  std::swap(c.rise, c.fall);
  for (auto& point : c.table) point.first = M_PI - point.first;
  std::ranges::reverse(c.table);
}

}  // namespace

Scene by_pieces(Scene scene) {
  auto& m = scene.mechanism;
  if (m.beams.empty()) return scene;
  start_from(m, assemble(m, scene.run.start));
  for (auto& b : m.bodies) b.made = false;
  for (auto& load : m.loads)
    if (auto* element = std::get_if<BeamElement>(&load)) element->made = false;
  m.beams.clear();
  scene.run.start = RunOptions::Start::given;
  return scene;
}

Scene mirrored(Scene scene) {
  auto& m = scene.mechanism;
  m.gravity = flip(m.gravity);
  std::swap(m.assembly.positive, m.assembly.negative);
  for (auto& b : m.bodies) {
    if (b.position) b.position = flip(*b.position);
    if (b.velocity) b.velocity = flip(*b.velocity);
    for (auto* x : {&b.angle, &b.angular_velocity})
      if (*x) **x = -**x;
  }
  for (auto& joint : m.joints)
    std::visit(Overloaded{[](RevoluteJoint& j) { flip_ends(j.at); },
                          [](RigidJoint& j) { flip_ends(j.at), j.angle = -j.angle; },
                          [](TranslationalJoint& j) {
                            flip_ends(j.at);
                            j.axis = flip(j.axis);
                            j.angle = -j.angle;
                          },
                          [](GearJoint& j) {  // mirrored, the centres lie along −x at angle 0
                            flip_ends(j.at);
                            if (!j.clearance) swap_flank(j.flank);
                            j.phase = -*j.phase;
                            const auto mesh = j.mesh(1, 0);
                            *j.phase -= on_grid(mesh.sum() / mesh.Rj * std::numbers::pi);
                          },
                          [](RackJoint& j) {
                            flip_ends(j.at);
                            if (!j.clearance) swap_flank(j.flank);
                            j.axis = flip_wall(j.axis);
                            j.phase = -*j.phase;
                          },
                          [](SlotJoint& j) { flip_ends(j.at), j.axis = flip(j.axis); },
                          [](RodJoint& j) { flip_ends(j.at); }, [&](RatioJoint& j) { flip(j, m); }},
               joint);
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[](PlaneContact& c) { flip_ends(c.at), c.axis = flip_wall(c.axis); },
                          [](DiscContact& c) { flip_ends(c.at); }, [](CamContact& c) { flip(c); },
                          [](OutlineContact& c) {
                            flip_ends(c.at);
                            for (auto& p : c.points) p = flip(p);
                            std::ranges::reverse(c.points);
                          },
                          [](TravelStop&) {},
                          [](AngleStop& c) {
                            if (c.direction) c.direction = on_grid(std::numbers::pi) - *c.direction;
                            turn_limits(c.stop);
                          }},
               contact);
  for (auto& drive : m.drives)
    std::visit(Overloaded{[](SpeedDrive& d) { d.speed = -d.speed, d.initial_angle = -d.initial_angle; },
                          [](TorqueDrive& d) {
                            const bool by_angle = d.against == TorqueDrive::Against::angle;
                            for (auto& [at, torque] : d.table) {
                              torque = -torque;
                              if (by_angle) at = -at;
                            }
                            if (by_angle) std::ranges::reverse(d.table);
                          },
                          [&](MotionDrive& d) {
                            if (d.slides(m)) return;
                            if (d.velocity < 0) throw std::logic_error("positions are not transformed");
                            d.velocity = scaled_curve(m, d.velocity, 1, -1);
                            d.initial = -d.initial;
                          },
                          [&](TorqueCurveDrive& d) {
                            need_time(d.against);
                            d.curve = scaled_curve(m, d.curve, 1, -1);
                          },
                          [](ForceDrive& d) { need_time(d.against); },
                          [&](DcMotor& d) { scale(m, d.voltage, 1, -1); },
                          [](InductionMotor& d) { d.synchronous_speed = -d.synchronous_speed; },
                          [&](Governor& d) { scale(m, d.target, 1, -1); },
                          [&](AngleController& d) { scale(m, d.target, 1, -1); }, [](PositionController&) {}},
               drive);
  for (auto& load : m.loads)
    std::visit(
        Overloaded{[](ForceLoad& l) { need_time(l.against), l.at = flip(l.at), l.force = flip(l.force); },
                   [](TorqueLoad& l) { need_time(l.against), l.torque = -l.torque; },
                   [](SpringDamper& l) { flip_ends(l.at); },
                   [](TorsionalSpringDamper& l) { l.free_angle = -l.free_angle, flip(l.law); },
                   [](JointFriction&) {},
                   [](Freewheel& l) {
                     using enum Freewheel::Free;
                     l.direction = l.direction == forward ? backward : forward;
                   },
                   [](Bushing& l) {
                     flip_ends(l.at);
                     l.axis = flip(l.axis), l.free_angle = -l.free_angle;
                   },
                   [](BumpStop& l) { flip_ends(l.at), l.axis = flip(l.axis); },
                   [](TorsionalBumpStop& l) { turn_limits(l.bump); }, [&](ElasticRatio& l) { flip(l, m); },
                   [](BeamElement& l) {
                     flip_ends(l.at);
                     l.angles = Vec2{std::numbers::pi, std::numbers::pi} - l.angles;
                     l.curvature = -l.curvature;
                   }},
        load);
  return scene;
}

Scene turned(Scene scene, double angle) {
  auto& m = scene.mechanism;
  if (!m.drives.empty()) throw std::logic_error("drives are not turned");
  const auto turn = [&](Vec2& p) { p = turned(p, angle); };
  turn(m.gravity);
  for (auto& b : m.bodies) {
    for (auto* x : {&b.position, &b.velocity})
      if (*x) turn(**x);
    b.angle = b.angle.value_or(0) + angle;
  }
  const auto on_ground = [](const auto& one) {
    if constexpr (requires { one.between; }) return one.between[0] == ground || one.between[1] == ground;
    return true;
  };
  const auto element = [&](auto& one) {
    if (!on_ground(one)) return;
    using One = std::decay_t<decltype(one)>;
    if constexpr (std::is_same_v<One, RevoluteJoint> || std::is_same_v<One, PlaneContact>) {
      for (const std::size_t end : {0U, 1U})
        if (one.between[end] == ground) turn(one.at[end]);
      if constexpr (std::is_same_v<One, PlaneContact>)
        if (one.between[0] == ground) turn(one.axis);
    } else {
      throw std::logic_error("this element on the ground is not turned");
    }
  };
  for (auto& joint : m.joints) std::visit(element, joint);
  for (auto& contact : m.contacts) std::visit(element, contact);
  for (auto& load : m.loads) std::visit(element, load);
  return scene;
}

Scene reordered(Scene scene) {
  auto& m = scene.mechanism;
  const int bodies = static_cast<int>(m.bodies.size()), joints = static_cast<int>(m.joints.size());
  const auto body = [&](int& i) { i = i == ground ? ground : bodies - 1 - i; };
  const auto both = [&](std::array<int, 2>& between) { body(between[0]), body(between[1]); };
  const auto joint_of = [&](int& i) { i = joints - 1 - i; };
  std::ranges::reverse(m.bodies);
  for (auto& joint : m.joints)
    std::visit(
        [&](auto& j) {
          both(j.between);
          if constexpr (requires { j.of; }) joint_of(j.joint), joint_of(j.of);
        },
        joint);
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[&](TravelStop& c) { joint_of(c.joint); }, [&](AngleStop& c) { joint_of(c.joint); },
                          [&](auto& c) { both(c.between); }},
               contact);
  for (auto& drive : m.drives) {
    std::visit([&](auto& d) { joint_of(d.joint); }, drive);
    if (auto* d = std::get_if<MotionDrive>(&drive); d && d->of >= 0) joint_of(d->of);
  }
  for (auto& load : m.loads)
    std::visit(Overloaded{[&](ForceLoad& l) { body(l.body); }, [&](TorqueLoad& l) { body(l.body); },
                          [&](JointFriction& l) { joint_of(l.joint); },
                          [&](ElasticRatio& l) { joint_of(l.joint), joint_of(l.of); },
                          [&](auto& l) { both(l.between); }},
               load);
  std::ranges::reverse(m.joints);
  std::ranges::reverse(m.contacts);
  std::ranges::reverse(m.drives);
  std::ranges::reverse(m.loads);
  return scene;
}

Scene nudged(Scene scene, double share, int which) {
  Draw draw(20261121, static_cast<std::uint64_t>(which));
  const auto near = [&](double& x) { x *= 1 + share * draw.either_way(1); };
  auto& m = scene.mechanism;
  const bool turns = std::ranges::any_of(m.drives, [](const Drive& d) {
    return std::holds_alternative<SpeedDrive>(d) || std::holds_alternative<MotionDrive>(d);
  });
  // One factor for all velocities keeps them consistent where no motion is prescribed.
  const double faster = turns ? 1 : 1 + share * draw.either_way(1);
  for (auto& b : m.bodies) {
    near(b.mass), near(b.inertia);
    if (b.velocity) b.velocity = faster * *b.velocity;
    if (b.angular_velocity) *b.angular_velocity *= faster;
  }
  m.gravity = (1 + share * draw.either_way(1)) * m.gravity;
  for (auto& joint : m.joints)
    std::visit(Overloaded{[&](RevoluteJoint& j) {
                            if (j.clearance) near(j.clearance->radial);
                          },
                          [](RigidJoint&) {}, [](RodJoint&) {},
                          [&](TranslationalJoint& j) {
                            if (j.clearance) near(j.clearance->half_play);
                          },
                          [&](SlotJoint& j) {
                            if (j.clearance) near(j.clearance->half_play);
                          },
                          [&](RatioJoint& j) {
                            if (j.clearance) near(j.clearance->play);
                          },
                          [&](auto& j) {  // teeth
                            if (j.clearance) near(j.clearance->normal);
                          }},
               joint);
  // Discs and walls move apart, never into each other: a start in contact remains one that can be
  // run.
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[&](PlaneContact& c) { c.radius *= 1 - share * draw(); },
                          [&](DiscContact& c) {
                            for (auto& R : c.radii) R *= 1 - share * draw();
                          },
                          [&](CamContact& c) { c.base_radius *= 1 - share * draw(); },
                          [&](OutlineContact& c) { c.radius *= 1 - share * draw(); }, [](auto&) {}},
               contact);
  for (auto& s : m.surfaces) {
    if (s.restitution && *s.restitution < 1) near(*s.restitution);
    if (s.friction) near(*s.friction);
  }
  for (auto& drive : m.drives)
    if (auto* d = std::get_if<TorqueDrive>(&drive))
      for (auto& point : d->table) near(point.second);
  for (auto& load : m.loads)
    std::visit(
        Overloaded{[&](ForceLoad& l) { l.force = (1 + share * draw.either_way(1)) * l.force; },
                   [&](TorqueLoad& l) { near(l.torque); },
                   [&](JointFriction& l) {
                     near(l.reaction ? l.reaction->friction : l.torque ? *l.torque : *l.force);
                     if (l.peak) near(l.peak->bound);
                   },
                   [&](Freewheel& l) { near(l.torque_limit); },
                   [&](Bushing& l) { near(l.turn_stiffness), near(l.turn_damping); },
                   [&](BumpStop& l) { near(l.bump.stiffness), near(l.bump.damping); },
                   [&](TorsionalBumpStop& l) { near(l.bump.stiffness), near(l.bump.damping); },
                   [&](BeamElement& l) { near(l.bending), near(l.damping), near(l.axial), near(l.shear); },
                   [&](auto& l) { near(l.stiffness), near(l.damping); }},
        load);
  return scene;
}

}  // namespace freeplay::verification::random_scenes

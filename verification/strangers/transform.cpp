#include "verification/strangers/transform.hpp"

#include <algorithm>
#include <utility>

#include "verification/strangers/draft.hpp"

namespace freeplay::verification::strangers {
namespace {

Vec2 flip(Vec2 p) { return {-p.x(), p.y()}; }
/// Of a wall, whose free space lies on its left.
Vec2 flip_wall(Vec2 axis) { return {axis.x(), -axis.y()}; }

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

void flip_ends(std::array<Vec2, 2>& at) {
  for (auto& p : at) p = flip(p);
}

}  // namespace

Scene mirrored(Scene scene) {
  auto& m = scene.mechanism;
  m.gravity = flip(m.gravity);
  std::swap(m.assembly.positive, m.assembly.negative);
  for (auto& b : m.bodies) {
    b.position = flip(b.position);
    b.velocity = flip(b.velocity);
    b.angle = -b.angle;
    b.angular_velocity = -b.angular_velocity;
  }
  for (auto& joint : m.joints)
    std::visit(Overloaded{[](RevoluteJoint& j) { flip_ends(j.at); },
                          [](RigidJoint& j) { flip_ends(j.at), j.angle = -j.angle; },
                          [](TranslationalJoint& j) {
                            flip_ends(j.at);
                            j.axis = flip(j.axis);
                            j.angle = -j.angle;
                          }},
               joint);
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[](PlaneContact& c) { flip_ends(c.at), c.axis = flip_wall(c.axis); },
                          [](DiscContact& c) { flip_ends(c.at); }},
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
                          }},
               drive);
  for (auto& load : m.loads)
    std::visit(
        Overloaded{[](ForceLoad& l) { l.at = flip(l.at), l.force = flip(l.force); },
                   [](TorqueLoad& l) { l.torque = -l.torque; }, [](SpringDamper& l) { flip_ends(l.at); },
                   [](TorsionalSpringDamper& l) { l.free_angle = -l.free_angle; }, [](JointFriction&) {}},
        load);
  return scene;
}

Scene rescaled(Scene scene, const Units& u) {
  const double L = u.length, M = u.mass, T = u.time, force = M * L / (T * T), torque = force * L;
  auto& m = scene.mechanism;
  const auto ends = [&](std::array<Vec2, 2>& at) {
    for (auto& p : at) p = L * p;
  };
  const auto maybe = [](std::optional<double>& x, double factor) {
    if (x) *x *= factor;
  };
  m.gravity = (L / (T * T)) * m.gravity;
  for (auto& b : m.bodies) {
    b.mass *= M;
    b.inertia *= M * L * L;
    b.position = L * b.position;
    b.velocity = (L / T) * b.velocity;
    b.angular_velocity /= T;
  }
  for (auto& joint : m.joints)
    std::visit(Overloaded{[&](RevoluteJoint& j) {
                            ends(j.at);
                            if (!j.clearance) return;
                            j.clearance->radial *= L;
                            j.clearance->bearing_radius *= L;
                            maybe(j.clearance->bearing_length, L);
                          },
                          [&](RigidJoint& j) { ends(j.at); },
                          [&](TranslationalJoint& j) {
                            ends(j.at);
                            if (!j.clearance) return;
                            j.clearance->half_play *= L;
                            j.clearance->length *= L;
                            j.clearance->height *= L;
                            maybe(j.clearance->corner_radius, L);
                          }},
               joint);
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[&](PlaneContact& c) { ends(c.at), c.radius *= L; },
                          [&](DiscContact& c) {
                            ends(c.at);
                            for (auto& R : c.radii) R *= L;
                          }},
               contact);
  for (auto& s : m.surfaces) maybe(s.young, force / (L * L));
  for (auto& l : m.lubricants) l.viscosity *= force * T / (L * L), maybe(l.hand_over, L);
  for (auto& drive : m.drives)
    std::visit(Overloaded{[&](SpeedDrive& d) { d.speed /= T; },
                          [&](TorqueDrive& d) {
                            for (auto& [at, value] : d.table) {
                              value *= torque;
                              if (d.against == TorqueDrive::Against::time) at *= T;
                            }
                            maybe(d.lag, T);
                          }},
               drive);
  for (auto& load : m.loads)
    std::visit(Overloaded{[&](ForceLoad& l) { l.at = L * l.at, l.force = force * l.force; },
                          [&](TorqueLoad& l) { l.torque *= torque; },
                          [&](SpringDamper& l) {
                            ends(l.at);
                            l.stiffness *= force / L;
                            l.damping *= force / L * T;
                            l.free_length *= L;
                          },
                          [&](TorsionalSpringDamper& l) { l.stiffness *= torque, l.damping *= torque * T; },
                          [&](JointFriction& l) { l.force *= force, maybe(l.regularisation, L / T); }},
               load);
  scene.run.duration *= T;
  scene.run.discard *= T;
  if (scene.nonsmooth.step) *scene.nonsmooth.step *= T;
  auto& p = scene.penalty;
  p.step *= T;
  p.friction_v0 *= L / T;
  p.friction_v1 *= L / T;
  p.alpha /= T;
  p.beta /= T;
  maybe(p.v0_floor, L / T);
  return scene;
}

Scene reordered(Scene scene) {
  auto& m = scene.mechanism;
  const int bodies = static_cast<int>(m.bodies.size()), joints = static_cast<int>(m.joints.size());
  const auto body = [&](int& i) { i = i == ground ? ground : bodies - 1 - i; };
  const auto both = [&](std::array<int, 2>& between) { body(between[0]), body(between[1]); };
  const auto joint_of = [&](int& i) { i = joints - 1 - i; };
  std::ranges::reverse(m.bodies);
  for (auto& joint : m.joints) std::visit([&](auto& j) { both(j.between); }, joint);
  for (auto& contact : m.contacts) std::visit([&](auto& c) { both(c.between); }, contact);
  for (auto& drive : m.drives) std::visit([&](auto& d) { joint_of(d.joint); }, drive);
  for (auto& load : m.loads)
    std::visit(Overloaded{[&](ForceLoad& l) { body(l.body); }, [&](TorqueLoad& l) { body(l.body); },
                          [&](JointFriction& l) { joint_of(l.joint); }, [&](auto& l) { both(l.between); }},
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
  const bool turns =
      std::ranges::any_of(m.drives, [](const Drive& d) { return std::holds_alternative<SpeedDrive>(d); });
  // One factor for all velocities keeps them consistent where nothing is prescribed.
  const double faster = turns ? 1 : 1 + share * draw.either_way(1);
  for (auto& b : m.bodies) {
    near(b.mass), near(b.inertia);
    b.velocity = faster * b.velocity;
    b.angular_velocity *= faster;
  }
  m.gravity = (1 + share * draw.either_way(1)) * m.gravity;
  for (auto& joint : m.joints)
    std::visit(Overloaded{[&](RevoluteJoint& j) {
                            if (j.clearance) near(j.clearance->radial);
                          },
                          [](RigidJoint&) {},
                          [&](TranslationalJoint& j) {
                            if (j.clearance) near(j.clearance->half_play);
                          }},
               joint);
  // Discs and walls move away from each other, never into: a start that touches stays one that can be run.
  for (auto& contact : m.contacts)
    std::visit(Overloaded{[&](PlaneContact& c) { c.radius *= 1 - share * draw(); },
                          [&](DiscContact& c) {
                            for (auto& R : c.radii) R *= 1 - share * draw();
                          }},
               contact);
  for (auto& s : m.surfaces) {
    if (s.restitution && *s.restitution < 1) near(*s.restitution);
    if (s.friction) near(*s.friction);
  }
  for (auto& drive : m.drives)
    if (auto* d = std::get_if<TorqueDrive>(&drive))
      for (auto& point : d->table) near(point.second);
  for (auto& load : m.loads)
    std::visit(Overloaded{[&](ForceLoad& l) { l.force = (1 + share * draw.either_way(1)) * l.force; },
                          [&](TorqueLoad& l) { near(l.torque); }, [&](JointFriction& l) { near(l.force); },
                          [&](auto& l) { near(l.stiffness), near(l.damping); }},
               load);
  return scene;
}

}  // namespace freeplay::verification::strangers

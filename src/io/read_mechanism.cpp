#include "io/read_mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace freeplay {
namespace {

template <class Range, class Name>
int index_of(const Range& range, const std::string& name, Name name_of_item) {
  const auto it = std::ranges::find_if(range, [&](const auto& item) { return name_of_item(item) == name; });
  return it == std::end(range) ? -1 : static_cast<int>(it - std::begin(range));
}

template <class Range>
std::string known(const Range& range) {
  std::string list;
  for (const auto& item : range) list += (list.empty() ? "" : ", ") + item.name;
  return list.empty() ? "none" : list;
}

std::array<int, 2> read_between(const Mechanism& mechanism, Section& s) {
  const auto names = s.names("between");
  if (names.size() != 2) s.fail("between", fmt::format("must name two bodies, names {}", names.size()));
  const std::array<int, 2> pair{body_index(mechanism, s, "between", names[0]),
                                body_index(mechanism, s, "between", names[1])};
  if (pair[0] == pair[1]) s.fail("between", fmt::format("joins \"{}\" to itself", names[0]));
  return pair;
}

std::array<Vec2, 2> read_at(Section& s) {
  if (!s.has("at")) return {Vec2{0, 0}, Vec2{0, 0}};
  const auto points = s.points("at");
  if (points.size() != 2)
    s.fail("at", fmt::format("must be two points, one in each body, is {}", points.size()));
  return {points[0], points[1]};
}

int read_surface_name(const Mechanism& mechanism, Section& s) {
  const auto name = s.text("surface");
  const int surface = index_of(mechanism.surfaces, name, [](const auto& x) { return x.name; });
  if (surface < 0)
    s.fail("surface", fmt::format("no surface \"{}\"; there is: {}", name, known(mechanism.surfaces)));
  return surface;
}

Clearance read_clearance(const Mechanism& mechanism, Section& s) {
  Clearance c;
  c.radial = s.number("clearance", positive);
  c.bearing_radius = s.number("bearing_radius", positive);
  if (c.bearing_radius <= c.radial)
    s.fail("bearing_radius",
           fmt::format("must be greater than the clearance {}, is {}", c.radial, c.bearing_radius));
  c.bearing_length = s.maybe_number("bearing_length", positive);
  if (s.has("lubricant")) {
    const auto lubricant = s.text("lubricant");
    c.lubricant = index_of(mechanism.lubricants, lubricant, [](const auto& x) { return x.name; });
    if (c.lubricant < 0)
      s.fail("lubricant",
             fmt::format("no lubricant \"{}\"; there is: {}", lubricant, known(mechanism.lubricants)));
    if (!c.bearing_length) s.fail("bearing_length", "is missing: the force of a lubricant's film needs it");
    const auto& oil = mechanism.lubricants[c.lubricant];
    if (oil.hand_over && *oil.hand_over >= c.radial)
      s.fail("lubricant", "its hand_over must be less than the clearance of the joint");
  }
  c.surface = read_surface_name(mechanism, s);
  return c;
}

SliderClearance read_slider_clearance(const Mechanism& mechanism, Section& s) {
  SliderClearance c;
  c.half_play = s.number("clearance", positive);
  c.length = s.number("slider_length", positive);
  c.height = s.number("slider_height", positive);
  c.corner_radius = s.maybe_number("corner_radius", positive);
  c.surface = read_surface_name(mechanism, s);
  return c;
}

std::array<double, 2> read_radii(Section& s) {
  const Vec2 radii = s.point("radii");
  if (!(radii.x() > 0 && radii.y() > 0)) s.fail("radii", "must be two positive lengths");
  return {radii.x(), radii.y()};
}

Joint read_joint(const Mechanism& mechanism, const std::string& name, Section& s) {
  switch (s.choice("type", {"revolute", "translational", "rigid"})) {
    case 0: {
      RevoluteJoint j{name, read_between(mechanism, s), read_at(s), {}};
      if (s.has("clearance")) j.clearance = read_clearance(mechanism, s);
      s.done(j.clearance ? "a revolute joint" : "a revolute joint without clearance");
      return j;
    }
    case 1: {
      TranslationalJoint j{name,         read_between(mechanism, s),       read_at(s),
                           read_axis(s), s.number("angle", any_number, 0), {}};
      if (s.has("clearance")) j.clearance = read_slider_clearance(mechanism, s);
      s.done(j.clearance ? "a translational joint" : "a translational joint without clearance");
      return j;
    }
    default: {
      RigidJoint j{name, read_between(mechanism, s), read_at(s), s.number("angle", any_number, 0)};
      s.done("a rigid joint");
      return j;
    }
  }
}

Contact read_contact(const Mechanism& mechanism, const std::string& name, Section& s) {
  if (s.choice("type", {"plane", "discs"}) == 0) {
    PlaneContact c{name,         read_between(mechanism, s),          read_at(s),
                   read_axis(s), s.number("radius", non_negative, 0), read_surface_name(mechanism, s)};
    s.done("a plane contact");
    return c;
  }
  DiscContact c{name, read_between(mechanism, s), read_at(s), read_radii(s), read_surface_name(mechanism, s)};
  s.done("a contact of discs");
  return c;
}

/// The joint named by the key `joint`, which must be of kind J.
template <class J>
int read_joint_name(const Mechanism& mechanism, Section& s, const char* kind) {
  const auto name = s.text("joint");
  const int index = index_of(mechanism.joints, name, [](const Joint& j) { return name_of(j); });
  if (index < 0) s.fail("joint", fmt::format("there is no joint \"{}\"", name));
  if (!std::holds_alternative<J>(mechanism.joints[index]))
    s.fail("joint", fmt::format("must be a {} joint, \"{}\" is not", kind, name));
  return index;
}

double given_angle(const Mechanism& mechanism, int joint) {
  const auto& pair = bodies_of(mechanism.joints[joint]);
  const auto angle = [&](int b) { return b == ground ? 0 : mechanism.bodies[b].angle; };
  return angle(pair[1]) - angle(pair[0]);
}

Drive read_drive(const Mechanism& mechanism, const std::string& name, Section& s) {
  const int joint = read_joint_name<RevoluteJoint>(mechanism, s, "revolute");
  const int given = s.has("speed_rpm") + s.has("speed") + s.has("torque") + s.has("torque_table");
  if (given != 1) s.fail("", "needs exactly one of speed_rpm, speed, torque, torque_table");
  if (s.has("speed_rpm") || s.has("speed")) {
    SpeedDrive d{name, joint,
                 s.has("speed") ? s.number("speed", any_number)
                                : s.number("speed_rpm", any_number) * 2 * std::numbers::pi / 60,
                 s.number("initial_angle", any_number, given_angle(mechanism, joint))};
    s.done("a speed drive");
    return d;
  }
  TorqueDrive d{name, joint, TorqueDrive::Against::time, {}, {}};
  if (s.has("torque")) {
    d.table.emplace_back(0.0, s.number("torque", any_number));
  } else {
    d.against = static_cast<TorqueDrive::Against>(s.choice("against", {"time", "angle"}, 0));
    for (const auto& p : s.points("torque_table")) {
      if (!d.table.empty() && p.x() <= d.table.back().first)
        s.fail("torque_table",
               fmt::format("must increase in its first column; {} follows {}", p.x(), d.table.back().first));
      d.table.emplace_back(p.x(), p.y());
    }
    const double span = d.table.back().first - d.table.front().first;
    if (d.against == TorqueDrive::Against::angle && span > 2 * std::numbers::pi * (1 + 1e-9))
      s.fail("torque_table", fmt::format("against an angle must span at most one turn, spans {} rad", span));
  }
  d.lag = s.maybe_number("lag", positive);
  s.done("a torque drive");
  return d;
}

int read_body(const Mechanism& mechanism, Section& s) {
  const auto name = s.text("body");
  const int body = body_index(mechanism, s, "body", name);
  if (body == ground) s.fail("body", "must be a moving body, is the ground");
  return body;
}

Load read_load(const Mechanism& mechanism, const std::string& name, Section& s) {
  switch (
      s.choice("type", {"force", "torque", "spring-damper", "torsional-spring-damper", "joint-friction"})) {
    case 0: {
      ForceLoad l{name, read_body(mechanism, s), s.point("at", {0, 0}), s.point("force")};
      s.done("a force");
      return l;
    }
    case 1: {
      TorqueLoad l{name, read_body(mechanism, s), s.number("torque", any_number)};
      s.done("a torque");
      return l;
    }
    case 2: {
      SpringDamper l{name,
                     read_between(mechanism, s),
                     read_at(s),
                     s.number("stiffness", non_negative, 0),
                     s.number("damping", non_negative, 0),
                     s.number("free_length", non_negative, 0)};
      s.done("a spring-damper");
      return l;
    }
    case 3: {
      TorsionalSpringDamper l{name, read_between(mechanism, s), s.number("stiffness", non_negative, 0),
                              s.number("damping", non_negative, 0), s.number("free_angle", any_number, 0)};
      s.done("a torsional spring-damper");
      return l;
    }
    default: {
      JointFriction l{name, read_joint_name<TranslationalJoint>(mechanism, s, "translational"),
                      s.number("force", non_negative), s.maybe_number("regularisation", positive)};
      if (std::get<TranslationalJoint>(mechanism.joints[l.joint]).clearance)
        s.fail("joint", "must be a joint without clearance; a loose one has friction by its surface");
      s.done("a joint friction");
      return l;
    }
  }
}

Body read_body_facts(const std::string& name, Section& s) {
  if (name == "ground") s.fail("", "\"ground\" is the fixed frame and cannot be a body");
  Body b;
  b.name = name;
  b.mass = s.number("mass", positive);
  b.inertia = s.number("inertia", positive);
  b.position = s.point("position", {0, 0});
  b.angle = s.number("angle", any_number, 0);
  b.velocity = s.point("velocity", {0, 0});
  b.angular_velocity = s.number("angular_velocity", any_number, 0);
  s.done("a body");
  return b;
}

Surface read_surface(const std::string& name, Section& s) {
  Surface x;
  x.name = name;
  x.young = s.maybe_number("young", positive);
  x.poisson = s.maybe_number("poisson", zero_to_half);
  x.restitution = s.maybe_number("restitution", zero_to_one);
  x.friction = s.maybe_number("friction", non_negative);
  x.tangential_restitution = s.number("tangential_restitution", zero_to_one, 0);
  if (x.young.has_value() != x.poisson.has_value())
    s.fail(x.young ? "young" : "poisson", "young and poisson go together; one of them is missing");
  s.done("a surface");
  return x;
}

Lubricant read_lubricant(const std::string& name, Section& s) {
  Lubricant l;
  l.name = name;
  l.viscosity = s.number("viscosity", positive);
  l.film = static_cast<Lubricant::Film>(s.choice("film", {"short", "long"}, 0));
  l.cavitation = s.choice("cavitation", {"half-sommerfeld", "none"}, 0) == 0;
  l.hand_over = s.maybe_number("hand_over", positive);
  s.done("a lubricant");
  return l;
}

}  // namespace

Vec2 read_axis(Section& s) {
  const Vec2 axis = s.point("axis", {1, 0});
  if (!(axis.norm() > 0)) s.fail("axis", "must not be zero");
  // Dividing a unit vector by its length once more may move it by a rounding: what to_toml writes stands.
  if (std::abs(axis.x() * axis.x() + axis.y() * axis.y() - 1) <= 1e-15) return axis;
  return axis.direction();
}

int body_index(const Mechanism& mechanism, const Section& section, std::string_view key,
               const std::string& name) {
  if (name == "ground") return ground;
  const int i = index_of(mechanism.bodies, name, [](const auto& b) { return b.name; });
  if (i < 0)
    section.fail(key,
                 fmt::format("there is no body \"{}\"; there is: ground, {}", name, known(mechanism.bodies)));
  return i;
}

Mechanism read_mechanism(Section& root) {
  Mechanism m;
  m.title = root.text("title", "");
  m.gravity = root.point("gravity", {0, 0});
  for (auto& [name, s] : root.children("bodies")) m.bodies.push_back(read_body_facts(name, s));
  if (m.bodies.empty())
    root.fail("bodies", "a scene needs at least one body: [bodies.NAME] with mass and inertia");
  for (auto& [name, s] : root.children("surfaces")) m.surfaces.push_back(read_surface(name, s));
  for (auto& [name, s] : root.children("lubricants")) m.lubricants.push_back(read_lubricant(name, s));
  for (auto& [name, s] : root.children("joints")) m.joints.push_back(read_joint(m, name, s));
  for (auto& [name, s] : root.children("contacts")) {
    if (index_of(m.joints, name, [](const Joint& j) { return name_of(j); }) >= 0)
      s.fail("", "there is a joint of that name; events could not tell them apart");
    m.contacts.push_back(read_contact(m, name, s));
  }
  for (auto& [name, s] : root.children("drives")) m.drives.push_back(read_drive(m, name, s));
  for (auto& [name, s] : root.children("loads")) m.loads.push_back(read_load(m, name, s));
  return m;
}

Mechanism idealised(Mechanism mechanism) {
  mechanism.contacts.clear();
  for (auto& joint : mechanism.joints) {
    if (auto* revolute = std::get_if<RevoluteJoint>(&joint)) revolute->clearance.reset();
    if (auto* slider = std::get_if<TranslationalJoint>(&joint)) slider->clearance.reset();
  }
  return mechanism;
}

}  // namespace freeplay

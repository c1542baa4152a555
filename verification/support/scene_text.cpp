#include "verification/support/scene_text.hpp"

#include <fmt/format.h>

namespace freeplay::test {

std::string joint(const std::string& name, const std::string& type, const std::string& i,
                  const std::string& j, Vec2 on_i, Vec2 on_j, const std::string& keys) {
  return fmt::format("[joints.{}]\ntype = \"{}\"\nbetween = [\"{}\", \"{}\"]\nat = [[{}, {}], [{}, {}]]\n{}",
                     name, type, i, j, on_i.x(), on_i.y(), on_j.x(), on_j.y(), keys);
}

std::string body(const std::string& name, double mass, double inertia, const std::string& keys) {
  return fmt::format("[bodies.{}]\nmass = {}\ninertia = {}\n{}", name, mass, inertia, keys);
}

std::string pin(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i, Vec2 on_j,
                const std::string& keys) {
  return joint(name, "revolute", i, j, on_i, on_j, keys);
}

std::string guide(const std::string& name, const std::string& i, const std::string& j, Vec2 axis, Vec2 on_i,
                  Vec2 on_j, const std::string& keys) {
  return joint(name, "translational", i, j, on_i, on_j,
               fmt::format("axis = [{}, {}]\n{}", axis.x(), axis.y(), keys));
}

std::string spring(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i, Vec2 on_j,
                   double stiffness, double free_length, const std::string& keys) {
  return fmt::format(
      "[loads.{}]\ntype = \"spring-damper\"\nbetween = [\"{}\", \"{}\"]\nat = [[{}, {}], [{}, {}]]\n"
      "stiffness = {}\nfree_length = {}\n{}",
      name, i, j, on_i.x(), on_i.y(), on_j.x(), on_j.y(), stiffness, free_length, keys);
}

std::string point(const std::string& name, double x, double y, double mass, Vec2 velocity) {
  return fmt::format("[bodies.{}]\nmass = {}\npoint = true\nposition = [{}, {}]\nvelocity = [{}, {}]\n", name,
                     mass, x, y, velocity.x(), velocity.y());
}

std::string rod(const std::string& name, const std::string& from, const std::string& to, double length) {
  return fmt::format("[joints.{}]\ntype = \"rod\"\nbetween = [\"{}\", \"{}\"]\nlength = {}\n", name, from, to,
                     length);
}

std::string loose(double clearance, double bearing_radius, const std::string& surface) {
  return fmt::format("clearance = {}\nbearing_radius = {}\nsurface = \"{}\"\n", clearance, bearing_radius,
                     surface);
}

namespace {

std::string contact(const std::string& name, const char* type, const std::string& i, const std::string& j,
                    const std::string& surface, const std::string& keys) {
  return fmt::format("[contacts.{}]\ntype = \"{}\"\nbetween = [\"{}\", \"{}\"]\nsurface = \"{}\"\n{}", name,
                     type, i, j, surface, keys);
}

}  // namespace

std::string plane(const std::string& name, const std::string& i, const std::string& j, double radius,
                  const std::string& surface, const std::string& keys) {
  return contact(name, "plane", i, j, surface, radius > 0 ? fmt::format("radius = {}\n", radius) : "") + keys;
}

std::string discs(const std::string& name, const std::string& i, const std::string& j, double radius_i,
                  double radius_j, const std::string& surface, const std::string& keys) {
  return contact(name, "discs", i, j, surface, fmt::format("radii = [{}, {}]\n", radius_i, radius_j)) + keys;
}

std::string surface(const std::string& name, double restitution, const std::string& keys) {
  return fmt::format("[surfaces.{}]\nrestitution = {}\n{}", name, restitution, keys);
}

std::string surface(const std::string& name, double restitution, double friction, const std::string& keys) {
  return surface(name, restitution, fmt::format("friction = {}\n{}", friction, keys));
}

std::string drive(const std::string& name, const std::string& joint, const std::string& keys) {
  return fmt::format("[drives.{}]\njoint = \"{}\"\n{}", name, joint, keys);
}

std::string motor(const std::string& name, const std::string& joint, double speed, const std::string& keys) {
  return drive(name, joint, fmt::format("speed = {}\n{}", speed, keys));
}

std::string curve(const std::string& name, const std::string& shape, const std::string& keys) {
  return fmt::format("[curves.{}]\nshape = \"{}\"\n{}", name, shape, keys);
}

std::string table(const std::string& name, const std::string& points, const std::string& keys) {
  return curve(name, "table", fmt::format("points = {}\n{}", points, keys));
}

std::string harmonic(const std::string& name, double amplitude, double period, const std::string& keys) {
  return curve(name, "harmonic", fmt::format("amplitude = {}\nperiod = {}\n{}", amplitude, period, keys));
}

std::string stop(const std::string& name, const std::string& type, const std::string& joint,
                 const std::string& keys, const std::string& surface) {
  return fmt::format("[contacts.{}]\ntype = \"{}\"\njoint = \"{}\"\nsurface = \"{}\"\n{}", name, type, joint,
                     surface, keys);
}

std::string force(const std::string& name, const std::string& body, Vec2 force, const std::string& keys) {
  return fmt::format("[loads.{}]\ntype = \"force\"\nbody = \"{}\"\nforce = [{}, {}]\n{}", name, body,
                     force.x(), force.y(), keys);
}

std::string joint_friction(const std::string& name, const std::string& joint, const std::string& keys) {
  return fmt::format("[loads.{}]\ntype = \"joint-friction\"\njoint = \"{}\"\n{}", name, joint, keys);
}

std::string torsion(const std::string& name, const std::string& i, const std::string& j, double stiffness,
                    const std::string& keys) {
  return fmt::format(
      "[loads.{}]\ntype = \"torsional-spring-damper\"\nbetween = [\"{}\", \"{}\"]\nstiffness = {}\n{}", name,
      i, j, stiffness, keys);
}

std::string gear(const std::string& name, const std::string& i, const std::string& j, Vec2 radii,
                 const std::string& keys) {
  return fmt::format("[joints.{}]\ntype = \"gear\"\nbetween = [\"{}\", \"{}\"]\npitch_radii = [{}, {}]\n{}",
                     name, i, j, radii.x(), radii.y(), keys);
}

std::string run_for(double duration, const std::string& keys) {
  return fmt::format("[run]\nduration = {}\n{}", duration, keys);
}

std::string two_bodies() {
  return "gravity = [0.3, -9.81]\n" + body("a", 1.5, 0.02) + body("b", 0.7, 0.01) +
         pin("pin", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
         guide("slide", "a", "b", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}, "angle = 0.2\n");
}

}  // namespace freeplay::test

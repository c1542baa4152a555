// Elements of scenes as TOML, by name with their parameters, and mechanisms shared by several
// tests.
#pragma once

#include <string>

#include "values/vec2.hpp"

namespace freeplay::test {

/// [bodies.name]; `keys`: further lines.
std::string body(const std::string& name, double mass, double inertia, const std::string& keys = "");
/// A point mass.
std::string point(const std::string& name, double x, double y, double mass = 0.7, Vec2 velocity = {});
/// A joint of any type between points of bodies i and j; `keys`: further lines.
std::string joint(const std::string& name, const std::string& type, const std::string& i,
                  const std::string& j, Vec2 on_i, Vec2 on_j, const std::string& keys = "");
/// A revolute joint of bodies i and j, at a point of either; `keys`: further lines.
std::string pin(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i = {},
                Vec2 on_j = {}, const std::string& keys = "");
/// A translational joint along `axis` of body i through a point of either.
std::string guide(const std::string& name, const std::string& i, const std::string& j, Vec2 axis = {1, 0},
                  Vec2 on_i = {}, Vec2 on_j = {}, const std::string& keys = "");
/// A massless rod between two point masses, or a point mass and the ground.
std::string rod(const std::string& name, const std::string& from, const std::string& to, double length);
/// A linear spring and damper between points of bodies i and j; `keys`: further lines.
std::string spring(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i, Vec2 on_j,
                   double stiffness, double free_length, const std::string& keys = "");
/// Keys of a revolute joint with clearance.
std::string loose(double clearance, double bearing_radius, const std::string& surface = "s");
/// A contact of body j with a plane of body i: of a disc, or of a point if the radius is 0.
std::string plane(const std::string& name, const std::string& i, const std::string& j, double radius,
                  const std::string& surface = "s", const std::string& keys = "");
/// A contact of two discs.
std::string discs(const std::string& name, const std::string& i, const std::string& j, double radius_i,
                  double radius_j, const std::string& surface = "s", const std::string& keys = "");
/// [surfaces.name]
std::string surface(const std::string& name, double restitution, const std::string& keys = "");
std::string surface(const std::string& name, double restitution, double friction,
                    const std::string& keys = "");
/// A drive at a constant speed (rad/s).
std::string motor(const std::string& name, const std::string& joint, double speed,
                  const std::string& keys = "");
/// A drive of any other kind, which the keys determine.
std::string drive(const std::string& name, const std::string& joint, const std::string& keys);
/// A curve of a shape, which the keys determine.
std::string curve(const std::string& name, const std::string& shape, const std::string& keys);
/// A table of points, as in [[0, 1], [1, 3]].
std::string table(const std::string& name, const std::string& points, const std::string& keys = "");
/// A harmonic curve of time; the period in seconds.
std::string harmonic(const std::string& name, double amplitude, double period, const std::string& keys = "");
/// A "travel-stop" or an "angle-stop" of a joint.
std::string stop(const std::string& name, const std::string& type, const std::string& joint,
                 const std::string& keys, const std::string& surface = "s");
/// A force on a body, at its centre of mass unless the keys have another point.
std::string force(const std::string& name, const std::string& body, Vec2 force, const std::string& keys = "");
/// Friction in a joint, whose bound the keys determine.
std::string joint_friction(const std::string& name, const std::string& joint, const std::string& keys);
/// A torsional spring and damper.
std::string torsion(const std::string& name, const std::string& i, const std::string& j, double stiffness,
                    const std::string& keys = "");
/// A gear joint with the pitch radii of i and j.
std::string gear(const std::string& name, const std::string& i, const std::string& j, Vec2 radii,
                 const std::string& keys = "");
/// [run] of this duration (s); `keys`: further lines.
std::string run_for(double duration, const std::string& keys = "");

/// Bodies a on a pin of the ground and b on a guide of a, in a general position, under an inclined
/// weight.
std::string two_bodies();

}  // namespace freeplay::test

// Elements of scenes as TOML, by name with their parameters, and mechanisms shared by several
// tests.
#pragma once

#include <string>

#include "values/vec2.hpp"

namespace freeplay::test {

/// [bodies.name]; `keys`: further lines.
std::string body(const std::string& name, double mass, double inertia, const std::string& keys = "");
/// A revolute joint of bodies i and j, at a point of either; `keys`: further lines.
std::string pin(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i = {},
                Vec2 on_j = {}, const std::string& keys = "");
/// A translational joint along `axis` of body i through a point of either.
std::string guide(const std::string& name, const std::string& i, const std::string& j, Vec2 axis = {1, 0},
                  Vec2 on_i = {}, Vec2 on_j = {}, const std::string& keys = "");
/// A linear spring and damper between points of bodies i and j; `keys`: further lines.
std::string spring(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i, Vec2 on_j,
                   double stiffness, double free_length, const std::string& keys = "");
/// [run] of this duration (s); `keys`: further lines.
std::string run_for(double duration, const std::string& keys = "");

/// Bodies a on a pin of the ground and b on a guide of a, in a general position, under an inclined
/// weight.
std::string two_bodies();

}  // namespace freeplay::test

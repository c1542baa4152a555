// Point masses and rods as text of a scene.
#pragma once

#include <fmt/format.h>

#include <string>

#include "values/vec2.hpp"

namespace freeplay::test {

inline std::string point(const std::string& name, double x, double y, double mass = 0.7, Vec2 velocity = {}) {
  return fmt::format("[bodies.{}]\nmass = {}\npoint = true\nposition = [{}, {}]\nvelocity = [{}, {}]\n", name,
                     mass, x, y, velocity.x(), velocity.y());
}

inline std::string rod(const std::string& name, const std::string& from, const std::string& to,
                       double length) {
  return fmt::format("[joints.{}]\ntype = \"rod\"\nbetween = [\"{}\", \"{}\"]\nlength = {}\n", name, from, to,
                     length);
}

}  // namespace freeplay::test

// Beams of 1 m with EI = 1 N m² and 1 kg/m, for the tests of beams.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/modes.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

namespace freeplay::test {

/// A beam of length 1 m, EI = 1 N m², 1 kg/m and EA (N), nearly without rotary inertia.
inline std::string unit_beam(const std::string& from, const std::string& to, int elements, double axial,
                             const std::string& more = "") {
  return fmt::format(
      "[beams.rod]\nbetween = [\"{}\", \"{}\"]\nlength = 1.0\nelements = {}\nyoung = {}\ndensity = 1.0\n"
      "area = 1.0\nsecond_moment = {}\n{}",
      from, to, elements, axial, 1 / axial, more);
}

/// A body of little mass at a place: 1e-5 of the beam.
inline std::string light(const std::string& name, double x) {
  return test::body(name, 1e-5, 1e-7, fmt::format("position = [{}, 0.0]\nangle = 0.0\n", x));
}

/// The equilibrium of a cantilever from the origin along x with loads on its tip: place and angle of the tip.
inline std::array<double, 3> bent(int elements, const std::string& loads, const std::string& more = "") {
  const auto scene = parse_scene(
      light("tip", 1) + unit_beam("ground", "tip", elements, 1e5, more) + loads + test::run_for(1), "beam");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  const auto q = find_equilibrium(scene.mechanism, system, from.q, {}).state.q;
  return {q[0], q[1], q[2]};
}

/// Natural frequencies (rad/s) of a scene about its start.
inline std::vector<double> frequencies(const std::string& text) {
  const auto scene = parse_scene(text + test::run_for(1), "beam");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  double left = 0;
  std::vector<double> list;
  for (const auto& mode : find_modes(system, as_it_stands(system, from, {}, left), {}).modes)
    if (mode.kind == Mode::Kind::swing) list.push_back(std::abs(mode.s));
  CHECK(left < 1e-7);  // N, rounding of positions times EA/l
  return list;
}

}  // namespace freeplay::test

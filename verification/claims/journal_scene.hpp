// A journal in a lubricated bearing, and the schemes that run it.
#pragma once

#include "verification/references/journal_bearing.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::journal_scene {

using reference::JournalBearing;
using test::Way;

inline constexpr double R = 20e-3, L = 15e-3, c = 0.1e-3, g = 9.81;

inline const Way film_ways[] = {test::penalty, test::fixed_steps(1e-5, "Moreau–Jean, h = 1e-5 s"),
                                test::chosen_steps, test::event_driven, test::automatic};

inline std::string name_of(const JournalBearing& b) {
  return fmt::format("{} {} film", b.is_short ? "short" : "long", b.cavitated ? "half-Sommerfeld" : "full");
}

/// A journal on a shaft with initial position and velocity in a fixed bearing.
inline Scene journal(const JournalBearing& b, double mass, double inertia, double omega, double gravity,
                     double duration, Vec2 from = {0, 0}, Vec2 velocity = {0, 0}) {
  return parse_scene(
      fmt::format("gravity = [0, {}]\n", -gravity) +
          test::body("shaft", mass, inertia,
                     fmt::format("angular_velocity = {}\nposition = [{}, {}]\nvelocity = [{}, {}]\n", omega,
                                 from.x(), from.y(), velocity.x(), velocity.y())) +
          fmt::format("[lubricants.oil]\nviscosity = {}\nfilm = \"{}\"\ncavitation = \"{}\"\n", b.viscosity,
                      b.is_short ? "short" : "long", b.cavitated ? "half-sommerfeld" : "none") +
          test::surface("steel", 0.5, "young = 2e11\npoisson = 0.3\n") +
          test::pin("bearing", "ground", "shaft", {}, {},
                    test::loose(b.clearance, b.radius, "steel") +
                        fmt::format("bearing_length = {}\nlubricant = \"oil\"\n", b.length)) +
          test::run_for(duration),
      "journal");
}

}  // namespace freeplay::verification::journal_scene

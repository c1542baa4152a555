// What the laws look like: force over penetration in one free impact, delivered over requested restitution,
// friction over sliding speed. Written as CSV files for the figures of `freeplay laws SCENE`.
#pragma once

#include <filesystem>

#include "model/scene.hpp"

namespace freeplay {

struct ImpactSetting {
  double mass = 1;     ///< kg
  double speed = 0.1;  ///< m/s, of approach
};

/// Writes impact_loops.csv (law,delta,force), delivered.csv (law,requested,delivered), friction.csv
/// (law,speed,coefficient) and laws.json (setting and provenance) for the scene's first contact. Line
/// contacts are left out when the joint has no bearing_length. Throws ModelError when the scene has no
/// contact.
void write_law_curves(const Scene& scene, const ImpactSetting& setting, const std::filesystem::path& folder);

}  // namespace freeplay

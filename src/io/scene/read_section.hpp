// Parses Poincaré sections and state columns (simulation/section.hpp) from their text in a study or
// an option:
//
//     every period | every 0.1 s  [from 0.02 s]         the period is that of the scene's drive
//     NAME.angle crosses 30 deg [upwards|downwards|either]     or NAME.position crosses 2 mm
//     each touch [of NAME]                              at each contact onset
//
//     BODY.x .y .theta .vx .vy .omega   JOINT.angle .position .rate   CONTACT.ex .ey .gap .ex_c .ey_c
//     phase approach
//
// JOINT.angle is that of a revolute joint; JOINT.position is that of the second point of a
// translational joint along its axis, from the first point. A crossing is defined for coordinates
// only: BODY.x, .y, .theta, JOINT.angle or .position. A velocity is discontinuous at an impact, so it
// may pass a value without taking it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simulation/section.hpp"

namespace freeplay {

struct Scene;

/// A column with its name and unit in a table.
struct NamedColumn {
  std::string name, unit;
  StateColumn column;
};

/// Period of the excitation, s: one turn of the drive with prescribed speed; else the period of the
/// periodic curves over time, if they all have the same. nullopt if there is none, or if periods
/// differ.
std::optional<double> drive_period(const Scene& scene);

/// Columns of the bodies, in this order, and of the revolute and translational joints.
std::vector<NamedColumn> coordinate_columns(const Scene& scene, const std::vector<std::string>& bodies);

/// Parses a section. Throws ModelError about `key` if the text is not a section of this scene.
/// `period`: s, used instead of the drive's.
SectionRule read_section(std::string_view text, const Scene& scene, const Layout& layout,
                         const std::string& key, std::optional<double> period = {});

/// Parses a column. Throws ModelError about `key` if it is unknown, or not available at points of
/// this section.
NamedColumn read_column(std::string_view text, const Scene& scene, const Layout& layout,
                        const SectionRule& rule, const std::string& key);

/// All columns that are available at points of the section.
std::vector<NamedColumn> all_columns(const Scene& scene, const Layout& layout, const SectionRule& rule);

/// Default columns of a section's figure: the position of a journal in its bearing; else phase and
/// approach speed of contact onsets; else angle and rate of the last joint without a drive; else y
/// and vy of the last body.
std::vector<std::string> shown_columns(const Scene& scene, const Layout& layout, const SectionRule& rule);

}  // namespace freeplay

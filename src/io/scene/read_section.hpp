// Sections and columns of the state as people write them (simulation/section.hpp):
//
//     every period | every 0.1 s  [from 0.02 s]         the period is that of the scene's drive
//     NAME.angle crosses 30 deg [upwards|downwards|either]
//     each touch [of NAME]
//
//     BODY.x .y .theta .vx .vy .omega      JOINT.angle .rate      CONTACT.ex .ey .gap .ex_c .ey_c      phase approach
//
// What crosses is a coordinate: BODY.x, .y, .theta or JOINT.angle; a velocity jumps at an impact, and passes no value there.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simulation/section.hpp"

namespace freeplay {

struct Scene;

/// A column with the name and the unit that a table shows it by.
struct NamedColumn {
  std::string name, unit;
  StateColumn column;
};

/// s, after which what drives the scene repeats: a turn of the drive of prescribed speed, else the one period of its curves
/// against time that repeat; none where there is none, or several that differ.
std::optional<double> drive_period(const Scene& scene);

/// Throws ModelError about `key` for what is no section of the scene. `period`: s, given in place of the drive's.
SectionRule read_section(std::string_view text, const Scene& scene, const Layout& layout,
                         const std::string& key, std::optional<double> period = {});

/// Throws ModelError about `key` for what is no column, or none that points of the section have.
NamedColumn read_column(std::string_view text, const Scene& scene, const Layout& layout,
                        const SectionRule& rule, const std::string& key);

/// All columns that points of a section have.
std::vector<NamedColumn> all_columns(const Scene& scene, const Layout& layout, const SectionRule& rule);

/// What a section's figure shows where nobody says: where a journal stands in its bearing; else phase and speed of touches; else
/// angle and rate of the last joint that no drive prescribes; else y and vy of the last body.
std::vector<std::string> shown_columns(const Scene& scene, const Layout& layout, const SectionRule& rule);

}  // namespace freeplay

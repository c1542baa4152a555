// A scene as text: one spelling for each fact, so that texts can be compared in place of scenes.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Scene;

/// The canonical text of a scene: the whole mechanism, every option with the value in force and the
/// instruments, in SI units, a line for each key, elements in the mechanism's order. parse_scene() reads the
/// same facts back, bit for bit. What is not in force (the axis of an encoder, `alpha` without Baumgarte) is
/// no fact and is left out. What no scene file may hold is written all the same and refused by the reader,
/// with two exceptions that are SceneErrors here: an index that names nothing, and an encoder on bodies that
/// no joint connects.
std::string to_toml(const Scene& scene);

/// Whether two scenes state the same facts: their canonical texts are equal. The files they were read from do
/// not count.
bool same_facts(const Scene& a, const Scene& b);

/// Where canonical text `b` first differs from `a`: "joints.gudgeon.clearance is 0.001 here and 0.00025
/// there", "... is missing there"; `a` is here. Empty if they are equal.
std::string first_difference(const std::string& a, const std::string& b);

/// The lines of a canonical text that state something: "joints.gudgeon.clearance", "0.001", and the line
/// itself. A line that opens a table has no value.
struct CanonicalLine {
  std::string key, value, line;
};
std::vector<CanonicalLine> canonical_lines(const std::string& text);

}  // namespace freeplay

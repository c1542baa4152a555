// Canonical text of a scene, with one spelling for each fact, so that scenes can be compared as
// texts. It is the scene part of a run's identity (values/identity.hpp). The functions keep no
// state.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Scene;

/// The canonical text: the whole mechanism, all options with their values in force, and the
/// instruments, in SI units, one line for each key, elements in the mechanism's order.
/// parse_scene() reads the same facts back bit for bit. Keys that have no effect are omitted (the
/// axis of an encoder, `alpha` without Baumgarte's stabilisation). Invalid facts are written too,
/// and refused by the reader, with two exceptions that throw SceneError here: an index out of
/// range, and an encoder between bodies that no joint connects.
std::string to_toml(const Scene& scene);

/// Whether two scenes state the same facts, that is, have equal canonical texts. Their files do not
/// matter.
bool same_facts(const Scene& a, const Scene& b);

/// The first difference between two canonical texts, for messages: "joints.gudgeon.clearance is
/// 0.001 here and 0.00025 there", "... is missing there". "Here" is `a`. Empty if they are equal.
std::string first_difference(const std::string& a, const std::string& b);

/// The lines of a canonical text, each as key, value and the line itself:
/// "joints.gudgeon.clearance", "0.001". A line that opens a table has no value.
struct CanonicalLine {
  std::string key, value, line;
};
/// All lines of a canonical text, in their order.
std::vector<CanonicalLine> canonical_lines(const std::string& text);

}  // namespace freeplay

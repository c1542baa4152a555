// Values of a study that are neither numbers nor plain texts, for the verb `other` of the `keys()`
// visitors (io/scene/section_reader.hpp). Each function reads a key that is given and throws
// SceneError with its position.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mechanism/keys.hpp"
#include "values/branch.hpp"

namespace freeplay {

class Section;
struct Axis;

inline constexpr Range study_count{
    [](double x) { return x >= 1 && x <= 1e6 && x == static_cast<double>(static_cast<int>(x)); },
    "a whole number from 1"};

std::string read_family(Section& s, std::string_view key);
std::vector<std::string> read_families(Section& s, std::string_view key);
inline constexpr auto read_logarithmic = [](auto& s, std::string_view key) {
  return s.choice(key, {"linear", "log"}) == 1;
};
std::vector<BifurcationKind> read_curve_kinds(Section& s, std::string_view key);
/// The keys of the scene that an axis varies.
void read_varied(Section& s, Axis& axis);
/// The values of an axis: a list, or a range.
void read_values(Section& s, Axis& axis);

}  // namespace freeplay

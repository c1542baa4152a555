// The families of formulations, with their names on the command line, in scenes and in result
// files.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

enum class Family { penalty, nonsmooth };

struct FamilyName {
  Family value;
  const char* text;
};
inline constexpr std::array families{FamilyName{Family::penalty, "penalty"},
                                     FamilyName{Family::nonsmooth, "nonsmooth"}};

constexpr const char* name_of(Family family) {
  for (const auto& f : families)
    if (f.value == family) return f.text;
  return nullptr;  // unreachable: the table is complete
}
constexpr std::optional<Family> family_named(std::string_view text) {
  for (const auto& f : families)
    if (f.text == text) return f.value;
  return std::nullopt;
}
/// All names in the order of the table.
inline std::vector<std::string> family_names() {
  std::vector<std::string> list;
  for (const auto& f : families) list.emplace_back(f.text);
  return list;
}

}  // namespace freeplay

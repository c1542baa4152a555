// Values as TOML spells them: one spelling for each, which reads back as the same bits.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// A text in double quotes. Bytes beyond ASCII stand as they are: TOML is UTF-8.
std::string toml_quoted(std::string_view text);
/// The fewest digits that read back as the same number; never an integer of TOML, which has no −0.
std::string toml_number(double x);
/// [a, b, ...]
std::string toml_numbers(const std::vector<double>& list);

}  // namespace freeplay

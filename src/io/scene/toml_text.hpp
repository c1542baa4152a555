// Spelling of values in TOML: one spelling for each value, which reads back bit for bit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// A text in double quotes. Non-ASCII characters stay as they are, since TOML is UTF-8.
std::string toml_quoted(std::string_view text);
/// The shortest decimal number that reads back the same. Always a TOML float, since TOML integers
/// have no −0.
std::string toml_number(double x);
/// [a, b, ...]
std::string toml_numbers(const std::vector<double>& list);

}  // namespace freeplay

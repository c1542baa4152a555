#include "io/scene/toml_value.hpp"

#include <fmt/format.h>

namespace freeplay {

std::string toml_quoted(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (c == '\n')
      out += "\\n";
    else if (c == '\t')
      out += "\\t";
    else if (byte < 0x20 || byte == 0x7f)
      out += fmt::format("\\u{:04X}", byte);
    else
      out += c;
  }
  return '"' + out + '"';
}

std::string toml_number(double x) {
  auto digits = fmt::format("{}", x);
  // n: inf and nan, which the reader refuses.
  if (digits.find_first_of(".en") == digits.npos) digits += ".0";
  return digits;
}

std::string toml_numbers(const std::vector<double>& list) {
  std::string out;
  for (const double x : list) out += (out.empty() ? "" : ", ") + toml_number(x);
  return fmt::format("[{}]", out);
}

}  // namespace freeplay

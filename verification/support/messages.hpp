// Texts that the program prints: their width in a terminal, and the form of its error messages.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace freeplay::test {

/// Characters of UTF-8 without wide ones: columns of a terminal.
inline std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

/// The fault of an error message, or nothing: one line, or three for lists, and no words of libraries.
inline std::string fault_of(const std::string& message) {
  const auto lines = std::ranges::count(message, '\n');
  if (message.empty() || message.back() != '\n') return "does not end with its line";
  if (lines > 3) return "is of many lines";
  if (lines > 1 && message.find("\n  ") == message.npos && message.find("`freeplay help") == message.npos)
    return "goes on without a list";
  for (const char* foreign :
       {"std::", "SQL", "sql", "toml::", "toml++", "json.exception", "nlohmann", "PRAGMA", "boost", "Boost",
        "Ipopt", "KLU", "filesystem error", "what()", "terminate", "parse error", "Error while"})
    if (message.find(foreign) != message.npos) return fmt::format("says \"{}\"", foreign);
  if (std::ranges::any_of(message, [](char c) { return (c >= 0 && c < 0x20 && c != '\n') || c == 0x7F; }))
    return "has control characters";
  return "";
}

}  // namespace freeplay::test

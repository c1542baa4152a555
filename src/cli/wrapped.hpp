// Wraps text for a terminal of 80 columns.
#pragma once

#include <string>
#include <string_view>

namespace freeplay::cli {

/// `text` with lines longer than 80 columns (UTF-8 without wide characters) broken at spaces.
/// Continuation lines are indented by `indent` columns.
inline std::string wrapped(std::string_view text, std::size_t indent = 2) {
  std::string out;
  // `word`: columns since the last space.
  std::size_t column = 0, space = std::string::npos, word = 0;
  for (const char c : text) {
    out += c;
    if ((c & 0xC0) == 0x80) continue;
    ++column, ++word;
    if (c == '\n') column = 0, space = std::string::npos;
    if (c == ' ' && column > indent + 1) space = out.size() - 1, word = 0;
    if (column <= 80 || space == std::string::npos) continue;
    out.replace(space, 1, "\n" + std::string(indent, ' '));
    column = indent + word;
    space = std::string::npos;
  }
  return out;
}

}  // namespace freeplay::cli

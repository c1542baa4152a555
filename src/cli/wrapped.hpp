// Text for a terminal of 80 columns.
#pragma once

#include <string>
#include <string_view>

namespace freeplay::cli {

/// `text` with lines beyond 80 columns (of UTF-8, no wide characters) broken at spaces and continued after
/// `indent` columns.
inline std::string wrapped(std::string_view text, std::size_t indent = 2) {
  std::string out;
  std::size_t column = 0, space = std::string::npos, word = 0;  // `word`: columns since the last space
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

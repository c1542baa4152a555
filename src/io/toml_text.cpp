// From a file to a TOML document: what the parser cannot take is refused before it.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "io/input_file.hpp"
#include "io/section.hpp"

namespace freeplay {
namespace {

/// Outside quotes and comments TOML has ASCII alone. toml++ 3.3 meets other characters there with undefined
/// behaviour (its test for Unicode spaces runs into an unreachable default), and likewise a table's header
/// that does not begin with a name ([#a]), so they do not get that far.
void refuse_stray_characters(const std::string& text, const std::string& name) {
  int line = 1, column = 0;
  std::string quote;                     // that the present string ends with
  int depth = 0;                         // of brackets
  bool comment = false, header = false;  // within a comment; past the [ of a table's header
  bool blank = true;                     // nothing yet on this line
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    ++column;
    if (quote.empty() && !comment && !header) {
      if (c == '[' && blank && depth == 0) header = true;
      depth = std::max(0, depth + (c == '[' || c == '{') - (c == ']' || c == '}'));
      if (c == '[' && header) continue;
    }
    if (c != ' ' && c != '\t') blank = false;
    if (c == '\n' && !header) {
      ++line;
      column = 0;
      comment = false;
      blank = true;
      if (quote.size() == 1) quote.clear();  // an open string: the parser's affair
    } else if (!quote.empty()) {
      if (c == '\\' && quote[0] == '"')
        ++i;
      else if (text.compare(i, quote.size(), quote) == 0) {
        i += quote.size() - 1;
        quote.clear();
      }
    } else if (comment) {
      continue;
    } else if (header && c != '[' && c != ' ' && c != '\t') {
      if (!std::isalnum(static_cast<unsigned char>(c)) &&
          std::string_view("_-\"']").find(c) == std::string_view::npos)
        throw SceneError(
            fmt::format("{}:{}:{}: not TOML: the name of a table must begin with a letter, a digit, _ or -",
                        name, line, column));
      header = false;
      --i, --column;  // look at it again: it may open a quote
    } else if (c == '#') {
      comment = true;
    } else if (c == '"' || c == '\'') {
      quote = text.compare(i, 3, std::string(3, c)) == 0 ? std::string(3, c) : std::string(1, c);
      i += quote.size() - 1;
    } else if (static_cast<unsigned char>(c) >= 0x80) {
      throw SceneError(
          fmt::format("{}:{}:{}: not TOML: a character beyond ASCII may stand in quotes or a comment only",
                      name, line, column));
    }
  }
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& name) {
  refuse_stray_characters(text, name);
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& e) {
    const auto where = e.source().begin;
    throw SceneError(fmt::format("{}:{}:{}: not TOML: {}", name, where.line, where.column, e.description()));
  } catch (const std::logic_error& e) {
    throw SceneError(
        fmt::format("{}: not TOML: a value, name or bracket stands where none may ({})", name, e.what()));
  }
}

std::string read_text(const std::filesystem::path& file) { return read_file(file, most_of_a_text); }

}  // namespace freeplay

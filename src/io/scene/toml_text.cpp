// Parses TOML text. Text that the parser toml++ does not handle well is refused beforehand, with
// its position.

#include "io/scene/toml_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/scene/section.hpp"

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

namespace {

/// A position in a text. Columns count characters, not bytes.
struct Place {
  int line = 1, column = 0;
  void pass(char c) {
    if (c == '\n')
      ++line, column = 0;
    else
      column += (c & 0xC0) != 0x80;
  }
};

/// Position of the character that begins at `byte`.
Place place_of(std::string_view text, std::size_t byte) {
  Place place;
  for (const char c : text.substr(0, byte)) place.pass(c);
  ++place.column;
  return place;
}

[[noreturn]] void refuse(const std::string& name, int line, int column, const std::string& why) {
  throw SceneError(fmt::format("{}:{}:{}: not TOML: {}", name, line, column, why));
}

/// Refuses text that is not UTF-8 or contains NUL, as TOML requires.
void refuse_what_is_no_text(std::string_view text, const std::string& name) {
  for (std::size_t i = 0; i < text.size();) {
    const auto length = character_length(text.substr(i));
    if (length == 0 || text[i] == '\0') {
      const auto place = place_of(text, i);
      refuse(name, place.line, place.column,
             length == 0 ? fmt::format("byte 0x{:02X} is not UTF-8; save the file as UTF-8",
                                       static_cast<unsigned char>(text[i]))
                         : "contains a NUL character; is this a text file?");
    }
    i += length;
  }
}

/// Refuses non-ASCII characters outside strings and comments, and headers of tables that do not
/// begin with a name (such as [#a]), with messages that name the problem.
void refuse_stray_characters(std::string_view text, const std::string& name) {
  Place place;
  std::string quote;                     // end of the present string
  int depth = 0;                         // nesting of brackets
  bool comment = false, header = false;  // within a comment; after the [ of a table's header
  bool blank = true;                     // no character yet on this line
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const auto pass = [&](std::size_t more) {
      for (; more > 0 && i + 1 < text.size(); --more) place.pass(text[++i]);
    };
    const bool new_line = c == '\n' && !header;
    const Place before = place;
    place.pass(c);
    if (quote.empty() && !comment && !header) {
      if (c == '[' && blank && depth == 0) header = true;
      depth = std::max(0, depth + (c == '[' || c == '{') - (c == ']' || c == '}'));
      if (c == '[' && header) continue;
    }
    if (c != ' ' && c != '\t') blank = false;
    if (new_line) {
      comment = false;
      blank = true;
      if (quote.size() == 1) quote.clear();  // an unterminated string: the parser reports it
    } else if (!quote.empty()) {
      if (c == '\\' && quote[0] == '"')
        pass(1);
      else if (text.compare(i, quote.size(), quote) == 0) {
        pass(quote.size() - 1);
        quote.clear();
      }
    } else if (comment) {
      continue;
    } else if (header && c != '[' && c != ' ' && c != '\t') {
      const bool quoted = c == '"' || c == '\'';
      if (!quoted && !std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-')
        refuse(name, before.line, before.column + 1,
               "the name of a table must begin with a letter, a digit, _ or -");
      header = false;
      if (quoted) quote = c;
    } else if (c == '#') {
      comment = true;
    } else if (c == '"' || c == '\'') {
      quote = text.compare(i, 3, std::string(3, c)) == 0 ? std::string(3, c) : std::string(1, c);
      pass(quote.size() - 1);
    } else if (static_cast<unsigned char>(c) >= 0x80) {
      refuse(name, place.line, place.column, "non-ASCII characters are allowed in quotes and comments only");
    }
  }
}

/// Position at which an assertion of the parser fails: the last byte of the shortest prefix of the
/// text that violates it.
Place breaking_place(std::string_view text, const std::string& name) {
  const auto breaks = [&](std::size_t size) {
    try {
      static_cast<void>(toml::parse(text.substr(0, size), name));
    } catch (const toml::parse_error&) {
    } catch (const BrokenAssumption&) {
      return true;
    }
    return false;
  };
  std::size_t whole = 0, broken = text.size();
  while (whole + 1 < broken) {
    const auto middle = whole + (broken - whole) / 2;
    (breaks(middle) ? broken : whole) = middle;
  }
  return place_of(text, broken - 1);
}

/// Message of the parser as the end of one line: "Error while parsing X: Y" becomes "X: Y".
std::string finding(std::string_view description) {
  constexpr std::string_view opening = "Error while parsing ";
  if (description.starts_with(opening)) description.remove_prefix(opening.size());
  std::string line;
  for (const char c : description) line += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return line;
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& name) {
  std::string_view body = text;
  if (body.starts_with("\xEF\xBB\xBF")) body.remove_prefix(3);
  refuse_what_is_no_text(body, name);
  refuse_stray_characters(body, name);
  try {
    return toml::parse(body, name);
  } catch (const toml::parse_error& e) {
    const auto where = e.source().begin;
    refuse(name, static_cast<int>(where.line), static_cast<int>(where.column), finding(e.description()));
  } catch (const BrokenAssumption&) {
    const auto place = breaking_place(body, name);
    refuse(name, place.line, place.column, "unexpected value, name or bracket");
  }
}

std::string read_text(const std::filesystem::path& file) { return read_file(file, most_of_a_text); }

}  // namespace freeplay

// Escaping of texts. visible(), for text of unknown origin, replaces control characters, direction marks and
// invisible characters, which could move a cursor, recolour a terminal, reorder a line or hide in it:
// terminal output, figures and messages use it. shell_words() quotes words for a POSIX shell.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// Escapes control characters, direction marks and invisible characters as \n, \t, \r, \x1b or
/// \u{202e}, and bytes that are not UTF-8 as \xff. Characters in `kept` are not escaped.
std::string visible(std::string_view text, std::string_view kept = "");

/// visible() for a text that arrives in pieces. Keeps the beginning of an incomplete character
/// until its end arrives.
class VisibleStream {
 public:
  explicit VisibleStream(std::string_view kept) : kept_(kept) {}
  /// The text that can be shown so far.
  std::string pass(std::string_view piece);

 private:
  std::string_view kept_;
  std::string waiting_;  // at most three bytes
};

/// Bytes of the UTF-8 character at the beginning of the text, which is not empty; 0 if none is there (RFC
/// 3629: no overlong form, no surrogate, no code above U+10FFFF).
std::size_t character_length(std::string_view text);

/// visible(), shortened to about `most` characters.
std::string visible_brief(std::string_view text, std::size_t most = 120);

/// Joins words with blanks. Words of letters, digits and %+,-./:=@_ stay as they are; others are
/// single-quoted.
std::string shell_words(const std::vector<std::string>& words);

}  // namespace freeplay

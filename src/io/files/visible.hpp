// Text of unknown origin, made safe to show: what would move a cursor, recolour a terminal, reorder a line or hide in
// it is spelt out. A terminal, a figure and a message all take their texts through here.
#pragma once

#include <string>
#include <string_view>

namespace freeplay {

/// UTF-8 with every control character, direction mark and invisible character spelt as \n, \t, \r, \x1b or \u{202e}, and
/// every byte that is no UTF-8 as \xff. Those among `kept` pass as they are.
std::string visible(std::string_view text, std::string_view kept = "");

/// The same of a text that arrives in pieces: the beginning of a character waits for its end.
class VisibleStream {
 public:
  explicit VisibleStream(std::string_view kept) : kept_(kept) {}
  /// What may be shown now.
  std::string pass(std::string_view piece);

 private:
  std::string_view kept_;
  std::string waiting_;  // at most three bytes
};

/// visible(), shortened to about `most` characters where it is longer.
std::string visible_brief(std::string_view text, std::size_t most = 120);

}  // namespace freeplay

// Suggestions for unknown words (verbs, options, keys, names): the known word with the smallest
// edit distance
//
//     d(a, b) = least number of letters inserted, deleted, replaced, or exchanged with the next one
//
// (optimal string alignment; Damerau, Comm. ACM 7, 1964, 171). A word is suggested if at most half
// of the letters of the longer word differ.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// The distance d of two words.
int edit_distance(std::string_view a, std::string_view b);

/// The nearest word, the first of several; "" if none is near enough. An angle stands for a position, and
/// conversely.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

/// List for messages, "; there is: a, b". A long list is on a line of its own.
std::string listed(std::string_view opening, const std::vector<std::string>& words);

/// Whether a suggestion is followed by the list of all words.
enum class Beside { nothing, list };

/// Text for messages: "; did you mean b?", or the list if no word is near.
std::string meant(std::string_view word, const std::vector<std::string>& words, std::string_view opening,
                  Beside beside = Beside::nothing);

}  // namespace freeplay

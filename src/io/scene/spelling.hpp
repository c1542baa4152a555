// What somebody meant who wrote a word that is not known: of verbs, options, keys and names alike, the known word
// nearest by the number of letters that differ,
//
//     d(a, b) = least number of letters put in, left out, changed, or exchanged with the next one
//
// (optimal string alignment; Damerau, Comm. ACM 7, 1964, 171). Near is what differs in at most half of the longer word.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

/// The distance d of two words.
int edit_distance(std::string_view a, std::string_view b);

/// The word nearest in spelling, the first of several; "" when none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

/// "; there is: a, b", on a line of its own where it is long.
std::string listed(std::string_view opening, const std::vector<std::string>& words);

/// What stands beside a word that is near.
enum class Beside { nothing, list };

/// "; did you mean b?", or, where none is near, the list of them.
std::string meant(std::string_view word, const std::vector<std::string>& words, std::string_view opening,
                  Beside beside = Beside::nothing);

}  // namespace freeplay

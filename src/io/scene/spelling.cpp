#include "io/scene/spelling.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace freeplay {

int edit_distance(std::string_view a, std::string_view b) {
  // Rows i-1, i and i-2 of d(a₁…aᵢ, b₁…bⱼ).
  std::vector<int> above(b.size() + 1), row(b.size() + 1), last;
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    last = std::exchange(above, row);
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({row[j - 1] + 1, above[j] + 1, above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& words) {
  // Of a joint: a revolute one has an angle, a translational one a position.
  for (const auto& [given, other] :
       {std::pair<std::string_view, std::string_view>{".position", ".angle"}, {".angle", ".position"}})
    if (word.ends_with(given)) {
      auto instead = std::string(word.substr(0, word.size() - given.size())).append(other);
      if (std::ranges::find(words, instead) != words.end()) return instead;
    }
  std::string best;
  int least = 1000;
  for (const auto& candidate : words)
    if (const int d = edit_distance(word, candidate);
        d < least && d <= static_cast<int>(std::max(word.size(), candidate.size())) / 2) {
      least = d;
      best = candidate;
    }
  return best;
}

std::string listed(std::string_view opening, const std::vector<std::string>& words) {
  const auto list =
      fmt::format("{} {}", opening, words.empty() ? "none" : fmt::format("{}", fmt::join(words, ", ")));
  return (list.size() <= 80 ? "; " : "\n  ") + list;
}

std::string meant(std::string_view word, const std::vector<std::string>& words, std::string_view opening,
                  Beside beside) {
  const auto near = nearest_word(word, words);
  if (near.empty()) return listed(opening, words);
  const auto suggestion = fmt::format("; did you mean {}?", near);
  return beside == Beside::nothing ? suggestion
                                   : fmt::format("{}\n  {} {}", suggestion, opening, fmt::join(words, ", "));
}

}  // namespace freeplay

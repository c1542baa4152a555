#include "cli/accuracy.hpp"

#include <algorithm>
#include <string_view>

#include "study/settings.hpp"

namespace freeplay::cli {

std::vector<std::string> with_accuracy(const std::string& accuracy, const std::vector<Family>& families,
                                       const std::vector<std::string>& overrides) {
  std::vector<std::string> list;
  if (!accuracy.empty()) {
    const auto level = std::ranges::find(accuracies, accuracy, [](const auto& a) {
                         return std::string_view(a.text);
                       })->value;
    for (const auto family : families)
      for (const auto& key : setting_for(family, level).keys()) list.push_back(key);
  }
  list.insert(list.end(), overrides.begin(), overrides.end());
  return list;
}

}  // namespace freeplay::cli

#include "cli/accuracy.hpp"

#include <algorithm>
#include <string_view>

#include "study/settings/settings.hpp"

namespace freeplay::cli {

std::vector<std::string> with_accuracy(const std::string& accuracy, const std::vector<Family>& families,
                                       const std::vector<std::string>& overrides) {
  std::vector<std::string> list;
  if (!accuracy.empty()) {
    const auto level = std::ranges::find(accuracies, accuracy, [](const auto& a) {
                         return std::string_view(a.text);
                       })->value;
    for (const auto family : families) {
      const auto keys = setting_for(family, level).keys();
      // The first key selects the scheme or integrator. If the user selects another, the accuracy
      // class does not apply.
      const auto choice = keys.front().substr(0, keys.front().find('=') + 1);
      const auto chooses = [&](const std::string& option) { return option.starts_with(choice); };
      if (std::ranges::none_of(overrides, chooses)) list.insert(list.end(), keys.begin(), keys.end());
    }
  }
  list.insert(list.end(), overrides.begin(), overrides.end());
  return list;
}

}  // namespace freeplay::cli

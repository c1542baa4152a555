#include "io/scene/named_file.hpp"

#include <algorithm>
#include <system_error>

namespace freeplay {

bool lies_below(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto inner = std::filesystem::weakly_canonical(file, error);
  const auto outer = std::filesystem::canonical(folder.empty() ? "." : folder, error);
  if (error) return false;
  const auto whole = std::filesystem::absolute(inner);
  return std::ranges::mismatch(outer, whole).in1 == outer.end();
}

}  // namespace freeplay

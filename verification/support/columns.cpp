#include "verification/support/columns.hpp"

#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"

namespace freeplay::test {

Columns::Columns(const std::filesystem::path& file) {
  for (const auto& line : lines_of(file_text(file))) {
    const auto fields = fields_of(line);
    if (header_.empty()) {
      header_ = line;
      for (const auto& name : fields) index_.emplace(name, index_.size());
      continue;
    }
    if (fields.size() != index_.size()) throw std::runtime_error(file.string() + ": a line is too short");
    auto& row = rows_.emplace_back();
    for (const auto& field : fields) {
      char* end = nullptr;
      const double number = std::strtod(field.c_str(), &end);
      row.push_back(*end == '\0' && end != field.c_str() ? number : NAN);
    }
  }
}

}  // namespace freeplay::test

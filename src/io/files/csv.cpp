#include "io/files/csv.hpp"

namespace freeplay {

void TableCsv::save_to(MemoryWriter& m) {
  auto size = file_.settle();
  m(size, fresh_);
}

void TableCsv::load_from(MemoryReader& m) {
  m(from_, fresh_);
  file_.require(from_);
}

void TableCsv::head() {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (i > 0) file_.write(",");
    file_.write(columns_[i].name);
  }
  file_.write("\n");
}

void TableCsv::put(std::span<const double> numbers, std::span<const std::string_view> texts) {
  for (std::size_t i = 0, number = 0, text = 0; i < columns_.size(); ++i) {
    if (i > 0) file_.write(",");
    if (columns_[i].text)
      file_.write(texts[text++]);
    else
      file_.number(numbers[number++]);
  }
  file_.write("\n");
}

}  // namespace freeplay

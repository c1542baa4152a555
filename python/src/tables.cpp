#include "tables.hpp"

namespace freeplay::python {

void Words::add(std::string_view word) {
  auto at = known_.find(word);
  if (at == known_.end()) {
    at = known_.emplace(word, static_cast<std::int32_t>(names.size())).first;
    names.emplace_back(word);
  }
  codes.push_back(at->second);
}

void MemoryTable::head() {
  for (const auto& column : columns_)
    if (!column.text) names.push_back(column.name);
  texts.resize(columns_.size() - names.size());
}

void MemoryTable::put(std::span<const double> row, std::span<const std::string_view> words) {
  numbers.insert(numbers.end(), row.begin(), row.end());
  for (std::size_t i = 0; i < words.size(); ++i) texts[i].add(words[i]);
}

}  // namespace freeplay::python

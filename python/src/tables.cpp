#include "tables.hpp"

#include <nlohmann/json.hpp>

namespace py = pybind11;

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

py::dict object_of(const Table& table) {
  py::dict columns;
  for (std::size_t i = 0; i < table.columns().size(); ++i) {
    py::list list;
    for (const auto& row : table.rows())
      list.append(std::visit([](const auto& x) -> py::object { return py::cast(x); }, row[i]));
    columns[py::str(table.columns()[i])] = list;
  }
  return columns;
}

py::object object_of(const nlohmann::json& j) {
  if (j.is_object()) {
    py::dict d;
    for (const auto& [key, value] : j.items()) d[py::str(key)] = object_of(value);
    return d;
  }
  if (j.is_array()) {
    py::list list;
    for (const auto& value : j) list.append(object_of(value));
    return list;
  }
  if (j.is_string()) return py::str(j.get_ref<const std::string&>());
  if (j.is_boolean()) return py::bool_(j.get<bool>());
  if (j.is_number_integer()) return py::int_(j.get<std::int64_t>());
  if (j.is_number()) return py::float_(j.get<double>());
  return py::none();
}

}  // namespace freeplay::python

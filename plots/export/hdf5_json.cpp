#include "plots/export/hdf5_json.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "plots/tables/columns.hpp"

namespace freeplay::hdf5 {
namespace {

using Json = nlohmann::json;

constexpr std::size_t most_in_array = 4096;

constexpr std::pair<std::string_view, std::string_view> endings[] = {
    {"_m_per_s", "m/s"}, {"_N_s", "N s"}, {"_m", "m"}, {"_s", "s"},
    {"_J", "J"},         {"_rad", "rad"}, {"_N", "N"}, {"_Hz", "Hz"}};

std::string dumped(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

bool is_text(const Json& value) {
  // A text with a zero byte would be truncated there.
  return value.is_string() && value.get_ref<const std::string&>().find('\0') == std::string::npos;
}

/// Whether a double represents the value exactly. Other integers are written as text.
bool is_double(const Json& value) {
  if (value.is_number_float()) return true;
  constexpr double limit = 9007199254740992.0;  // 2^53
  return value.is_number() && std::abs(value.get<double>()) <= limit;
}

bool is_whole(const Json& value) {
  return value.is_number_integer() &&
         (!value.is_number_unsigned() ||
          value.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
}

void set(const File& file, hid_t at, const std::string& key, const Json& value) {
  const bool list = value.is_array() && !value.empty() && value.size() <= most_in_array;
  if (is_text(value))
    file.set(at, key, value.get<std::string>());
  else if (value.is_boolean())
    file.set(at, key, value.get<bool>());
  else if (is_whole(value))
    file.set(at, key, value.get<std::int64_t>());
  else if (value.is_number())
    file.set(at, key, value.get<double>());
  else if (list && std::ranges::all_of(value, is_double))
    file.set(at, key, value.get<std::vector<double>>());
  else if (list && std::ranges::all_of(value, is_text))
    file.set(at, key, value.get<std::vector<std::string>>());
  else
    file.set(at, key, dumped(value));
}

}  // namespace

void mirror(const File& file, hid_t at, const Json& object) {
  for (const auto& [key, value] : object.items())
    if (value.is_object())
      mirror(file, file.group(at, key).id(), value);
    else
      set(file, at, key, value);
}

std::size_t statistics(const File& file, hid_t at, const Json& run) {
  const auto contacts = run.find("contacts");
  if (contacts == run.end() || !contacts->is_object() || contacts->empty()) return 0;
  const auto count = contacts->size();
  std::size_t width = 1, row = 0;
  std::map<std::string, std::vector<double>> fields;
  const auto take = [&](const std::string& name, const Json& value) {
    if (!value.is_number()) return;
    fields.try_emplace(name, count, std::nan("")).first->second[row] = value.get<double>();
  };
  for (const auto& [name, facts] : contacts->items()) {
    width = std::max(width, name.size());
    if (facts.is_object())
      for (const auto& [key, value] : facts.items()) {
        take(key, value);
        if (key == "standard_errors" && value.is_object())
          for (const auto& [of, error] : value.items()) take(of + "_standard_error", error);
      }
    ++row;
  }
  std::vector<char> names(count * width, 0);
  row = 0;
  for (const auto& [name, facts] : contacts->items())
    std::ranges::copy(name, names.begin() + static_cast<std::ptrdiff_t>(width * row++));
  const auto group = file.group(at, "statistics");
  const Block block{count, count};
  file.write(file.texts(group.id(), "contact", block, width), 0, count, width, names);
  for (const auto& [name, values] : fields) {
    const auto column = file.numbers(group.id(), name, block);
    file.write(column, 0, values);
    file.set(column.id(), "units", unit_of(name));
  }
  file.set(group.id(), "rows", static_cast<std::int64_t>(count));
  return count;
}

std::string unit_of(const std::string& name) {
  constexpr std::string_view error = "_standard_error";
  if (name.ends_with(error)) return unit_of(name.substr(0, name.size() - error.size()));
  if (const auto unit = plots::unit_of_column(name); !unit.empty()) return std::string(unit);
  for (const auto& [end, unit] : endings)
    if (name.ends_with(end)) return std::string(unit);
  return "";
}

}  // namespace freeplay::hdf5

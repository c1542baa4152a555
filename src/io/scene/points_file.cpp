#include "io/scene/points_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "io/scene/toml_text.hpp"

namespace freeplay {

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r\"");
  if (first == text.npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r\"") - first + 1);
}

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> list;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) list.push_back(trimmed(field));
  if (!line.empty() && line.back() == ',') list.emplace_back();
  return list;
}

TextRows::TextRows(const std::string& text) : in_(text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text) {}

bool TextRows::next() {
  for (std::string line; std::getline(in_, line);) {
    ++number_;
    if (trimmed(line).empty() || line[0] == '#') continue;
    fields_ = freeplay::fields(line);
    return true;
  }
  return false;
}

std::string wrong_separator(const std::string& header) {
  if (header.find(',') != header.npos) return "";
  for (const auto& [sign, word] : {std::pair{';', "semicolons"}, {'\t', "tabs"}})
    if (header.find(sign) != header.npos)
      return fmt::format(
          "the columns are separated by {}; separate them by commas, and write numbers with a decimal "
          "point, not a decimal comma",
          word);
  return "";
}

std::string wrong_count(std::size_t fields, std::size_t columns) {
  return fmt::format("has {} field{}, the header has {}", fields, fields == 1 ? "" : "s", columns);
}

std::optional<double> number_in(std::string_view text) {
  double x = 0;
  const auto* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, x);
  return error == std::errc() && stop == end ? std::optional(x) : std::nullopt;
}

std::vector<std::pair<double, double>> read_points(const std::string& text,
                                                   const std::vector<std::string>& columns,
                                                   const std::function<void(const std::string&)>& fail) {
  TextRows rows(text);
  std::vector<std::pair<double, double>> points;
  if (!rows.next()) return points;
  const auto header = rows.fields();
  if (header.size() == 1)
    if (const auto what = wrong_separator(header.front()); !what.empty())
      fail(fmt::format("line {}: {}", rows.number(), what));
  if (header.size() < 2)
    fail(fmt::format("line {}: expected a header of at least two columns", rows.number()));
  if (std::ranges::all_of(header, [](const std::string& field) { return number_in(field).has_value(); }))
    fail(fmt::format("line {}: expected a header with the names of the columns, found numbers",
                     rows.number()));
  std::array<std::size_t, 2> place{0, 1};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto found = std::ranges::find(header, columns[i]);
    if (found == header.end()) {
      std::string names;
      for (const auto& name : header) names += (names.empty() ? "" : ", ") + toml_quoted(name);
      fail(fmt::format("has no column {}; there are: {}", toml_quoted(columns[i]), names));
    }
    place[i] = static_cast<std::size_t>(found - header.begin());
  }
  while (rows.next()) {
    const auto& list = rows.fields();
    if (list.size() != header.size())
      fail(fmt::format("line {} {}", rows.number(), wrong_count(list.size(), header.size())));
    std::array<double, 2> point{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& field = list[place[i]];
      const auto x = number_in(field);
      if (!x || !std::isfinite(*x))
        fail(fmt::format("line {}: {}: {} is not a finite number", rows.number(), header[place[i]],
                         toml_quoted(field)));
      point[i] = *x;
    }
    points.emplace_back(point[0], point[1]);
  }
  return points;
}

}  // namespace freeplay

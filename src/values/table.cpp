#include "values/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

namespace freeplay {
namespace {

std::vector<std::string> texts_of(const std::vector<Table::Cell>& row) {
  std::vector<std::string> texts;
  for (const auto& cell : row)
    texts.push_back(std::visit([](const auto& x) { return fmt::format("{}", x); }, cell));
  return texts;
}

std::string trimmed(std::string line) {
  while (line.ends_with(' ')) line.pop_back();
  return line + "\n";
}

std::string aligned(const std::vector<std::string>& cells, const std::vector<int>& widths) {
  const auto& first = cells.front();
  const auto columns = std::ranges::count_if(first, [](char c) { return (c & 0xC0) != 0x80; });
  std::string line;
  if (widths.front() < 0)
    line = fmt::format("{:>{}}", first, -widths.front());
  else if (columns > widths.front())
    line = fmt::format("{}\n{:{}}", first, "", widths.front());
  else
    line = fmt::format("{:<{}}", first, widths.front());
  for (std::size_t i = 1; i < cells.size(); ++i) line += fmt::format(" {:>{}}", cells[i], widths[i] - 1);
  return trimmed(std::move(line));
}

}  // namespace

Table::Table(const char* names) {
  const std::string_view header = names;
  for (std::size_t from = 0, to = 0; to != header.npos; from = to + 1) {
    to = header.find(',', from);
    columns_.emplace_back(header.substr(from, to == header.npos ? to : to - from));
  }
}

std::string Table::csv_header() const { return fmt::format("{}\n", fmt::join(columns_, ",")); }

std::string Table::csv_rows(std::size_t from) const {
  std::string text;
  for (std::size_t i = from; i < rows_.size(); ++i)
    text += fmt::format("{}\n", fmt::join(texts_of(rows_[i]), ","));
  return text;
}

std::string Table::markdown() const {
  auto text = fmt::format("| {} |\n|", fmt::join(columns_, " | "));
  for (std::size_t i = 0; i < columns_.size(); ++i) text += " --- |";
  text += "\n";
  for (const auto& row : rows_) text += fmt::format("| {} |\n", fmt::join(texts_of(row), " | "));
  return text;
}

std::string Table::terminal(const std::vector<int>& widths, bool rule) const {
  auto text = aligned(columns_, widths);
  std::string line;
  for (std::size_t i = 0; rule && i < widths.size(); ++i)
    line +=
        std::string(i == 0 ? 0 : 1, ' ') + std::string(static_cast<std::size_t>(widths[i] - (i > 0)), '-');
  if (rule) text += line + "\n";
  for (const auto& row : rows_) text += aligned(texts_of(row), widths);
  return text;
}

}  // namespace freeplay

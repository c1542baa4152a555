#include "plots/tables/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/files/escaping.hpp"
#include "io/scene/points_file.hpp"
#include "mechanism/error.hpp"
#include "values/name_length.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t longest_label = 200;
constexpr std::size_t most_rows = 10'000'000;  ///< at most, of a table that is read as a whole

bool is_name(std::string_view text) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view(" _-+.:").find(c) != std::string_view::npos;
  };
  return !text.empty() && text.size() <= longest_entry && std::ranges::all_of(text, plain);
}

}  // namespace

Rows::Rows(const std::filesystem::path& file) : file_(file.string()), lines_(file) {
  if (!lines_.next(line_))
    throw SceneError(file_ + ": is empty; expected a header with the names of columns");
  split();
  names_.assign(fields_.begin(), fields_.end());
  for (std::size_t i = 0; i < names_.size(); ++i)
    if (!is_name(names_[i])) refuse(i, "the name of a column");
}

void Rows::split() {
  fields_.clear();
  const std::string_view line = line_;
  for (std::size_t from = 0, to = 0; from <= line.size(); from = to + 1) {
    to = std::min(line.find(',', from), line.size());
    fields_.push_back(line.substr(from, to - from));
  }
}

bool Rows::next() {
  if (!lines_.next(line_)) return false;
  split();
  if (fields_.size() != names_.size())
    throw SceneError(
        fmt::format("{}:{}: {}", file_, lines_.number(), wrong_count(fields_.size(), names_.size())));
  return true;
}

bool Rows::has(std::string_view column) const { return std::ranges::find(names_, column) != names_.end(); }

std::size_t Rows::place(std::string_view column) const {
  const auto it = std::ranges::find(names_, column);
  if (it == names_.end()) throw SceneError(fmt::format("{}:1: has no column {}", file_, column));
  return static_cast<std::size_t>(it - names_.begin());
}

void Rows::refuse(std::size_t place, const char* must) const {
  throw SceneError(fmt::format(
      "{}:{}: field {}{}: must be {}, is \"{}\"", file_, lines_.number(), place + 1,
      place < names_.size() && lines_.number() > 1 ? " (" + visible_brief(names_[place]) + ")" : "", must,
      visible_brief(fields_[place], 60)));
}

double Rows::number(std::size_t place) const {
  const auto x = number_in(fields_[place]);
  if (!x) refuse(place, "a number");
  return *x;
}

double Rows::maybe_number(std::size_t place) const {
  return fields_[place].empty() ? std::nan("") : number(place);
}

std::string Rows::name(std::size_t place) const {
  if (!is_name(fields_[place])) refuse(place, "a name");
  return std::string(fields_[place]);
}

std::string Rows::label(std::size_t place) const {
  const auto text = fields_[place];
  if (text.empty() || text.size() > longest_label || visible(text) != text) refuse(place, "a short text");
  return std::string(text);
}

std::string Rows::maybe_label(std::size_t place) const { return fields_[place].empty() ? "" : label(place); }

ReadTable::ReadTable(const std::filesystem::path& file, const std::vector<std::string>& names,
                     const std::vector<std::string>& numbers, const std::vector<std::string>& labels) {
  Rows in(file);
  struct Taken {
    std::size_t place;
    std::vector<std::string>* list;
    bool name;
  };
  std::vector<Taken> taken;
  for (const auto& column : names) taken.push_back({in.place(column), &texts_[column], true});
  for (const auto& column : labels) taken.push_back({in.place(column), &texts_[column], false});
  std::vector<std::pair<std::size_t, std::vector<double>*>> counted;
  for (const auto& column : numbers) counted.emplace_back(in.place(column), &numbers_[column]);
  while (in.next()) {
    if (++rows_ > most_rows)
      throw SceneError(
          fmt::format("{}: has more than {} rows and is not a table of freeplay", file.string(), most_rows));
    for (const auto& t : taken) t.list->push_back(t.name ? in.name(t.place) : in.maybe_label(t.place));
    for (const auto& [place, list] : counted) list->push_back(in.number(place));
  }
}

std::size_t place_in(std::vector<std::string>& list, std::string_view text) {
  const auto it = std::ranges::find(list, text);
  if (it != list.end()) return static_cast<std::size_t>(it - list.begin());
  list.emplace_back(text);
  return list.size() - 1;
}

}  // namespace freeplay::plots

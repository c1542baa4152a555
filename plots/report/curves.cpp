#include "plots/report/curves.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "plots/report/thinning.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::report {
namespace {

using nlohmann::json;

constexpr long fewest = 60, greatest = 4000;  // limits of the number of values per curve

json curves_of(const std::string& file, long rows, const std::vector<std::string>& names,
               const ThinnedTable& table) {
  json out = {{"file", file}, {"rows", rows}, {"t", numbers(table.t(), 8)}, {"columns", json::array()}};
  for (std::size_t k = 0; k < names.size(); ++k)
    out["columns"].push_back(
        {{"name", names[k]}, {"unit", plots::unit_of_column(names[k])}, {"y", numbers(table.column(k), 5)}});
  return out;
}

long rows_of(const std::filesystem::path& file) {
  LineReader lines(file);
  std::string line;
  long count = -1;  // does not count the header
  while (lines.next(line)) ++count;
  return count;
}

json table(const std::filesystem::path& file, long most) {
  plots::Rows rows(file);
  const auto t = rows.place("t");
  std::vector<std::string> names;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < rows.names().size(); ++i)
    if (i != t) names.push_back(rows.names()[i]), places.push_back(i);
  const long count = rows_of(file);
  ThinnedTable thinned(count, names.size(), most);
  std::vector<double> values(names.size());
  while (rows.next()) {
    for (std::size_t k = 0; k < names.size(); ++k) values[k] = rows.maybe_number(places[k]);
    thinned.take(rows.number(t), values);
  }
  thinned.finish();
  return curves_of(file.filename().string(), count, names, thinned);
}

/// Number of samples of each channel, in the order of the file.
std::vector<std::pair<std::string, long>> channels_in(const std::filesystem::path& file) {
  std::vector<std::pair<std::string, long>> list;
  plots::Rows rows(file);
  const auto channel = rows.place("channel");
  while (rows.next()) {
    const auto& name = rows.name(channel);
    const auto it = std::ranges::find(list, name, [](const auto& c) { return c.first; });
    if (it == list.end())
      list.emplace_back(name, 1);
    else
      ++it->second;
  }
  return list;
}

void signals(const std::filesystem::path& file, long most, json& out) {
  const auto channels = channels_in(file);
  std::map<std::string, ThinnedTable, std::less<>> tables;
  for (const auto& [name, count] : channels) tables.emplace(name, ThinnedTable(count, 1, most));
  plots::Rows rows(file);
  const auto channel = rows.place("channel"), t = rows.place("t"), value = rows.place("value");
  while (rows.next()) {
    const double y = rows.maybe_number(value);
    tables.find(rows.name(channel))->second.take(rows.number(t), {&y, 1});
  }
  const plots::RunColumns columns(file.parent_path());
  for (const auto& [name, count] : channels) {
    auto& thinned = tables.find(name)->second;
    thinned.finish();
    out.push_back(curves_of("signals.csv", count, {name}, thinned));
    if (const auto* column = columns.find(name)) out.back()["columns"][0]["unit"] = column->unit;
  }
}

}  // namespace

json curves(const std::filesystem::path& folder, long most) {
  std::size_t columns = 0;
  for (const char* name : {"trajectory.csv", "forces.csv"})
    if (std::filesystem::exists(folder / name)) columns += plots::Rows(folder / name).names().size();
  const bool sampled = std::filesystem::exists(folder / "signals.csv");
  if (sampled) columns += channels_in(folder / "signals.csv").size();
  const long each = std::clamp(most / static_cast<long>(columns + 1), fewest, greatest);
  auto out = json::array();
  if (sampled) signals(folder / "signals.csv", each, out);
  for (const char* name : {"trajectory.csv", "forces.csv"})
    if (std::filesystem::exists(folder / name)) out.push_back(table(folder / name, each));
  return out;
}

}  // namespace freeplay::report

#include "plots/tables/run_table.hpp"

#include <algorithm>

#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

constexpr const char* coordinates[] = {".x", ".y", ".theta", ".vx", ".vy", ".omega"};

}  // namespace

RunTable motion_of(const std::filesystem::path& run, const Span& span, std::size_t most_bodies, long rows) {
  const auto file = run / "trajectory.csv";
  long count = 0;
  {
    Rows in(file);
    const auto t = in.place("t");
    while (in.next()) count += span.holds(in.number(t));
  }
  RunTable table;
  Rows in(file);
  const auto t = in.place("t");
  std::vector<std::array<std::size_t, 6>> places;
  for (const auto& name : in.names()) {
    if (!name.ends_with(".omega") || table.bodies.size() == most_bodies) continue;
    const auto body = name.substr(0, name.size() - 6);
    auto& list = places.emplace_back();
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = in.place(body + coordinates[i]);
    table.bodies.push_back(body);
  }
  table.motion.resize(table.bodies.size());
  const long each = 1 + count / rows;
  for (long seen = 0; in.next();) {
    const double time = in.number(t);
    if (!span.holds(time) || seen++ % each != 0) continue;
    table.t.push_back(time);
    for (std::size_t b = 0; b < places.size(); ++b)
      for (std::size_t i = 0; i < 6; ++i) table.motion[b][i].push_back(in.number(places[b][i]));
  }
  return table;
}

double range_of(const std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(values);
  return most - least;
}

}  // namespace freeplay::plots

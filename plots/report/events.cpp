#include "plots/report/events.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "plots/report/thinning.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::report {
namespace {

/// Orders by impulse, then by approach speed, because the onset of a lasting contact has no impulse
/// yet.
bool harder(const Event& a, const Event& b) {
  const double p = std::abs(a.impulse), q = std::abs(b.impulse);
  return p != q ? p > q : std::abs(a.approach) > std::abs(b.approach);
}

void keep_hardest(std::vector<Event>& list, std::size_t most) {
  if (list.size() <= most) return;
  std::ranges::nth_element(list, list.begin() + static_cast<std::ptrdiff_t>(most), harder);
  list.resize(most);
}

}  // namespace

Events read_events(const std::filesystem::path& folder, std::size_t most) {
  Events events;
  const auto file = folder / "events.csv";
  if (!std::filesystem::exists(file)) return events;
  plots::Rows rows(file);
  const auto t = rows.place("t"), joint = rows.place("joint"), kind = rows.place("kind"),
             approach = rows.place("v_n_minus"), impulse = rows.place("impulse_n"),
             duration = rows.place("duration");
  while (rows.next()) {
    ++events.all;
    const auto number = [&](std::size_t place) {
      const double x = rows.maybe_number(place);
      return std::isfinite(x) ? x : 0;
    };
    events.list.push_back({rows.number(t), number(approach), number(impulse), number(duration),
                           plots::place_in(events.joints, rows.name(joint)),
                           static_cast<int>(plots::place_in(events.kinds, rows.name(kind)))});
    if (events.list.size() >= 4 * most) keep_hardest(events.list, most);
  }
  keep_hardest(events.list, most);
  std::ranges::stable_sort(events.list, {}, &Event::t);
  return events;
}

std::vector<double> hardest(const Events& events, std::size_t most) {
  auto list = events.list;
  keep_hardest(list, most);
  std::vector<double> times;
  for (const auto& e : list) times.push_back(e.t);
  std::ranges::sort(times);
  return times;
}

nlohmann::json to_json(const Events& events) {
  std::vector<double> t, approach, impulse, duration;
  std::vector<std::size_t> joint;
  std::vector<int> kind;
  for (const auto& e : events.list) {
    t.push_back(e.t), approach.push_back(e.approach), impulse.push_back(e.impulse);
    duration.push_back(e.duration), joint.push_back(e.joint), kind.push_back(e.kind);
  }
  return {{"joints", events.joints},   {"kinds", events.kinds},    {"all", events.all},
          {"t", numbers(t, 10)},       {"joint", joint},           {"kind", kind},
          {"v", numbers(approach, 5)}, {"p", numbers(impulse, 5)}, {"d", numbers(duration, 5)}};
}

}  // namespace freeplay::report

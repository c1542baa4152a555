// The events of a run for a page: all of them, or where there are very many the hardest; which rows of the trajectory stand
// beside each.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace freeplay::report {

struct Event {
  double t, approach, impulse, duration;  ///< s, m/s, N s, s
  std::size_t joint;                      ///< in Events::joints
  int kind;                               ///< in Events::kinds
};

struct Events {
  std::vector<Event> list;          ///< in the order of time
  std::vector<std::string> joints;  ///< names
  std::vector<std::string> kinds;   ///< impact, contact, separation
  long all = 0;                     ///< in the file
};

/// Those of events.csv in a folder, none where it has none; at most so many, the hardest.
Events read_events(const std::filesystem::path& folder, std::size_t most);

/// Times of at most so many, the hardest, in their order.
std::vector<double> hardest(const Events& events, std::size_t most);

nlohmann::json to_json(const Events& events);

}  // namespace freeplay::report

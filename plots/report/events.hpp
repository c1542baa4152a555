// The events of a run for a page: all events, or the hardest if there are too many.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace freeplay::report {

struct Event {
  double t, approach, impulse, duration;  ///< s, m/s, N s, s
  std::size_t joint;                      ///< index in Events::joints
  int kind;                               ///< index in Events::kinds
};

struct Events {
  std::vector<Event> list;          ///< in the order of time
  std::vector<std::string> joints;  ///< names
  std::vector<std::string> kinds;   ///< impact, contact, separation
  long all = 0;                     ///< number of events in the file
};

/// Reads events.csv of a folder; empty if there is no such file. If there are more than `most`
/// events, only the hardest.
Events read_events(const std::filesystem::path& folder, std::size_t most);

/// Times of the hardest events, at most `most`, in ascending order.
std::vector<double> hardest(const Events& events, std::size_t most);

nlohmann::json to_json(const Events& events);

}  // namespace freeplay::report

// The data of a run for a page: its events (all, or the hardest if there are too many), the columns of its
// tables as curves, and its motion.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay {
struct Scene;
}

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

/// Names, units and thinned values of trajectory.csv, forces.csv and each channel of signals.csv;
/// about `most` numbers in all. Throws SceneError for invalid tables.
nlohmann::json curves(const std::filesystem::path& folder, long most);

// The motion of a run as frames for a page: poses of the bodies, positions within the clearance of
// joints, contact forces. A long run has every n-th row, the rows before and after each selected
// event, and the first and last row.

/// Number of values per frame of the run in a folder.
long numbers_of_frame(const std::filesystem::path& folder, const Scene* scene);

/// The frames, about `most` and those beside `times` (s), and the shapes of the scene (if given) in
/// the frames of their bodies. `beams`: the points of each beam's line (io/scene/beam_line.hpp) as
/// [body, x, y, body, x, y, share, unloaded x, y]. Throws SceneError for invalid tables.
nlohmann::json motion(const std::filesystem::path& folder, const Scene* scene, long most,
                      const std::vector<double>& times);

}  // namespace freeplay::report

// A scene: a mechanism together with what the author of the scene asks of a run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/error.hpp"
#include "mechanism/instrument.hpp"
#include "mechanism/mechanism.hpp"
#include "mechanism/options.hpp"
#include "values/read_file.hpp"

namespace freeplay {

/// Of scene files. Defaults may change with a newer one only: a scene that states its format keeps its meaning.
inline constexpr int newest_format = 2;

struct Scene {
  std::filesystem::path file;
  std::optional<int> format;           ///< as the file states it; without one it is read as newest_format
  std::string text;                    ///< as read, for the provenance of results
  std::vector<std::string> overrides;  ///< KEY=VALUE as given
  std::vector<std::string> idle;       ///< keys of the file that an option's choice does not read, and why
  bool outside = false;                ///< files that it names may lie anywhere, not only beside it or below
  std::vector<ReadFile> files;         ///< that its text names, as read
  Mechanism mechanism;
  RunOptions run;
  PenaltyOptions penalty;
  NonsmoothOptions nonsmooth;
  std::vector<Instrument> instruments;

  /// Sets any key of docs/reference/scene.md as `--set KEY=VALUE` does: a scene that still is what its text and
  /// overrides say is read again with one more override, so what the text derives from the key follows (the
  /// duration of so many revolutions follows the speed). One that was built or changed in code keeps its
  /// other facts as they are: its text becomes to_toml() of them, in seconds and rad/s. Throws SceneError,
  /// which names KEY=VALUE; then the scene is as it was.
  void set(const std::string& key, const std::string& value);
  void set(const std::string& key, double value);
};

/// Reads and validates a scene; each override is KEY=VALUE with a dotted key. `outside`: as in Scene. Throws SceneError.
Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {},
                 bool outside = false);
/// The same from text; `name` stands for the file in messages.
Scene parse_scene(const std::string& text, const std::string& name,
                  const std::vector<std::string>& overrides = {}, bool outside = false);

}  // namespace freeplay

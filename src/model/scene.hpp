// A scene: a mechanism together with what the author of the scene asks of a run.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/instrument.hpp"
#include "model/mechanism.hpp"
#include "model/options.hpp"

namespace freeplay {

/// Of scene files. Defaults may change with a newer one only: a scene that states its format keeps its meaning.
inline constexpr int newest_format = 1;

struct Scene {
  std::filesystem::path file;
  std::optional<int> format;           ///< as the file states it; without one it is read as newest_format
  std::string text;                    ///< as read, for the provenance of results
  std::vector<std::string> overrides;  ///< KEY=VALUE as given
  Mechanism mechanism;
  RunOptions run;
  PenaltyOptions penalty;
  NonsmoothOptions nonsmooth;
  std::vector<Instrument> instruments;

  /// Sets any key of docs/scene.md as `--set KEY=VALUE` does: a scene that still is what its text and
  /// overrides say is read again with one more override, so what the text derives from the key follows (the
  /// duration of so many revolutions follows the speed). One that was built or changed in code keeps its
  /// other facts as they are: its text becomes to_toml() of them, in seconds and rad/s. Throws SceneError,
  /// which names KEY=VALUE; then the scene is as it was.
  void set(const std::string& key, const std::string& value);
  void set(const std::string& key, double value);
};

/// What a scene lacks or contradicts, in terms of the model. what() is "key: what is wrong, what would be right",
/// without a key where none is to blame.
struct ModelError : std::runtime_error {
  ModelError(const std::string& blamed, const std::string& wrong)
      : std::runtime_error(blamed.empty() ? wrong : blamed + ": " + wrong), key(blamed), message(wrong) {}
  std::string key;      ///< dotted
  std::string message;  ///< without the key

 protected:
  ModelError(const std::string& what, const std::string& blamed, const std::string& wrong)
      : std::runtime_error(what), key(blamed), message(wrong) {}
};

/// The same with its place in a file. what() is the one line that a user gets: FILE:LINE:COL: key: what is wrong, what would be
/// right.
struct SceneError : ModelError {
  explicit SceneError(const std::string& what) : ModelError("", what) {}
  /// `place`: FILE:LINE:COL, or what else the key was set by; empty in code.
  SceneError(const std::string& place, const std::string& blamed, const std::string& wrong)
      : ModelError((place.empty() ? "" : place + ": ") + blamed + ": " + wrong, blamed, wrong) {}
};

/// Reads and validates a scene; each override is KEY=VALUE with a dotted key. Throws SceneError.
Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
/// The same from text; `name` stands for the file in messages.
Scene parse_scene(const std::string& text, const std::string& name,
                  const std::vector<std::string>& overrides = {});

}  // namespace freeplay

// A scene: one mechanism and the options of its run, as a user writes them in a TOML file
// (docs/reference/scene.md).
//
// Usage:
//
//     Scene scene = read_scene("four-bar.toml", {"run.duration=0.5"});
//     scene.set("bodies.crank.mass", 0.2);
//
// A Scene is a plain value. It owns its mechanism, its options and the text it was read from. It
// knows nothing about solvers: formulations/ reads the options, dynamics/ the mechanism.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/error.hpp"
#include "mechanism/instrument.hpp"
#include "mechanism/mechanism.hpp"
#include "mechanism/options.hpp"
#include "mechanism/tolerance.hpp"
#include "values/read_file.hpp"

namespace freeplay {

/// Newest format of scene files. Only a newer format may change a default, so a scene that states
/// its format keeps its meaning.
inline constexpr int newest_format = 2;

/// A mechanism and the options of its run.
struct Scene {
  /// from which it was read; empty for a scene made in code
  std::filesystem::path file;
  /// As stated in the file; a file without it is read as newest_format.
  std::optional<int> format;
  std::string text;                    ///< as read; results store it as provenance
  std::vector<std::string> overrides;  ///< KEY=VALUE as given
  /// Keys of the file that the chosen options do not read, with the reason.
  std::vector<std::string> idle;
  bool outside = false;         ///< whether the scene may name files outside its own folder
  std::vector<ReadFile> files;  ///< files that the text names, as read
  /// the elements
  Mechanism mechanism;
  /// [run]
  RunOptions run;
  /// [penalty]
  PenaltyOptions penalty;
  /// [nonsmooth]
  NonsmoothOptions nonsmooth;
  /// the instruments, in the scene's order
  std::vector<Instrument> instruments;
  /// [tolerances]
  std::vector<Tolerance> tolerances;

  /// Sets any key of docs/reference/scene.md, as `--set KEY=VALUE` does. Throws SceneError, which
  /// names KEY=VALUE; the scene is then unchanged.
  ///
  /// If the scene still equals its text and overrides, it is read again with one more override.
  /// Values that the text derives from the key are therefore updated: a duration given in
  /// revolutions follows the speed. If the scene was built or changed in code, its other values are
  /// kept: its text becomes its to_toml(), in seconds and rad/s.
  void set(const std::string& key, const std::string& value);
  /// As above, with a number in SI units.
  void set(const std::string& key, double value);
};

/// Reads and validates a scene. Each override is KEY=VALUE with a dotted key; `outside` as in
/// Scene. Throws SceneError.
Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {},
                 bool outside = false);
/// Reads and validates a scene from text; messages use `name` in place of the file.
Scene parse_scene(const std::string& text, const std::string& name,
                  const std::vector<std::string>& overrides = {}, bool outside = false);

}  // namespace freeplay

// SceneText: what a scene's file and options state, as a parsed document, and Parameter: a stated number by
// its path. One rule holds for all ways to set a key (--set, Scene::set(), axes of studies, unknowns of
// calibrations, keys of sensitivities and of branches): the stated value is set, and the scene is read again.
// All that follows from the value (unit axes, radii, durations in turns, positions relative to named points)
// is thereby derived again.
//
//     SceneText(text, name, {"joints.pin.clearance=1e-3"}).read()    a scene
//     Parameter(scene, "joints.pin.at[0][1]").at(0.2)                the scene with another value
//
// A SceneText owns its document and refers to nothing.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/scene/section.hpp"
#include "mechanism/outside.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

/// A key and the indices of a number within its list: KEY, KEY[i] or KEY[i][j].
struct Path {
  std::string key;
  std::vector<std::size_t> places = {};
  /// Throws ModelError if the brackets do not hold whole numbers.
  static Path of(std::string_view name);
};

/// A parsed document. Its copies keep the positions in the text, which those of a toml::table lose.
struct PlacedDocument {
  toml::table table;
  PlacedDocument() = default;
  explicit PlacedDocument(toml::table parsed) : table(std::move(parsed)) {}
  PlacedDocument(const PlacedDocument& other);
  PlacedDocument& operator=(const PlacedDocument& other) { return *this = PlacedDocument(other); }
  PlacedDocument(PlacedDocument&&) noexcept = default;
  PlacedDocument& operator=(PlacedDocument&&) noexcept = default;
  ~PlacedDocument() = default;
};

class SceneText {
 public:
  /// Of a text with options KEY=VALUE; the other parameters as of parse_scene(). Throws SceneError.
  SceneText(const std::string& text, const std::string& name, const std::vector<std::string>& options = {},
            bool outside = false);
  /// Of a scene: its text and options, if it still equals what they state, otherwise its canonical text.
  explicit SceneText(const Scene& scene);
  /// The canonical text of a scene.
  static SceneText canonical(const Scene& scene);

  /// Whether it is the text of a scene rather than its canonical text.
  bool is_original() const { return original_; }
  /// The options that were set, KEY=VALUE.
  const std::vector<std::string>& options() const { return options_; }
  /// Sets KEY=VALUE. A value that is not valid TOML is taken as a text. A list that the document does not
  /// have, or in which a name or a grid stands for numbers, becomes that of the canonical text. Throws
  /// SceneError.
  void set(const std::string& given);
  /// The scene with one more option; see Scene::set(). Throws SceneError.
  Scene with(const std::string& key, const std::string& value) const;
  /// Reads and validates the scene (io/scene/read_scene.cpp). Throws SceneError.
  Scene read() const;

  /// The value of a key, or the number at its places in it; nullptr if there is none.
  const toml::node* find(const Path& path) const;
  /// Throws a SceneError about a key, with the position of it or of the innermost table around it.
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

 private:
  SceneText() = default;
  void erase_replaced(const std::string& key);

  std::string text_;
  std::vector<std::string> options_;
  bool outside_ = false, original_ = true;
  Outside in_code_;             // laws and forces that no text states
  double discard_ = 0;          // s, of a scene in code
  std::filesystem::path file_;  // of a scene in code
  SceneSource source_;
  PlacedDocument document_;
};

/// A number of a scene by its path.
class Parameter {
 public:
  /// Throws ModelError if the scene states no such number.
  Parameter(const Scene& scene, std::string path);
  const std::string& path() const { return path_; }
  /// SI; as the text states it, or as the canonical text does if the text states it with a unit or by another
  /// key.
  double value() const { return value_; }
  /// The greatest absolute number of its list.
  double greatest() const { return greatest_; }
  /// The scene with another value (SI). Throws SceneError.
  Scene at(double value) const;

 private:
  std::string path_;
  SceneText text_;
  double value_ = 0, greatest_ = 0;
};

}  // namespace freeplay

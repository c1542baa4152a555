// What is wrong with a scene: what a user of the model catches.
#pragma once

#include <stdexcept>
#include <string>

namespace freeplay {

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

/// Of a key that the choices in force do not read (OwnKey in mechanism/options.hpp).
struct UnreadKey : SceneError {
  explicit UnreadKey(const SceneError& e) : SceneError(e) {}
};

}  // namespace freeplay

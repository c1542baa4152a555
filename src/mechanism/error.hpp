// Exceptions for faulty scenes and mechanisms.
#pragma once

#include <stdexcept>
#include <string>

namespace freeplay {

/// A missing or contradictory fact, in terms of the model. what() is "key: what is wrong, what
/// would be right", without the key if no single key is at fault.
struct ModelError : std::runtime_error {
  /// `blamed` is the key, `wrong` completes the message about it.
  ModelError(const std::string& blamed, const std::string& wrong)
      : std::runtime_error(blamed.empty() ? wrong : blamed + ": " + wrong), key(blamed), message(wrong) {}
  std::string key;      ///< dotted
  std::string message;  ///< without the key

 protected:
  /// As above, with a complete message.
  ModelError(const std::string& what, const std::string& blamed, const std::string& wrong)
      : std::runtime_error(what), key(blamed), message(wrong) {}
};

/// A ModelError with its place in a file. what() is the one line that a user sees: FILE:LINE:COL:
/// key: what is wrong, what would be right.
struct SceneError : ModelError {
  /// With a complete message.
  explicit SceneError(const std::string& what) : ModelError("", what) {}
  /// `place`: FILE:LINE:COL, or another source of the value, such as an override; empty in code.
  SceneError(const std::string& place, const std::string& blamed, const std::string& wrong)
      : ModelError((place.empty() ? "" : place + ": ") + blamed + ": " + wrong, blamed, wrong) {}
};

/// A key that the current choices do not read (OwnKey in mechanism/options.hpp).
struct UnreadKey : SceneError {
  /// From the error of the key.
  explicit UnreadKey(const SceneError& e) : SceneError(e) {}
};

}  // namespace freeplay

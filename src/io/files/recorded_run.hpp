// A run read back: from its identity, or from its run.json.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "io/files/identity.hpp"
#include "mechanism/scene.hpp"
#include "values/identity.hpp"
#include "values/state.hpp"

namespace freeplay {

/// What an identity says to do.
struct Setup {
  Scene scene;
  std::string formulation;
  bool matched = false;
  std::optional<State> start;
  /// What the run had from outside, by what it was for ("normal forces").
  struct FromOutside {
    std::string name, digest;
  };
  std::map<std::string, FromOutside> outside;

  /// Puts it into the scene. Throws SceneError where it is not the run's, or the run had some and none is given.
  void give(const Outside& given);
};

/// The facts and how to run them from the identity alone, the rest of the scene from `origin`. Throws SceneError
/// when it is not the identity of a single run.
Setup setup_of(const Identity& identity, const Origin& origin);

/// A run as its run.json tells it.
struct RecordedRun {
  Identity identity;
  Setup setup;  ///< its scene has file, text and overrides of the run, for its provenance
};

/// Throws SceneError for what is no run.json, is damaged, or was made before runs had an identity.
RecordedRun read_run(const std::filesystem::path& file);

}  // namespace freeplay

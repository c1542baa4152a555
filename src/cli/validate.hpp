// Options of `freeplay validate`, for a scene or a study.
#pragma once

#include "cli/command_line.hpp"

namespace freeplay::cli {

/// Options of the verb.
struct ValidateRequest : Request {
  std::string scene;            ///< file of the scene or study
  Reach reach = Reach::beside;  ///< permitted files of a study
  /// Measured file; empty: compare a study with published findings.
  std::string data;
  std::vector<std::string> overrides;  ///< of a scene
  std::string output;                  ///< result folder
  double revolutions = 0;              ///< compared, of each model; 0: chosen from the file
  bool remove_offset = false;          ///< of the measured signal from the ideal mechanism's mean
  bool as_given = false;               ///< the impact law takes the surfaces' restitution unchanged
  std::string document;                ///< folder for experiment.md of a study and its figures
};

/// Validates a study; returns the exit status.
int validate_study(const ValidateRequest& request);

}  // namespace freeplay::cli

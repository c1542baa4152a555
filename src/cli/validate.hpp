// What `freeplay validate` is asked with, of a scene or of a study.
#pragma once

#include "cli/verb.hpp"

namespace freeplay::cli {

struct ValidateRequest : Request {
  std::string scene;                   ///< scene's or study's file
  Reach reach = Reach::beside;         ///< of a study
  std::string data;                    ///< measured file; none: a study against published findings
  std::vector<std::string> overrides;  ///< of a scene
  std::string output;                  ///< result folder
  bool as_given = false;               ///< the impact law at the restitution asked for
  std::string document;                ///< folder for a study's experiment.md and its figures
};

int validate_study(const ValidateRequest& request);

}  // namespace freeplay::cli

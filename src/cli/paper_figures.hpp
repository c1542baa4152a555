// Figures of a published paper: the runs that they need, and their drawing.
#pragma once

#include <string>
#include <vector>

#include "cli/verb.hpp"

namespace freeplay::cli {

/// Papers whose figures can be drawn.
std::vector<std::string> papers();

struct PaperRequest {
  std::string paper;   ///< one of papers()
  std::string output;  ///< result folder; empty: out/paper-NAME
  int threads = 0;     ///< 0: all cores
};

/// Makes the missing runs of the paper's study in the result folder and draws the figures by their
/// numbers in the paper. A folder with the results of `validate` is drawn as it is, without runs.
/// Returns the exit status.
int paper_figures(const PaperRequest& request, const Conduct& conduct);

}  // namespace freeplay::cli

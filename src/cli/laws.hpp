// freeplay laws SCENE --film JOINT: steady running of a lubricated joint.
#pragma once

#include <optional>
#include <string>

namespace freeplay {
struct Scene;
}

namespace freeplay::cli {

struct FilmRequest {
  std::string joint;
  std::optional<double> load;  ///< N
  std::optional<double> rpm;   ///< of the journal, in a bearing at rest
  std::string output;          ///< result folder; empty: no files
};

/// Prints the equilibrium and the linear coefficients at a load and a speed, or without them a table
/// over the eccentricity ratio. With an output folder, film.csv or film.json has all digits.
/// Throws SceneError if the joint has no film or the film cannot carry the load.
void report_film(const Scene& scene, const FilmRequest& request);

}  // namespace freeplay::cli

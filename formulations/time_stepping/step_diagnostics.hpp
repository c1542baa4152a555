// StepDiagnostics: diagnostics of the steps of a run, as data; add_step_notes() turns them into
// notes.
#pragma once

#include <string>
#include <vector>

#include "formulations/time_stepping/film_step.hpp"
#include "formulations/time_stepping/step_resolution.hpp"

namespace freeplay {

struct StepDiagnostics {
  std::string motions;  ///< the first contact problem with more than one motion
  std::string jam;      ///< the first contact stopped by friction without approach (Painlevé)
  long jams = 0;        ///< number of such contacts
  long undecided = 0;   ///< contact problems whose uniqueness was not decided
  long inelastic = 0;   ///< steps whose impacts were solved without restitution
  long unsettled = 0;   ///< fixed steps in which the iteration of films did not converge
  long unswept = 0;     ///< steps in which the iteration over a swept table did not converge
  /// problems in which joint friction grows faster than the reactions that bound it
  long locked = 0;
  double locked_since = 0;  ///< s, of the first such problem
};

/// `fixed`: steps of fixed length.
void add_step_notes(const StepDiagnostics& found, const System& system, bool fixed,
                    const FilmStep::Leap& leap, const StepResolution::Bend& bend,
                    std::vector<std::string>& notes);

/// The key whose smaller value shortens the steps.
inline const char* finer_key(bool fixed) { return fixed ? "nonsmooth.step" : "nonsmooth.step_tolerance"; }

}  // namespace freeplay

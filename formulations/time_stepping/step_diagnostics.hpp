// What a reader of the results must know of the steps of a run, as data; worded once, in tell_steps().
#pragma once

#include <string>
#include <vector>

#include "formulations/time_stepping/film_step.hpp"
#include "formulations/time_stepping/step_resolution.hpp"

namespace freeplay {

struct StepDiagnostics {
  std::string motions;      ///< the first contact problem with more motions than one
  std::string jam;          ///< the first contact that friction stopped without approach (Painlevé)
  long jams = 0;            ///< such contacts
  long undecided = 0;       ///< contact problems whose uniqueness was not decided
  long inelastic = 0;       ///< steps whose impacts were taken without restitution
  long unsettled = 0;       ///< fixed steps whose films were not met
  long unswept = 0;         ///< steps over a table whose sweep did not settle
  long locked = 0;          ///< problems in which friction in joints outgrows the reactions that bound it
  double locked_since = 0;  ///< s, the first of them
};

/// `fixed`: steps have a given length.
void tell_steps(const StepDiagnostics& found, const System& system, bool fixed, const FilmStep::Leap& leap,
                const StepResolution::Bend& bend, std::vector<std::string>& notes);

/// The key whose smaller value shortens the steps.
inline const char* finer_key(bool fixed) { return fixed ? "nonsmooth.step" : "nonsmooth.step_tolerance"; }

}  // namespace freeplay

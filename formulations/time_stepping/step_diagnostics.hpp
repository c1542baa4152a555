// StepDiagnostics: diagnostics of the steps of a run, as data; add_step_notes() turns them into
// notes.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/time_stepping/film_step.hpp"

namespace freeplay {

// StepResolution: checks whether fixed steps are short enough for the geometry and the curves of a
// scene: whether a body can move past a contact, such as a pin, within one step, and whether a
// curve bends within one step. Adaptive steps have limits for both (integrators/curve_limit.hpp,
// crossing.hpp).

class ContactSet;
struct StepData;

class StepResolution {
 public:
  /// The greatest motion in one step relative to the width that a contact could pass through, and
  /// the contact.
  struct Passage {
    double share = 0;
    int contact = -1;
    template <class M>
    void serialize(M& m) {
      m(share, contact);
    }
  };
  /// The greatest deviation of a curve from a straight line within one step, relative to the
  /// curve's greatest value (share) and to the accepted deviation (over), and the element that
  /// reads it.
  struct CurveDeviation {
    double share = 0, over = 0;
    int reader = -1;
    template <class M>
    void serialize(M& m) {
      m(share, over, reader);
    }
  };

  explicit StepResolution(const System& system);
  void assess(const StepData& step, const ContactSet& contacts) {
    if (passes_) assess_passage(step, contacts);
    if (!greatest_.empty()) assess_curves(step);
  }

  /// Whether there is nothing to assess.
  bool idle() const { return !passes_ && greatest_.empty(); }

  Passage passage;
  CurveDeviation curve_deviation;

 private:
  void assess_passage(const StepData& step, const ContactSet& contacts);
  void assess_curves(const StepData& step);

  std::vector<double> greatest_;  // greatest |y| of each curve
  std::vector<int> passing_;      // contacts that a body may pass through
  bool passes_;                   // there are such contacts, or pairs among many bodies
};

struct StepDiagnostics {
  std::string motions;  ///< the first contact problem with more than one motion
  std::string lockup;   ///< the first contact stopped by friction without approach (Painlevé)
  long lockups = 0;     ///< number of such contacts
  long undecided = 0;   ///< contact problems whose uniqueness was not decided
  long inelastic = 0;   ///< steps whose impacts were solved without restitution
  long unsettled = 0;   ///< fixed steps in which the iteration of films did not converge
  long unswept = 0;     ///< steps in which the iteration over a swept table did not converge
  /// problems in which joint friction grows faster than the reactions that bound it
  long locked = 0;
  double locked_since = 0;  ///< s, of the first such problem
  long uncorrected = 0;     ///< steps whose position correction did not meet its tolerance
  double residual = 0;      ///< m, the greatest distance of their gaps from the solution
};

/// `fixed`: steps of fixed length.
void add_step_notes(const StepDiagnostics& found, const System& system, bool fixed,
                    const FilmStep::ThicknessChange& thickness_change,
                    const StepResolution::CurveDeviation& curve_deviation, std::vector<std::string>& notes);

/// The key whose smaller value shortens the steps.
inline const char* finer_key(bool fixed) { return fixed ? "nonsmooth.step" : "nonsmooth.step_tolerance"; }

}  // namespace freeplay

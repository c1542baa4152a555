// OnsetSearch: finds the first contact onset on the path of a pair of steps, and the first kink of
// a spring. The gaps of open contacts are searched on Hermite cubics with the rigorous bounds of
// integrators/crossing.hpp, from bounds of speed and acceleration within each half.
#pragma once

#include <optional>
#include <vector>

#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/kinks.hpp"
#include "formulations/time_stepping/step_pair.hpp"

namespace freeplay {

class OnsetSearch {
 public:
  struct Onset {
    int contact = -1;
    double t = 0, rate = 0;  // s, m/s
  };

  OnsetSearch(const System& system, double tolerance, double length);

  std::optional<Onset> first_onset(const MoreauStepper& moreau, const StepPair& pair);
  /// The first time in the step at which a spring's length or angle passes from its present linear
  /// piece to another. If the step begins within the tolerance of a kink, the present piece is the
  /// one that the motion enters.
  std::optional<double> first_kink(const MoreauStepper& moreau, const StepPair& pair);

  /// The first time in the step at which the demand of a controller reaches its limit.
  std::optional<double> first_limit(const MoreauStepper& moreau, const StepPair& pair);

  /// A gap up to this value (m) counts as at its onset.
  double near(int contact, const double* q) const;

  /// @name Of the last first_onset()
  ///@{
  /// a bound of the gaps' curvature within the pair is known
  bool bounded() const { return bounded_; }
  /// possible undetected depth of a contact, over the clearance
  double unseen() const { return unseen_; }
  ///@}

 private:
  /// Half of a pair.
  struct Half {
    double a, b;  // s
    const double *qa, *va, *qb, *vb;
  };
  std::optional<Onset> onset_in(int k, const Half& half, const MoreauStepper& moreau, const StepPair& pair);
  std::optional<double> kink_in(const Half& half, const MoreauStepper& moreau, const StepPair& pair);
  void enclose(const Half& half);

  const System& system_;
  double tolerance_, length_;
  Evaluation e_;
  std::vector<double> q_, v_, x_;
  Limits limits_;
  MotionBounds bounds_;
  bool bounded_ = true;
  double unseen_ = 0;
};

}  // namespace freeplay

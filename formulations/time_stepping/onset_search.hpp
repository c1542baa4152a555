// The first contact onset on the path of a pair of steps, and the first kink of a spring: the gaps of what is open are searched on
// Hermite's cubics with the proof of integrators/crossing.hpp, from bounds of speed and acceleration within each half.
#pragma once

#include <optional>
#include <vector>

#include "formulations/integrators/crossing.hpp"
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
  /// The first time in the step at which a spring's length or angle leaves the piece that it began on. Where it began within
  /// the tolerance of a kink, that is the piece that it goes to.
  std::optional<double> first_kink(const MoreauStepper& moreau, const StepPair& pair);

  /// A gap not greater than this (m) is at its onset.
  double near(int contact, const double* q) const;

  /// @name Of the last first_onset()
  ///@{
  bool bounded() const { return bounded_; }  ///< how gaps may bend within the pair is known
  double unseen() const {
    return unseen_;
  }  ///< over the clearance: how deep a contact may have been
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
  std::vector<double> q_, v_;
  MotionBounds bounds_;
  bool bounded_ = true;
  double unseen_ = 0;
};

}  // namespace freeplay

// Limits of the step length, so that no step passes over the peak of a friction that falls with the sliding speed
// (mechanism/static_friction.hpp). Its width is the Stribeck speed v_S: where sliding stops in less time than a step,
// the stages of the step may all lie outside of it, and friction that would hold seems too weak.
//
// With the sliding speed u at the beginning of a step and the speed U beyond which less than 1e-12 of the peak is left,
// the sliding speed changes in the step by at most
//
//     |u| − U + w     towards rest from |u| > U,        w     from |u| ≤ U,        w = v_S/(2 max(2, n))
//
// n is the exponent: with a large one the peak has steep flanks. Within the peak the error control of the method
// chooses the steps. A step is checked at its end, as in curve_limit.hpp, and repeated if it exceeds this by w/2.
#pragma once

#include <vector>

#include "dynamics/system.hpp"

namespace freeplay {

class PeakLimit {
 public:
  explicit PeakLimit(const System& system);
  /// Checks a step from (t0, q0, v0) to (t1, q1, v1): 0 if it is short enough, or the factor, above 1, by which a
  /// step that does not go too far is shorter.
  double overreach(double t0, const double* q0, const double* v0, double t1, const double* q1,
                   const double* v1) {
    return peaks_.empty() ? 0 : find(t0, q0, v0, t1, q1, v1);
  }

 private:
  struct Peak {
    bool of_contact;
    int index;          // of the contact or of the joint friction
    double far, fine;   // m/s, U and w
    double before = 0;  // m/s, u; NaN: open
  };
  void add(bool of_contact, int index, const StribeckCurve& curve);
  double sliding(const Peak& peak, const double* q, const double* v);
  double find(double t0, const double* q0, const double* v0, double t1, const double* q1, const double* v1);

  const System& system_;
  std::vector<Peak> peaks_;
  Evaluation evaluation_;
  ContactRow contact_;
  SparseRow slide_;
};

}  // namespace freeplay

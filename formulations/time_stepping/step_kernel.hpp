// StepKernel: calls the compiled functions of a step (dynamics/system_functions.hpp). They take the
// place of the general path for fixed steps of mechanisms that have them, and give its digits. Each
// call returns false if there are none, or if a comparison has another result than at the sample;
// the general path then does that part of the step.
#pragma once

#include <vector>

namespace freeplay {

class ContactSet;
struct ContactUnknown;
struct StepData;

class StepKernel {
 public:
  /// Evaluates the middle of the step, factorises there, and computes v and λ without contacts.
  bool middle(StepData& step, ContactSet& contacts);
  /// Responses and reactions to both rows of a contact, and its entries of D.
  struct Response {
    const double *normal, *tangent;  ///< entries of the rows
    double *a_n, *lambda_n, *a_t, *lambda_t;
  };
  /// D_NN, D_TN, D_TT; null: the general path.
  const double* respond(const StepData& step, int contact, const Response& at);
  /// Computes q, corrected onto Φ = 0, all multipliers, gaps and works, from v with all impulses. q
  /// before the correction is in step.dq.
  bool end(StepData& step, ContactSet& contacts);
  /// Evaluates the constraints and gaps at another q.
  bool reached(StepData& step, ContactSet& contacts);

 private:
  std::vector<double*> out_;  // work space
  double D_[3] = {};
};

}  // namespace freeplay

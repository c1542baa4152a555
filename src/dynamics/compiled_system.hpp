// CompiledSystem: the compiled functions of a System (dynamics/system_functions.hpp), which are faster and
// bitwise identical. Each call returns false if there is no function, or if it does not cover the state.
#pragma once

#include <memory>

#include "dynamics/evaluation.hpp"
#include "dynamics/kinematics.hpp"

namespace freeplay {

struct SystemFunctions;
struct SolveFunctions;

class CompiledSystem {
 public:
  CompiledSystem();
  /// Uses them from now on; no function of the System may be running. Empty ones: none.
  void attach(SystemFunctions functions);
  /// Those of the saddle point, at an address that stays. They are empty until attach().
  const SolveFunctions* solve() const;
  SystemFunctions& functions() const { return *functions_; }
  /// Calls of compiled functions that the templates answered.
  long refused() const;

  bool any() const { return any_; }
  bool any_contacts() const { return contacts_; }
  bool place(double t, const double* q, Evaluation& e) const;
  bool rate(const double* q, const double* v, Evaluation& e) const;
  /// `states`: number of first-order states in z.
  bool forces(double t, const double* q, const double* v, const double* z, int states, Evaluation& e,
              const Reading& reading) const;
  bool contact(int k, const double* q, const double* v, const Evaluation& e, ContactRow& row) const;

 private:
  std::shared_ptr<SystemFunctions> functions_;
  bool any_ = false, contacts_ = false;
};

}  // namespace freeplay

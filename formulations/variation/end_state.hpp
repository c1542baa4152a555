// The state at the end of a run with its derivatives (run_end_state()), and the least forces of the
// contacts that stay closed (LeastForces).
#pragma once

#include <functional>
#include <vector>

#include "formulations/variation/sensitivity.hpp"

namespace freeplay {

/// The state at the end of a run, with derivatives.
struct EndState {
  /// A contact that was closed during the whole run, and its normal force.
  struct Lasting {
    int contact = 0;
    double least = INFINITY, greatest = 0;  ///< N
    double t = NAN;                         ///< s, of the least one
  };
  State state;
  /// d(q, v, z)/dp, one list for each key; of penalty runs also that of (v₀, mass) of each contact
  std::vector<std::vector<double>> columns;
  std::vector<double> scales;         ///< of the same, as the tolerance of the scheme has them
  std::vector<VariedOnset> onsets;    ///< of contacts, in the order of time
  std::vector<Lasting> lasting;       ///< in the order of contacts; not of time stepping
  std::vector<PenaltyMode> contacts;  ///< of all contacts; of penalty runs only
  /// Of each contact of a penalty run: whether it began or had an impact, which renews v₀ and the mass, and
  /// whether its force depends on them.
  std::vector<char> renewed, retains;
  double fastest = 0;    ///< greatest rate of a coordinate
  bool stepped = false;  ///< whether time stepping made a step
  std::string stopped;   ///< reason of a stop before the end; empty if there is none
  std::string refused;   ///< reason why a derivative does not exist; empty if all do
};
/// Runs as run_sensitivities() does, by the scheme of the scene, for the state at the end of the run; the
/// quantities are not evaluated.
EndState run_end_state(const SensitivityRun& run, Family family);

/// LeastForces: least and greatest normal forces F_N(t) of the contacts that stay closed during a run. Each
/// step is sampled; a minimum between the samples is located by Brent's method. A lasting contact is lost
/// where the least force reaches zero (lift-off).
///
/// Use: construct; call add_step() after each step; then lasting().
class LeastForces {
 public:
  explicit LeastForces(int contacts) : contacts_(contacts) {}

  /// Takes a step from t0 of length h (s). `closed`: whether a contact is closed at its end; `force`: normal
  /// force (N) of a contact at a time of the step.
  void add_step(double t0, double h, const std::function<bool(int contact)>& closed,
                const std::function<double(int contact, double t)>& force);
  /// Contacts that were closed in all steps; none before the first one.
  const std::vector<EndState::Lasting>& lasting() const { return list_; }

 private:
  int contacts_;
  bool begun_ = false;
  std::vector<EndState::Lasting> list_;
};

}  // namespace freeplay

// MotionKernel: calls of the compiled functions of right-hand sides (system_functions.hpp), which
// evaluate everything that depends on a state alone in one call. Results are bitwise identical to those of
// place(), rate() and forces() of the System and of the SaddlePoint's factor() and solve().
//
// Usage:
//
//     if (!kernel.motion(system, saddle, e, {t, q, v, z}, a, lambda, drive)) general evaluation;
//     if (one contact is closed and slides) kernel.slide(...);
//
// It owns the addresses of the arguments. `e` and `saddle` are those of its owner.
#pragma once

#include <array>

#include "dynamics/evaluation.hpp"
#include "dynamics/system.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class MotionKernel {
 public:
  struct At {
    double t;  ///< s
    const double *q, *v, *z;
  };
  /// Evaluates e and factorises; `a`, `lambda` and `drive` as of `motion`. Returns false if there is no
  /// such function, or if a guard of it failed: e and the factors are then undefined.
  bool motion(const System& system, SaddlePoint& saddle, Evaluation& e, const At& at, double* a,
              double* lambda, double& drive);
  /// The same for `state`; `terms`: 2α and β².
  bool state(const System& system, SaddlePoint& saddle, Evaluation& e, const At& at, const double* terms,
             double* rate, double* r);
  struct Slide {
    double mobility, force, drive, sliding;
  };
  /// Adds the force of contact k, which alone is closed, at the state of the last motion(). `factor`:
  /// −s μ. Returns false with all arguments but `row` and `found` unchanged.
  bool slide(const System& system, int k, const At& at, double factor, ContactRow& row, double* a,
             double* lambda, Slide& found);

 private:
  bool prepare(const System& system, SaddlePoint& saddle, Evaluation& e);
  bool call(CompiledFunction function, const System& system, SaddlePoint& saddle, Evaluation& e,
            const double* const* in, double* first, double* second, double* drive);

  const SaddlePoint* saddle_ = nullptr;
  const Evaluation* e_ = nullptr;
  const void* object_ = nullptr;  // of the functions
  bool usable_ = false;
  std::vector<double> least_;  // pivot ratio of each block
  std::array<double*, 16> out_{};
};

/// Number of quantities in which the functions differ from the templates near a state, as
/// differing_quantities().
long differing_motions(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                       int states);

}  // namespace freeplay

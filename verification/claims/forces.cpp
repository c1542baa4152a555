// Forces of a run: they satisfy the Newton–Euler equations, agree with closed forms, and their time
// integrals are the impulses and the work.
#include "dynamics/assembly/assembly.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/force_claims.hpp"

namespace freeplay::verification {

Findings forces() {
  using namespace force_claims;
  Findings f;
  const auto start = assemble(everything().mechanism, RunOptions::Start::assembled);
  balance(f, start);
  tolerances(f, start);
  csv(f, start);
  slider_cranks(f);
  bearings(f);
  load_cell(f);
  torque_sensor(f);
  watching(f, start);
  redundant(f, start);
  return f;
}

}  // namespace freeplay::verification

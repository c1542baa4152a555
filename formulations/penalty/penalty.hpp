// Factory of the penalty formulation (dynamics.hpp, stepper.hpp): contact forces as functions of
// penetration and velocity, with an integrator of the scene's choice.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/assembly/compliance.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

struct ContactFacts;
struct Scene;
class System;

/// PenaltySteps: a penalty run step by step, with the data that its variational equations need
/// (penalty_variation.hpp), whatever its integrator.
class PenaltySteps {
 public:
  virtual ~PenaltySteps() = default;
  /// Makes a step, not beyond `end` (s); false if there is none.
  virtual bool step(double end) = 0;
  virtual std::string failure() const = 0;
  virtual double t_old() const = 0;
  virtual double t() const = 0;
  /// The integrated vectors at the beginning and the end of the last step.
  virtual const std::vector<double>& x_old() const = 0;
  virtual const std::vector<double>& x() const = 0;
  virtual const PenaltyDynamics& dynamics() const = 0;
  /// q and v at a time of the last step.
  virtual void interpolate(double t, double* q, double* v) const = 0;
  /// See PenaltyStepper.
  virtual void resume(const std::vector<PenaltyMode>& modes) = 0;
};

/// What a penalty run with derivatives is made of.
struct PenaltyParts {
  std::unique_ptr<PenaltySteps> steps;
  ErrorNorm norm;          ///< of its steps
  double v0_floor = 0;     ///< m/s
  double speed_scale = 0;  ///< m/s
  bool resumed = false;    ///< whether contacts that are closed at the start continue an earlier run
};

/// As make_penalty(). With `modes`, one for each contact, it continues a run that ended with them.
PenaltyParts make_penalty_parts(const Scene& scene, const System& system, const State& state,
                                const std::vector<PenaltyMode>& modes = {});

/// Dynamics of a displaced scene of the same structure as `nominal`.
std::unique_ptr<PenaltyDynamics> displaced_penalty(const PenaltyDynamics& nominal, const Scene& scene,
                                                   const System& system, const State& state);

/// Makes the penalty formulation of a scene, started at `state`. Throws ModelError if a surface
/// lacks data for its contact force.
std::unique_ptr<Formulation> make_penalty(const Scene& scene, const System& system, const State& state);

/// The coefficient of restitution that the scene's contact law delivers at a contact in a free
/// impact; not for Kelvin–Voigt, where it depends on the mass.
double delivered_by(const Scene& scene, const ContactFacts& contact);

/// The elastic parts of the contact laws of all contacts.
Compliances penalty_compliances(const Scene& scene, const System& system);

}  // namespace freeplay

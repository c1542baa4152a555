// Factory of the penalty formulation (dynamics.hpp, stepper.hpp): contact forces as functions of
// penetration and velocity, with an integrator of the scene's choice.
#pragma once

#include <memory>

#include "dynamics/assembly/compliance.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

struct ContactFacts;
struct Scene;
class System;

/// Makes the penalty formulation of a scene, started at `state`. Throws ModelError if a surface
/// lacks data for its contact force.
std::unique_ptr<Formulation> make_penalty(const Scene& scene, const System& system, const State& state);

/// The coefficient of restitution that the scene's contact law delivers at a contact in a free
/// impact; not for Kelvin–Voigt, where it depends on the mass.
double delivered_by(const Scene& scene, const ContactFacts& contact);

/// The elastic parts of the contact laws of all contacts.
Compliances penalty_compliances(const Scene& scene, const System& system);

}  // namespace freeplay

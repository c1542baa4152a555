#include "formulations/make.hpp"

#include <stdexcept>

#include "formulations/nonsmooth/nonsmooth.hpp"
#include "formulations/penalty/penalty.hpp"

namespace freeplay {

std::unique_ptr<Formulation> make(Family family, const Scene& scene, const System& system, const State& state,
                                  const std::vector<double>& restitution) {
  switch (family) {
    case Family::penalty:
      return make_penalty(scene, system, state);
    case Family::nonsmooth:
      return make_nonsmooth(scene, system, state, restitution);
  }
  throw std::logic_error("no such family of formulations");
}

std::vector<double> delivered_restitutions(const Scene& scene, const System& system) {
  std::vector<double> e;
  if (scene.penalty.contact == ContactLaw::kelvin_voigt)
    throw ModelError("penalty.contact",
                     "\"kelvin-voigt\" delivers a restitution that depends on the mass, so it cannot be "
                     "matched; compare with --as-given");
  for (int k = 0; k < system.contacts(); ++k) e.push_back(delivered_by(scene, system.contact_facts(k)));
  return e;
}

}  // namespace freeplay

#include "formulations/make.hpp"

#include <fmt/format.h>
#include <stdexcept>

#include "formulations/nonsmooth/nonsmooth.hpp"
#include "formulations/penalty/penalty.hpp"
#include "model/laws.hpp"
#include "model/scene.hpp"
#include "model/system.hpp"

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

Compliances compliances(Family family, const Scene& scene, const System& system) {
  return family == Family::penalty ? penalty_compliances(scene, system) : Compliances{};
}

std::vector<double> delivered_restitutions(const Scene& scene, const System& system) {
  std::vector<double> e;
  const auto& law = facts_of(scene.penalty.contact);
  if (law.kind == ContactKind::spring_damper)
    throw ModelError("penalty.contact",
                     fmt::format("\"{}\" delivers a restitution that depends on the mass, so it cannot be "
                                 "matched; compare with --as-given",
                                 law.text));
  e.reserve(static_cast<std::size_t>(system.contacts()));
  for (int k = 0; k < system.contacts(); ++k) e.push_back(delivered_by(scene, system.contact_facts(k)));
  return e;
}

}  // namespace freeplay

#include "formulations/make.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dynamics/system.hpp"
#include "formulations/nonsmooth.hpp"
#include "formulations/penalty/penalty.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

namespace {

/// Only time stepping with a fixed step supports contact pairs that are created and removed during
/// a run.
void refuse_families(Family family, const Scene& scene, const System& system) {
  if (system.families().empty()) return;
  const auto& name = system.families().front().name;
  const auto group = std::ranges::find_if(scene.mechanism.groups, [&](const Group& g) {
    return std::ranges::any_of(families_of(scene.mechanism, g, 0),
                               [&](const auto& f) { return f.name == name; });
  });
  const auto& o = scene.nonsmooth;
  const auto& own = group->name;
  if (family == Family::nonsmooth && o.scheme_in_force() == Scheme::moreau_jean && o.step) return;
  throw ModelError(
      fmt::format("groups.{}.pairs", own),
      fmt::format(
          "\"near\" needs the nonsmooth formulation with nonsmooth.scheme = \"moreau-jean\" and a fixed "
          "nonsmooth.step; use \"each\" to make every pair a contact{}",
          group->pairs ? "" : fmt::format(" (the default is \"near\" above {} pairs)", Group::most_listed)));
}

}  // namespace

std::unique_ptr<Formulation> make(Family family, const Scene& scene, const System& system, const State& state,
                                  const std::vector<double>& restitution) {
  refuse_families(family, scene, system);
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
                     fmt::format("the effective restitution of \"{}\" depends on the mass, so it cannot be "
                                 "matched; compare with --as-given",
                                 law.text));
  e.reserve(static_cast<std::size_t>(system.contacts()));
  for (int k = 0; k < system.contacts(); ++k) e.push_back(delivered_by(scene, system.contact_facts(k)));
  return e;
}

}  // namespace freeplay

// Identity of a run (values/identity.hpp): everything that determines its bits, as text. These
// functions compute it from a scene, before or without a run. They keep no state.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "values/family.hpp"
#include "values/identity.hpp"

namespace freeplay {

struct Scene;
class System;

/// Family of a formulation's name, "penalty" or "nonsmooth". Throws ModelError for any other name.
Family family_of(std::string_view formulation);

/// Coefficients of restitution that the penalty law of the scene delivers, one for each contact.
/// nullopt if `asked` is false or the family has no impact law: contacts then take the values of
/// their surfaces.
std::optional<std::vector<double>> matched_restitution(Family family, bool requested, const Scene& scene,
                                                       const System& system);

/// Identity of a run of this scene without a start given by the caller.
Identity identify(const Scene& scene, Family family, const std::optional<std::vector<double>>& restitution);
/// As above, for a scene that has not been validated. Throws ModelError for an unknown formulation,
/// an invalid mechanism, or a restitution that cannot be matched.
Identity identify(const Scene& scene, std::string_view formulation, bool matched);

}  // namespace freeplay

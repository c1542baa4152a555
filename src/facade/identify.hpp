// The identity of a run that is not made yet, or of one that stands there.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "values/family.hpp"
#include "values/identity.hpp"

namespace freeplay {

struct Scene;
class System;

/// "penalty" or "nonsmooth"; throws ModelError.
Family family_of(std::string_view formulation);

/// What the contacts of an impact law take from the penalty law; nullopt where they take their surfaces' values.
std::optional<std::vector<double>> matched_restitution(Family family, bool asked, const Scene& scene,
                                                       const System& system);

/// Nothing given beside the scene.
Identity identify(const Scene& scene, Family family, const std::optional<std::vector<double>>& restitution);
/// The same of a scene that may still be refused. Throws ModelError for a restitution that cannot be matched.
Identity identify(const Scene& scene, std::string_view formulation, bool matched);

}  // namespace freeplay

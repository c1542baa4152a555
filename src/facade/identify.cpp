#include "facade/identify.hpp"

#include <fmt/format.h>

#include "dynamics/system.hpp"
#include "formulations/make.hpp"
#include "io/files/identity.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

Family family_of(std::string_view formulation) {
  if (const auto family = family_named(formulation)) return *family;
  throw ModelError("formulation", fmt::format("must be \"{}\", is \"{}\"",
                                              fmt::join(family_names(), "\" or \""), formulation));
}

std::optional<std::vector<double>> matched_restitution(Family family, bool requested, const Scene& scene,
                                                       const System& system) {
  if (!requested || family != Family::nonsmooth) return std::nullopt;
  return delivered_restitutions(scene, system);
}

Identity identify(const Scene& scene, Family family, const std::optional<std::vector<double>>& restitution) {
  auto outside = outside_of(scene);
  if (family != Family::penalty) outside.law.reset();  // an impact law has no normal force
  return {.scene = to_toml(scene),
          .formulation = formulation_identity(name_of(family), restitution.has_value(),
                                              restitution.value_or(std::vector<double>{})) +
                         outside_identity(outside),
          .given = "",
          .program = program_identity()};
}

Identity identify(const Scene& scene, std::string_view formulation, bool matched) {
  const auto family = family_of(formulation);
  const System system(scene.mechanism);
  return identify(scene, family, matched_restitution(family, matched, scene, system));
}

}  // namespace freeplay

#include "mechanism/outside.hpp"

#include <fmt/format.h>

#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

std::string loads_of(const Mechanism& mechanism) {
  std::string list;
  for (const auto& load : mechanism.loads)
    if (const auto* force = std::get_if<ForceLoad>(&load)) list += (list.empty() ? "" : ", ") + force->name;
  return list.empty() ? "the scene has none" : "such loads are " + list;
}

}  // namespace

void put(Scene& scene, const Outside& outside) {
  auto mechanism = scene.mechanism;
  std::size_t met = 0;
  for (auto& load : mechanism.loads)
    if (auto* force = std::get_if<ForceLoad>(&load)) {
      const auto found = outside.forces.find(force->name);
      force->own = found == outside.forces.end() ? nullptr : found->second;
      met += force->own ? 1 : 0;
    }
  if (met != outside.forces.size())
    for (const auto& [name, force] : outside.forces) {
      const auto named = [&name = name](const Load& load) {
        return std::holds_alternative<ForceLoad>(load) && name_of(load) == name;
      };
      if (std::ranges::none_of(mechanism.loads, named))
        throw SceneError(
            fmt::format("the external force {} needs a load of type \"force\", and {} is not one; {}",
                        force->name, name, loads_of(mechanism)));
    }
  scene.mechanism = std::move(mechanism);
  scene.penalty.own = outside.law;
}

Outside outside_of(const Scene& scene) {
  Outside outside{.law = scene.penalty.own};
  for (const auto& load : scene.mechanism.loads)
    if (const auto* force = std::get_if<ForceLoad>(&load); force && force->own)
      outside.forces[force->name] = force->own;
  return outside;
}

}  // namespace freeplay

// What a scene in memory has from outside the program, besides its text: code of the caller's own.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "mechanism/own_force.hpp"
#include "mechanism/own_law.hpp"

namespace freeplay {

struct Scene;

struct Outside {
  std::shared_ptr<const OwnLaw> law = {};  ///< of contacts, penalty; null: penalty.contact
  std::map<std::string, std::shared_ptr<const OwnForce>> forces = {};  ///< by the load that each stands in

  bool empty() const { return !law && forces.empty(); }
};

/// Puts it into a scene, which keeps nothing that it had from outside before. Throws SceneError, then nothing is changed, where a force
/// stands in for what is no load of type "force".
void put(Scene& scene, const Outside& outside);

/// What a scene has.
Outside outside_of(const Scene& scene);

}  // namespace freeplay

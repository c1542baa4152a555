// Code of the caller that a scene in memory uses besides its text: a contact law and applied
// forces.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "mechanism/own_force.hpp"
#include "mechanism/own_law.hpp"

namespace freeplay {

struct Scene;

/// A contact law and load forces that the caller implements.
struct Outside {
  std::shared_ptr<const OwnLaw> law = {};  ///< penalty contact law; null: penalty.contact
  /// Applied forces, by the name of the load that each replaces.
  std::map<std::string, std::shared_ptr<const OwnForce>> forces = {};

  /// Whether there is neither.
  bool empty() const { return !law && forces.empty(); }
};

/// Sets the outside code of a scene and removes any that it had before. Throws SceneError, with the
/// scene unchanged, if a force names no load of type "force".
void put(Scene& scene, const Outside& outside);

/// The outside code that a scene uses.
Outside outside_of(const Scene& scene);

}  // namespace freeplay

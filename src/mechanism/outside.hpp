// Code of the caller that a scene in memory uses besides its text: a contact law and applied
// forces.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "numerics/traced.hpp"
#include "values/vec2.hpp"

namespace freeplay {

// A normal contact force from code outside the program: from a compiled plugin or from a function
// of the caller. It replaces penalty.contact. A scene file cannot name it: the caller adds it to
// the scene (put()), and the provenance of the results records it.

/// A law of the normal force that the caller implements.
struct OwnLaw {
  /// Force (N) of the contact of this name at penetration δ > 0 (m), penetration rate δ̇ (m/s) and
  /// onset speed v₀ > 0 (m/s; defined in contact_law.hpp). Negative values count as 0. F(δ, 0, 1)
  /// is the elastic part: it must depend on δ alone, be 0 at 0 and increase with δ. Called from one
  /// thread at a time. An exception that it throws ends the run.
  double (*force)(const void* context, const char* contact, double delta, double rate, double v0) = nullptr;
  /// passed to the function; kept as long as the law
  std::shared_ptr<const void> context = {};
  std::string name;  ///< for messages, on one line: "hunt-crossley.so"
  /// Digest of its source (io/files/digest.hpp), part of the identity of a run.
  std::string digest;
};

// An applied force from code outside the program: from a compiled plugin or from a function of the
// caller. It replaces the force of a load of type "force". A scene file cannot name it: the caller
// adds it to the scene (put()), and the provenance of the results records it.

/// A load force that the caller implements.
struct OwnForce {
  /// Force (N) along the load's `axes`, on the load of this name at time t (s). `place` (m) and
  /// `velocity` (m/s) are those of the loaded point in the world. Called from one thread at a time.
  /// An exception that it throws ends the run.
  Vec2 (*force)(const void* context, const char* load, double t, const Vec2& place,
                const Vec2& velocity) = nullptr;
  /// passed to the function; kept as long as the force
  std::shared_ptr<const void> context = {};
  std::string name;  ///< for messages, on one line: "gas.so"
  /// Digest of its source (io/files/digest.hpp), part of the identity of a run.
  std::string digest;

  /// Calls the function: N, along the load's axes.
  Vec2 at(const std::string& load, double t, const Vec2& place, const Vec2& velocity) const {
    return force(context.get(), load.c_str(), t, place, velocity);
  }
  /// The force in a trace, with its derivatives by central differences. Steps of ∛ε relative to the size of
  /// the argument give errors of the order ∛ε².
  Vec2Of<Traced> at(const std::string& load, const Traced& t, const Vec2Of<Traced>& place,
                    const Vec2Of<Traced>& velocity) const;
};

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

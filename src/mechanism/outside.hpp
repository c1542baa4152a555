// Code of the caller that a scene in memory uses besides its text: a contact law and applied
// forces.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "numerics/dual.hpp"
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
  /// A function outside the program cannot be traced.
  Vec2Of<Traced> at(const std::string&, const Traced&, const Vec2Of<Traced>&, const Vec2Of<Traced>&) const {
    throw NotTraceable("a load force is a function outside the program");
  }
  /// The force with its derivatives by central differences. Steps of ∛ε relative to the size of the
  /// argument give errors of the order ∛ε².
  template <int N>
  Vec2Of<Dual<N>> at(const std::string& load, const Dual<N>& t, const Vec2Of<Dual<N>>& place,
                     const Vec2Of<Dual<N>>& velocity) const {
    std::array<double, 5> x{t.value, place.x().value, place.y().value, velocity.x().value,
                            velocity.y().value};
    const std::array<const Dual<N>*, 5> of{&t, &place.x(), &place.y(), &velocity.x(), &velocity.y()};
    const auto value = [&] { return at(load, x[0], {x[1], x[2]}, {x[3], x[4]}); };
    const Vec2 f = value();
    Vec2Of<Dual<N>> r{Dual<N>(f.x()), Dual<N>(f.y())};
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (of[i]->slope == std::array<double, N>{}) continue;
      const double here = x[i], h = 6e-6 * std::fmax(std::abs(here), 1e-3);
      x[i] = here + h;
      const Vec2 above = value();
      x[i] = here - h;
      const Vec2 rise = above - value();
      x[i] = here;
      for (int n = 0; n < N; ++n) {
        r.x().slope[n] += rise.x() / (2 * h) * of[i]->slope[n];
        r.y().slope[n] += rise.y() / (2 * h) * of[i]->slope[n];
      }
    }
    return r;
  }
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

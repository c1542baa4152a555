// A normal force of contacts from outside the program: of a compiled plugin, or of a function of the caller's. It stands in place of
// penalty.contact. No scene names one: whoever gives the scene to the program adds it, and the provenance tells of it.
#pragma once

#include <memory>
#include <string>

namespace freeplay {

struct OwnLaw {
  /// N, at the penetration δ > 0 (m), its rate δ̇ (m/s) and the touch speed v₀ > 0 (m/s; contact_law.hpp says which) of the contact
  /// of this name. Less than 0 counts as 0. F(δ, 0, 1) is what it stores: it must be of δ alone, 0 at 0 and grow with it. Called
  /// from one thread at a time. What it throws leaves the run.
  double (*force)(const void* context, const char* contact, double delta, double rate, double v0) = nullptr;
  std::shared_ptr<const void> context = {};
  std::string name;    ///< for people, on one line: "hunt-crossley.so"
  std::string digest;  ///< of what it was made from (io/files/digest.hpp), in the identity of a run
};

}  // namespace freeplay

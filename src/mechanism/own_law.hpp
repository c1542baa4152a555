// A normal contact force from code outside the program: from a compiled plugin or from a function
// of the caller. It replaces penalty.contact. A scene file cannot name it: the caller adds it to
// the scene (outside.hpp), and the provenance of the results records it.
#pragma once

#include <memory>
#include <string>

namespace freeplay {

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

}  // namespace freeplay

// Impulses of an ordinary step in a lane (lane_functions.hpp), recorded with Traced numbers: of a contact,
// of a joint friction, or of both, with what the step requires of them.
// formulations/contact/single_contact.hpp has the laws.
#pragma once

#include <array>
#include <vector>

#include "formulations/contact/single_contact.hpp"
#include "numerics/traced.hpp"

namespace freeplay {

/// x − x: NaN for an infinite or undefined x.
inline Traced zero_if_finite(const Traced& x) {
  const Traced& same = x;
  return x - same;
}

/// The impulses of an ordinary step, and what the step requires of them.
struct LaneImpulses {
  Traced normal, tangent, slide;  // N s; of the contact, and of the joint friction
  Traced residual, residual_rate;
  std::vector<Traced> conditions;

  void need(const Traced& condition) { conditions.push_back(condition); }
  /// Residuals of the laws, which must be finite and small beside the rates without impulses and the targets.
  void take_residuals(const std::vector<Traced>& impulses, const std::vector<Traced>& residuals,
                      const std::vector<Traced>& rates, const Traced& tolerance) {
    Traced unfinished, size;
    for (const auto& P : impulses) unfinished += zero_if_finite(P);
    for (const auto& x : residuals) {
      residual_rate = max(residual_rate, abs(x));
      unfinished += zero_if_finite(x);
    }
    for (const auto& rate : rates) size = max(size, abs(rate));
    need(is_equal(unfinished, 0));
    need(both(is_below(0, size), is_at_most(residual_rate, tolerance * size)));
    residual = residual_rate / size;
  }
};

/// A contact that is pressed, as ContactProblem::alone(). `rubs`: whether it has friction.
LaneImpulses alone(const SingleContact<Traced>& c, bool rubs, const Traced& tolerance);

/// The row of a joint friction: entries of D beside a contact, and its rate without impulses.
struct JointBeside {
  Traced ns, ts, ss, b;
  Traced bound;                 // N s
  Traced last_n, last_t, last;  // N s, of the contact and of the joint in the last step
};

/// A joint friction alone.
LaneImpulses slide_alone(const Traced& D, const Traced& b, const Traced& bound, const Traced& tolerance);

/// A contact and a joint friction in the mode of their last impulses: the contact is pressed and slides, or
/// has no friction, and the joint slides. enumeration() tries this mode first.
LaneImpulses with_slide(const SingleContact<Traced>& c, bool rubs, const JointBeside& j,
                        const Traced& tolerance);

}  // namespace freeplay

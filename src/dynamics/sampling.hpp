// Sampling: states of elements that change at given instants only (sampled controllers). They are entries of
// State::z without a rate; System::sample() changes them at the instants, where each step of every scheme
// ends. Instants are computed from their number, so that their rounding errors do not add up.
#pragma once

#include <string_view>

namespace freeplay {

class System;

/// Instants and ends closer than this to each other are one, relative to the time: no step resolves less.
inline constexpr double one_instant = 8e-16;
/// Whether an instant is not after t, both ≥ 0 (s).
inline bool is_due(double instant, double t) { return instant <= t * (1 + one_instant); }

/// Throws ModelError at the first sampled controller, if there is one. `why` says what needs a motion that is
/// continuous in time.
void refuse_sampling(const System& system, std::string_view why);
inline constexpr std::string_view no_derivatives =
    "the motion under a sampled controller has no derivatives here: its output changes at instants only; "
    "omit the key for the continuous law";

}  // namespace freeplay

// A law is one enumerator (ContactLaw or FrictionLaw in src/mechanism/options.hpp) and one file that specialises Law for
// it, contact/NAME.hpp or friction/NAME.hpp. The build lists the files; the tables and every choice of a law are made
// from the enumerators. So an enumerator without its file does not compile, nor a file without its enumerator.
#pragma once

#include <utility>

#include "values/enumerators.hpp"

namespace freeplay {

/// What a law is: its facts and its equation. contact_parts.hpp and friction_parts.hpp say what its file must give.
template <auto law>
struct Law;

/// Calls f with the Law of the enumerator. A chain of comparisons, the first enumerator's first; all is inlined.
template <ScopedEnum E, int I = 0, class F>
[[gnu::always_inline]] inline constexpr decltype(auto) visit_law(E law, F&& f) {
  if constexpr (I + 1 == enumerators<E>()) {
    return f(Law<static_cast<E>(I)>{});
  } else {
    if (law == static_cast<E>(I)) return f(Law<static_cast<E>(I)>{});
    return visit_law<E, I + 1>(law, std::forward<F>(f));
  }
}

}  // namespace freeplay

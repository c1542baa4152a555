// Registration of contact and friction laws. A law is one enumerator (ContactLaw or FrictionLaw in
// src/mechanism/options.hpp) and one file that specialises Law for it, laws/NAME.hpp or
// friction/NAME.hpp. The build lists the files; the tables and every selection of a law are
// generated from the enumerators. An enumerator without a file does not compile, nor does a file
// without an enumerator.
#pragma once

#include <utility>

#include "values/enumerators.hpp"

namespace freeplay {

/// The facts and the equation of a law. contact_parts.hpp and friction_parts.hpp define the
/// required members.
template <auto law>
struct Law;

/// Calls f with the Law of the enumerator: a chain of comparisons in the order of the enumerators,
/// all inlined.
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

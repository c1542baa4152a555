// How many enumerators an enumeration has, told at compile time, so that a table beside it can be held to it:
//
//     constexpr std::array<Facts, enumerators<Kind>()> table = …;
//
// A template on the value V names itself with the enumerator's name where V has one, and with a cast, (E)7, where it
// has none; g++ and clang both do. The enumerators must be 0, 1, 2, … without holes, as they are when none is given
// a value.
#pragma once

#include <cstddef>
#include <string_view>
#include <type_traits>
#include <utility>

namespace freeplay {

template <class E>
concept ScopedEnum = std::is_enum_v<E> && !std::is_convertible_v<E, int>;

namespace detail {

/// The compiler's spelling of V, with the function's own name around it.
template <auto V>
constexpr std::string_view spelled() {
  return __PRETTY_FUNCTION__;
}

/// Whether V is an enumerator and not a number cast to its type: a cast ends in ")7".
template <auto V>
constexpr bool is_enumerator() {
  const auto text = spelled<V>();
  for (auto i = text.find("V = "); i + 1 < text.size() && text[i] != ';'; ++i)
    if (text[i] == ')' && text[i + 1] >= '0' && text[i + 1] <= '9') return false;
  return true;
}

template <class E, int N>
constexpr int count_from() {
  if constexpr (is_enumerator<static_cast<E>(N)>())
    return count_from<E, N + 1>();
  else
    return N;
}

}  // namespace detail

/// Number of enumerators of E, which count up from 0.
template <ScopedEnum E>
constexpr int enumerators() {
  return detail::count_from<E, 0>();
}

/// Calls f with std::integral_constant<E, V> for each enumerator V in order, and returns what the braces of R make
/// of the results: `each_enumerator<Kind, std::array<Facts, n>>([](auto v) { return Facts{…}; })`.
template <ScopedEnum E, class R, class F>
constexpr R each_enumerator(F f) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return R{f(std::integral_constant<E, static_cast<E>(I)>{})...};
  }
  (std::make_index_sequence<static_cast<std::size_t>(enumerators<E>())>{});
}

}  // namespace freeplay

// Number of enumerators of an enumeration, at compile time, so that the size of a table can be
// checked:
//
//     constexpr std::array<Facts, enumerators<Kind>()> table = …;
//
// The function name of a template on the value V contains the enumerator's name if V has one, else
// a cast such as (E)7; this is true of g++ and clang. The enumerators must be 0, 1, 2, … without
// holes, as they are if none is given a value.
#pragma once

#include <cstddef>
#include <string_view>
#include <type_traits>
#include <utility>

namespace freeplay {

template <class E>
concept ScopedEnum = std::is_enum_v<E> && !std::is_convertible_v<E, int>;

namespace detail {

/// The compiler's spelling of V, within the name of the function.
template <auto V>
constexpr std::string_view spelled() {
  return __PRETTY_FUNCTION__;
}

/// Whether V is an enumerator rather than a number cast to the type: a cast ends in ")7".
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

/// Number of enumerators of E, counted from 0.
template <ScopedEnum E>
constexpr int enumerators() {
  return detail::count_from<E, 0>();
}

/// Calls f with std::integral_constant<E, V> for each enumerator V in order, and returns
/// R{results...}: `each_enumerator<Kind, std::array<Facts, n>>([](auto v) { return Facts{…}; })`.
template <ScopedEnum E, class R, class F>
constexpr R each_enumerator(F f) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return R{f(std::integral_constant<E, static_cast<E>(I)>{})...};
  }
  (std::make_index_sequence<static_cast<std::size_t>(enumerators<E>())>{});
}

}  // namespace freeplay

// Visitor by which facts and options name their keys in a scene file. Each type has
//
//     static void keys(auto& k, auto& x);
//
// which names every key once. The visitor k is the reader (it fills x), the writer of the canonical
// text or the check of facts in code (x is const), or the list of all keys, from which
// docs/reference/scene.md and the check for unknown keys are made. k offers
//
//     need(Key, value, Range)     a required key; value: number, Vec2, text, whole number
//     take(Key, value, Range)     an optional key; without it, value keeps its default
//     flag(Key, value)            a boolean; the canonical text has the key only if it is true
//     choose(Key, value)          a word; value: an enumeration with choices(E)
//     group(name, optional)       keys of an optional part; returns a pointer to it, or nullptr
//     when(condition)             whether to visit keys that are valid only under the condition
//     check(holds, name, ...)     throws "name: ..." from the pieces if `holds` is false
//     between, ends, body, joint, surface, lubricant     references to other parts by name
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "values/enumerators.hpp"

namespace freeplay {

struct Key {
  std::string_view name, unit, meaning;
  /// Meaning of an absent key, if its default value does not show it.
  std::string_view fallback = {};
};

/// A key with the name of its type in the documentation.
struct TypedKey {
  Key key;
  const char* type;
};

/// The range of a number; `text` completes the sentence "must be ...".
struct Range {
  bool (*holds)(double);
  const char* text;
};
inline constexpr Range any_number{[](double) { return true; }, "a number"};
inline constexpr Range positive{[](double x) { return x > 0; }, "greater than 0"};
inline constexpr Range non_negative{[](double x) { return x >= 0; }, "0 or greater"};
inline constexpr Range one_or_more{[](double x) { return x >= 1; }, "1 or greater"};
inline constexpr Range whole{
    [](double x) { return x >= 0 && x < 4294967296.0 && x == static_cast<double>(static_cast<unsigned>(x)); },
    "a whole number from 0"};
inline constexpr Range one_to_eight{[](double x) { return x >= 1 && x <= 8 && x == static_cast<int>(x); },
                                    "a whole number from 1 to 8"};
inline constexpr Range zero_to_one{[](double x) { return x >= 0 && x <= 1; }, "between 0 and 1"};
inline constexpr Range zero_to_half{[](double x) { return x >= 0 && x <= 0.5; }, "between 0 and 0.5"};

/// Properties in which the values of E differ, besides their names. Specialised where needed.
template <class E>
struct Traits {};

/// One value of an enumeration with its word in a scene.
template <class E>
struct Choice {
  E value{};
  std::string_view text = {};
  std::string_view meaning = {};  ///< follows the word in docs/reference/scene.md
  Traits<E> traits = {};
};

/// A former word of an enumeration, refused with advice on its replacement. Such an enumeration has
/// removed_words(E) beside its choices(E).
struct RemovedWord {
  std::string_view text = {};
  std::string_view instead = {};
};

/// A table of all values of E in their order. A missing value is a compile error.
template <class E, std::size_t N>
consteval std::array<Choice<E>, N> complete(const Choice<E> (&rows)[N]) {
  static_assert(static_cast<int>(N) == enumerators<E>(), "the table of names lacks a value");
  std::array<Choice<E>, N> table;
  for (std::size_t i = 0; i < N; ++i) {
    if (static_cast<std::size_t>(rows[i].value) != i)
      throw "the table of names is not in the order of its values";
    table[i] = rows[i];
  }
  return table;
}

/// The row of a value. Every enumeration in a scene has choices(E) beside it.
template <class E>
constexpr const Choice<E>& choice_of(E value) {
  return choices(value)[static_cast<int>(value)];
}
template <class E>
constexpr std::string_view text_of(E value) {
  return choice_of(value).text;
}

}  // namespace freeplay

// How facts and options say which keys of a scene file they stand in. Each has
//
//     static void keys(auto& k, auto& x);
//
// which names every key once: k is the reader (fills x), the writer of the canonical text (x is const) or the
// list of all keys, from which docs/reference/scene.md and the check for unknown keys are made. k offers
//
//     need(Key, value, Range)     a key that must be there; value: number, Vec2, text, whole number
//     take(Key, value, Range)     one that may be left out: value keeps its default, an optional stays empty
//     flag(Key, value)            whether something is so; the canonical text has it where it is
//     choose(Key, value)          a word; value: an enumeration with choices(E)
//     group(name, optional)       what the key `name` switches on: a pointer to it, or nullptr
//     when(condition)             whether keys that hold only then are to be visited
//     check(holds, name, ...)     refuses what is read when it does not hold: "name: ..." from the pieces
//     between, ends, body, joint, surface, lubricant     what names other things of the mechanism
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "values/enumerators.hpp"

namespace freeplay {

struct Key {
  std::string_view name, unit, meaning;
  std::string_view fallback = {};  ///< what a left-out key stands for, where its value does not show it
};

/// What a number must satisfy; `text` completes "must be ...".
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

/// What the values of E differ in beside their names; specialised where there is something.
template <class E>
struct Traits {};

/// One value of an enumeration as a scene spells it.
template <class E>
struct Choice {
  E value{};
  std::string_view text = {};
  std::string_view meaning = {};  ///< stands behind the word in docs/reference/scene.md
  Traits<E> traits = {};
};

/// A word that an enumeration no longer has, refused with what to use instead. An enumeration that has some has
/// removed_words(E) beside its choices(E).
struct RemovedWord {
  std::string_view text = {};
  std::string_view instead = {};
};

/// A table of all values of E, each at its own number: a forgotten one does not compile.
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

/// The row of a value; every enumeration that a scene spells has choices(E) beside it.
template <class E>
constexpr const Choice<E>& choice_of(E value) {
  return choices(value)[static_cast<int>(value)];
}
template <class E>
constexpr std::string_view text_of(E value) {
  return choice_of(value).text;
}

}  // namespace freeplay

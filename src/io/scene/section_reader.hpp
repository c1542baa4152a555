// SectionReader: the visitor of the `keys()` functions (mechanism/keys.hpp) that reads numbers,
// texts, words and lists from one section of any document: a scene, a study or a style of figures.
// It checks each value. Errors are SceneErrors with the position of the key.
//
// Use: derive a reader that adds the verbs of its document, as KeysReader does for scenes and
// StudyReader for studies. A reader refers to the section; it does not own it.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "io/scene/section.hpp"

namespace freeplay {

/// The words of an enumeration, in the order of its values.
template <class E>
std::vector<std::string> words() {
  std::vector<std::string> list;
  for (const auto& choice : choices(E{})) list.emplace_back(choice.text);
  return list;
}

/// Visitor of the `keys()` functions that reads one section.
class SectionReader {
 public:
  explicit SectionReader(Section& section) : s_(section) {}

  void need(const Key& key, double& x, const Range& range = any_number) { x = s_.number(key, range); }
  void need(const Key& key, std::integral auto& x, const Range& range) {
    x = static_cast<std::decay_t<decltype(x)>>(s_.number(key, range));
  }
  void need(const Key& key, bool& x) { x = s_.flag(key.name); }
  void need(const Key& key, Vec2& x) { x = s_.point(key); }
  void need(const Key& key, std::string& x) { x = s_.text(key.name); }
  /// The path of a file, which the document gives relative to its folder.
  void need(const Key& key, std::filesystem::path& x) { x = s_.named_file(key.name); }
  template <class E>
  requires std::is_enum_v<E>
  void need(const Key& key, E& x) {
    if constexpr (requires { removed_words(E{}); })
      for (const auto& word : removed_words(E{}))
        if (s_.text(key.name) == word.text)
          s_.fail(key.name, fmt::format("\"{}\" has been removed: {}", word.text, word.instead));
    x = static_cast<E>(s_.choice(key.name, words<E>()));
  }
  void take(const Key& key, auto& x, const auto&... range) {
    if (!s_.has(key.name)) return;
    if constexpr (requires { x.emplace(); })
      need(key, x.emplace(), range...);
    else
      need(key, x, range...);
  }
  void flag(const Key& key, bool& x) { take(key, x); }
  /// A list of names.
  void names(const Key& key, std::vector<std::string>& x) {
    if (s_.has(key.name)) x = s_.names(key.name);
  }
  /// One value that several keys can give. `read` fills x from the section.
  void together(std::initializer_list<TypedKey>, auto& x, const auto& read) { read(s_, x); }
  /// A value of another type, called `type` in the documentation. `read` takes it from the section.
  void other(const Key& key, const char*, auto& x, const auto& read) {
    if (s_.has(key.name)) x = read(s_, key.name);
  }

  void choose(const Key& key, auto& x) { take(key, x); }
  /// Reads a number, or a word that means none.
  void number_or(std::string_view word, const Key& key, std::optional<double>& x, const Range& range) {
    x = s_.number_or(word, key, range);
  }
  /// Reads a word. The writer omits the first word of such a key, so that older scenes keep their
  /// canonical text.
  void choose_other(const Key& key, auto& x) { take(key, x); }
  void choose_listed(const Key& key, auto& x) { take(key, x); }
  /// Reads one of the words whose value satisfies `fits`.
  template <class E, class Fits>
  void choose_some(const Key& key, std::optional<E>& x, Fits fits) {
    if (!s_.has(key.name)) return;
    std::vector<E> values;
    std::vector<std::string> texts;
    for (const auto& choice : choices(E{}))
      if (fits(choice.value)) {
        values.push_back(choice.value);
        texts.emplace_back(choice.text);
      }
    x = values[static_cast<std::size_t>(s_.choice(key.name, texts))];
  }

  /// Keys of a part that exists if the key `name` is given.
  template <class G>
  G* group(std::string_view name, std::optional<G>& x) {
    return s_.has(name) ? &x.emplace() : nullptr;
  }
  /// The same; the documentation does not say "with NAME" of each key.
  auto* given(std::string_view name, auto& x) { return group(name, x); }
  bool when(bool holds) const { return holds; }
  /// Keys that are valid under a condition only. If it is false, a given key is refused with `why`.
  bool when(bool holds, std::initializer_list<std::string_view> keys, const char* why) const {
    if (!holds)
      for (const auto key : keys)
        if (s_.has(key)) s_.fail(key, why);
    return holds;
  }
  bool when_given(std::string_view name) const { return s_.has(name); }
  void check(bool holds, std::string_view name, const auto&... pieces) const {
    if (!holds) s_.fail(name, (piece(pieces) + ...));
  }

 protected:
  Section& s_;

 private:
  static std::string piece(double x) { return fmt::format("{:.6g}", x); }
  static std::string piece(const char* text) { return text; }
};

}  // namespace freeplay

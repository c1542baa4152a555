// Section: one table of a scene or study file with typed access. It records which keys were read,
// so that done() can refuse the others, and gives every error its position FILE:LINE:COL. Numbers
// with a unit are converted to the unit of their key (io/scene/quantity.hpp).
//
// Use: parse_toml(), refuse_unknown_keys(), construct the root section, read its keys and
// children(), then done(). A section refers to the parsed document and its SceneSource, which must
// outlive it.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/files/access.hpp"
#include "io/scene/schema.hpp"  // IWYU pragma: export
#include "io/scene/toml.hpp"
#include "mechanism/error.hpp"
#include "mechanism/keys.hpp"
#include "values/read_file.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Parses TOML. Throws SceneError with FILE:LINE:COL if the text is not valid TOML in UTF-8. `name`
/// is the file name in messages. A byte-order mark is ignored.
toml::table parse_toml(const std::string& text, const std::string& name);
/// Reads a whole file. Throws SceneError.
std::string read_text(const std::filesystem::path& file);

/// Names are used in headers of result files and in dotted keys.
bool is_plain_name(std::string_view name);
/// Reason why a name is invalid; empty if it is valid.
std::string wrong_name(std::string_view name);
/// Message about a word that is not one of `words`.
std::string unknown_word(std::string_view word, const std::vector<std::string>& words);

/// Origin of a parsed document: its name in messages, and the values set by options of the command
/// line.
struct SceneSource {
  std::string name;
  std::map<std::string, std::string> overridden = {};  ///< dotted key → KEY=VALUE as given
  /// These keys in the order of the command line.
  std::vector<std::string> order = {};
  /// Keys that an option's choice disabled, with the reason.
  mutable std::vector<std::string> idle = {};
  /// Units found with numbers whose key has no fixed unit, by table and axis: curves.NAME, "of x"
  /// or "of y".
  mutable std::map<std::pair<std::string, std::string>, std::string> given = {};
  /// Elements that exist in options only, by path (joints.NAME), with the names that the file
  /// defines in the same table.
  std::map<std::string, std::vector<std::string>> made = {};
  Reach reach = Reach::beside;               ///< permitted location of named files
  mutable std::vector<ReadFile> files = {};  ///< named files that were read
  const Schema* schema = &scene_schema();    ///< the keys that it may have

  /// Throws SceneError about `path`, with the position of `node` or the option that set it. The
  /// message also names options that set other keys of the same table, which may be the cause.
  [[noreturn]] void fail(const toml::node* node, const std::string& path, const std::string& message) const;
  /// Throws SceneError if `path` belongs to an element that exists in options only: the option
  /// probably misspells the name.
  void refuse_made(const std::string& path) const;
};

/// Refuses the first key that a scene (pattern ""), a study ("study") or a style ("style") cannot
/// have. Called before any key is read, so that a misspelt key is reported before its consequences.
void refuse_unknown_keys(const toml::table& document, std::string_view pattern, const SceneSource& source);

/// Name of a key to be read, the unit to which its number is converted, and its meaning for messages: the
/// given ones, or else those of the schema, which describe the key in all kinds of element.
struct Requested {
  std::string_view name;
  std::optional<std::string_view> unit = {};
  std::string_view meaning = {};
  Requested(std::string_view key)
      : name(key) {}                         // NOLINT(google-explicit-constructor): most keys are only a name
  Requested(const char* key) : name(key) {}  // NOLINT(google-explicit-constructor)
  Requested(const Key& key)                  // NOLINT(google-explicit-constructor)
      : name(key.name), unit(key.unit), meaning(key.meaning) {}
};

/// One table of the document.
class Section {
 public:
  /// `path`: dotted key of the table, "" for the root. `pattern`: the same with * for names chosen
  /// by the author.
  Section(const toml::table& table, std::string path, std::string pattern, const SceneSource& source);

  bool has(std::string_view key) const { return table_.contains(key); }
  bool is_text(std::string_view key) const;
  bool is_list_of_lists(std::string_view key) const;
  double number(const Requested& key, Range range);
  /// A number, or nullopt for the text `word`.
  std::optional<double> number_or(std::string_view word, const Requested& key, Range range);
  std::string text(const Requested& key);
  bool flag(std::string_view key);
  Vec2 point(const Requested& key);
  /// A list of [x, y] pairs.
  std::vector<Vec2> points(const Requested& key);
  /// A list of pairs or names; `named` converts a name, with its index in the list.
  std::vector<Vec2> points(const Requested& key,
                           const std::function<Vec2(std::size_t, const std::string&)>& named);
  std::vector<std::string> names(std::string_view key);
  std::vector<double> numbers(const Requested& key);
  /// A list of rows of numbers, each with one number for each of `units`.
  std::vector<std::vector<double>> rows(std::string_view key, const std::vector<std::string_view>& units);
  /// A name, or a list of names.
  std::vector<std::string> name_or_names(std::string_view key);
  /// A table of texts by name, in the order of the file.
  std::vector<std::pair<std::string, std::string>> texts(std::string_view key);
  /// A table of points by name.
  std::vector<std::pair<std::string, Vec2>> named_points(const Requested& key);
  /// The value of `key` as an index into `choices`. Messages list the choices.
  int choice(std::string_view key, const std::vector<std::string>& choices);
  /// The subtables of `key` in the order of the file, then those of options in the order of the
  /// command line. Empty if `key` is absent.
  std::vector<std::pair<std::string, Section>> children(std::string_view key);
  /// The table `key`, or an empty one.
  Section child(std::string_view key);

  /// Throws SceneError about a key that was not read. `kind` describes the element in the message
  /// ("a revolute joint").
  void done(const std::string& kind) const;
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  /// Throws SceneError about a missing key; "" for one of several.
  [[noreturn]] void lacks(std::string_view key, const std::string& message) const;
  /// Refuses a derived value x > 0 that is implausible for its unit.
  void require_sense(std::string_view key, std::string_view unit, double x) const;
  /// Whether an option of the command line gave the key.
  bool by_option(std::string_view key) const { return source_->overridden.contains(full(key)); }
  /// Records a key that an option's choice disabled.
  void idle(std::string_view key, const std::string& why) const {
    source_->idle.push_back(full(key) + " " + why);
  }
  const std::string& path() const { return path_; }
  /// The unit that the numbers "of x" or "of y" of the table `path` were given in
  /// (io/scene/quantity.hpp), or nullptr.
  const std::string* given(const std::string& path, const std::string& of) const {
    const auto found = source_->given.find({path, of});
    return found == source_->given.end() ? nullptr : &found->second;
  }
  /// The file that a key names, relative to the folder of the document. Files outside that folder
  /// are refused unless SceneSource::reach permits them.
  std::filesystem::path named_file(std::string_view key);
  /// Text of such a file.
  std::string named_text(std::string_view key);

 private:
  const toml::node* take(std::string_view key);
  const toml::node& require(const Requested& key);
  /// `column`: index of the unit in that of a point, such as "s, N m".
  double to_number(const toml::node& node, const Requested& key, Range range, int column = 0) const;
  Vec2 to_point(const toml::node& node, const Requested& key) const;
  std::string full(std::string_view key) const;
  /// Its row of the schema, or nullptr.
  const SchemaKey* row_of(std::string_view key) const;

  const toml::table& table_;
  std::string path_, pattern_;
  const SceneSource* source_;
  std::set<std::string, std::less<>> read_;
};

// SectionReader: the visitor of the `keys()` functions (mechanism/keys.hpp) that reads numbers,
// texts, words and lists from one section of any document: a scene, a study or a style of figures.
// It checks each value. Errors are SceneErrors with the position of the key.
//
// Use: derive a reader that adds the verbs of its document, as KeysReader does for scenes and
// StudyReader for studies. A reader refers to the section; it does not own it.

/// The words of an enumeration whose values satisfy `fits`, in the order of its values.
template <class E, class Fits = bool (*)(E)>
std::vector<std::string> words(Fits fits = [](E) { return true; }) {
  std::vector<std::string> list;
  for (const auto& choice : choices(E{}))
    if (fits(choice.value)) list.emplace_back(choice.text);
  return list;
}

/// The message of a check in keys(), from its pieces.
std::string joined_pieces(const auto&... pieces) {
  const auto shown = [](const auto& piece) {
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(piece)>>)
      return fmt::format("{:.6g}", piece);
    else
      return std::string(piece);
  };
  return (shown(pieces) + ...);
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
  /// A number in the unit of another key of the document.
  void deviation(const Key& key, auto& x, const std::string& other) {
    const Key own{key.name, unit_of(other), key.meaning};
    if constexpr (requires { x.emplace(); })
      take(own, x);
    else
      need(own, x);
  }
  /// A list of names.
  void names(const Key& key, std::vector<std::string>& x) {
    if (s_.has(key.name)) x = s_.names(key.name);
  }
  /// A list of rows of numbers in these units; may be absent.
  void rows(const Key& key, const std::vector<std::string_view>& units, std::vector<std::vector<double>>& x) {
    if (s_.has(key.name)) x = s_.rows(key.name, units);
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
    const auto texts = words<E>(fits);
    const auto& text = texts[static_cast<std::size_t>(s_.choice(key.name, texts))];
    x = std::ranges::find(choices(E{}), text, &Choice<E>::text)->value;
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
    if (!holds) s_.fail(name, joined_pieces(pieces...));
  }

 protected:
  Section& s_;
};

}  // namespace freeplay

// One table of a scene file with typed access. It remembers which keys were read, so that what nobody reads
// is refused, and it knows where each stands, so that a message can say FILE:LINE:COL.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/scene/named_file.hpp"
#include "io/scene/spelling.hpp"  // IWYU pragma: export
#include "io/scene/toml.hpp"
#include "mechanism/error.hpp"
#include "mechanism/keys.hpp"
#include "values/read_file.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Throws SceneError FILE:LINE:COL for what is not TOML in UTF-8; `name` stands for the file. A byte-order mark is passed over.
toml::table parse_toml(const std::string& text, const std::string& name);
/// The whole of a file, or SceneError.
std::string read_text(const std::filesystem::path& file);

/// The parsed document: its name in messages and the values that came from the command line.
struct SceneSource {
  std::string name;
  std::map<std::string, std::string> overridden = {};  ///< dotted key → KEY=VALUE as given
  std::vector<std::string> order = {};                 ///< of these keys on the command line
  mutable std::vector<std::string> idle = {};          ///< keys that options laid aside, and why
  /// Units of numbers whose key leaves that open, by table and key's unit: curves.NAME, "of x" or "of y".
  mutable std::map<std::pair<std::string, std::string>, std::string> given = {};
  /// What only options made, by its path (joints.NAME), and the names that the file has beside it.
  std::map<std::string, std::vector<std::string>> made = {};
  Reach reach = Reach::beside;               ///< of files that it names
  mutable std::vector<ReadFile> files = {};  ///< that were read

  /// Throws SceneError about `path`, placed at `node` or at the option that set it. Options that set other keys of the
  /// same table are named with it: they may be the cause.
  [[noreturn]] void fail(const toml::node* node, const std::string& path, const std::string& message) const;
  /// Throws where `path` is of something that only options made: they have misspelt the name of what they meant.
  void refuse_made(const std::string& path) const;
};

/// Refuses the first key that no scene ("") or study ("study") has, before any is read: a misspelt key is told before
/// what follows from it.
void refuse_unknown_keys(const toml::table& document, std::string_view pattern, const SceneSource& source);

/// A key that is read, with the unit that a number beside a unit is converted to: the key's own, or else that of the
/// schema's row.
struct Asked {
  std::string_view name;
  std::optional<std::string_view> unit = {};
  Asked(std::string_view key)
      : name(key) {}                     // NOLINT(google-explicit-constructor): most keys are only a name
  Asked(const char* key) : name(key) {}  // NOLINT(google-explicit-constructor)
  Asked(const Key& key) : name(key.name), unit(key.unit) {}  // NOLINT(google-explicit-constructor)
};

class Section {
 public:
  /// `path` is the dotted key of the table ("" for the root), `pattern` the same with * for chosen names.
  Section(const toml::table& table, std::string path, std::string pattern, const SceneSource& source);

  bool has(std::string_view key) const { return table_.contains(key); }
  bool is_text(std::string_view key) const;
  bool is_list_of_lists(std::string_view key) const;
  double number(const Asked& key, Range range);
  double number(const Asked& key, Range range, double fallback);
  /// A number, or nothing for `word`.
  std::optional<double> number_or(std::string_view word, const Asked& key, Range range);
  std::optional<double> maybe_number(const Asked& key, Range range);
  std::string text(std::string_view key);
  std::string text(std::string_view key, const std::string& fallback);
  bool flag(std::string_view key, bool fallback);
  Vec2 point(const Asked& key, Vec2 fallback);
  Vec2 point(const Asked& key);
  /// A list of [x, y] pairs.
  std::vector<Vec2> points(const Asked& key);
  /// The same of pairs or names: a text is what `named` makes of it, its place in the list given.
  std::vector<Vec2> points(const Asked& key,
                           const std::function<Vec2(std::size_t, const std::string&)>& named);
  std::vector<std::string> names(std::string_view key);
  std::vector<double> numbers(const Asked& key);
  /// A list of lists of numbers, each of as many as there are units, which they are in.
  std::vector<std::vector<double>> rows(std::string_view key, const std::vector<std::string_view>& units);
  /// A name, or a list of them.
  std::vector<std::string> name_or_names(std::string_view key);
  /// A table of texts by name, in the order of the file.
  std::vector<std::pair<std::string, std::string>> texts(std::string_view key);
  /// A table of points by name.
  std::vector<std::pair<std::string, Vec2>> named_points(const Asked& key);
  /// The value of `key` as an index into `choices`; a message lists them.
  int choice(std::string_view key, const std::vector<std::string>& choices, int fallback);
  int choice(std::string_view key, const std::vector<std::string>& choices);
  /// The sub-tables of `key` in the order they stand in the file, then those that the command line made, in the order of
  /// its options; `key` itself may be missing.
  std::vector<std::pair<std::string, Section>> children(std::string_view key);
  /// The table `key`, or an empty one.
  Section child(std::string_view key);

  /// Throws about a key that nobody read: it belongs to another kind. `kind` says whose keys they are ("a revolute joint").
  void done(const std::string& kind) const;
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  /// Throws about a key that is not there; "" for one of several.
  [[noreturn]] void lacks(std::string_view key, const std::string& message) const;
  /// Refuses what a key amounts to, x > 0, where that is beyond what its unit may be.
  void require_sense(std::string_view key, std::string_view unit, double x) const;
  /// Whether an option gave the key, not the file.
  bool by_option(std::string_view key) const { return source_->overridden.contains(full(key)); }
  /// Notes a key that an option's choice lays aside.
  void idle(std::string_view key, const std::string& why) const {
    source_->idle.push_back(full(key) + " " + why);
  }
  const std::string& path() const { return path_; }
  /// What those numbers "of x" or "of y" in the table `path` that had a unit are in (io/scene/quantity.hpp), or nullptr.
  const std::string* given(const std::string& path, const std::string& of) const {
    const auto found = source_->given.find({path, of});
    return found == source_->given.end() ? nullptr : &found->second;
  }
  /// The text of the file that a key names, from the scene's folder. A file elsewhere is refused, unless all are allowed.
  std::string named_text(std::string_view key);

 private:
  const toml::node* take(std::string_view key);
  const toml::node& require(std::string_view key);
  /// `column`: which of a point's units, "s, N m".
  double to_number(const toml::node& node, const Asked& key, Range range, int column = 0) const;
  void require_sense(const toml::node& node, const Asked& key, double x, bool greater_than_zero) const;
  Vec2 to_point(const toml::node& node, const Asked& key) const;
  int to_choice(const std::string& value, std::string_view key,
                const std::vector<std::string>& choices) const;
  std::string full(std::string_view key) const;

  const toml::table& table_;
  std::string path_, pattern_;
  const SceneSource* source_;
  std::set<std::string, std::less<>> read_;
};

}  // namespace freeplay

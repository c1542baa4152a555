// One table of a scene file with typed access. It remembers which keys were read, so that what nobody reads
// is refused, and it knows where each stands, so that a message can say FILE:LINE:COL.
#pragma once

#include <stdexcept>

// toml++ 3.3 states its assumptions as assertions that become undefined behaviour without them: some
// malformed text breaks them (found by the fuzz target). Here they throw, in every build; parse_toml reports
// it.
#define TOML_ENABLE_FORMATTERS 0
namespace freeplay {
[[noreturn]] inline void broken_assumption(const char* what) { throw std::logic_error(what); }
}  // namespace freeplay
#define TOML_ASSERT(condition) ((condition) ? void() : freeplay::broken_assumption(#condition))
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/error.hpp"
#include "model/keys.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Throws SceneError FILE:LINE:COL for what is not TOML; `name` stands for the file.
toml::table parse_toml(const std::string& text, const std::string& name);
/// The whole of a file, or SceneError.
std::string read_text(const std::filesystem::path& file);

/// The parsed document: its name in messages and the values that came from the command line.
struct SceneSource {
  std::string name;
  std::map<std::string, std::string> overridden;  ///< dotted key → KEY=VALUE as given
  std::vector<std::string> order = {};            ///< of these keys on the command line
  mutable std::vector<std::string> idle = {};     ///< keys that have no effect, and why

  /// Throws SceneError about `path`, placed at `node` (or at the override that set it).
  [[noreturn]] void fail(const toml::node* node, const std::string& path, const std::string& message) const;
};

class Section {
 public:
  /// `path` is the dotted key of the table ("" for the root), `pattern` the same with * for chosen names.
  Section(const toml::table& table, std::string path, std::string pattern, const SceneSource& source);

  bool has(std::string_view key) const { return table_.contains(key); }
  double number(std::string_view key, Range range);
  double number(std::string_view key, Range range, double fallback);
  /// A number, or nothing for `word`.
  std::optional<double> number_or(std::string_view word, std::string_view key, Range range);
  std::optional<double> maybe_number(std::string_view key, Range range);
  std::string text(std::string_view key);
  std::string text(std::string_view key, const std::string& fallback);
  bool flag(std::string_view key, bool fallback);
  Vec2 point(std::string_view key, Vec2 fallback);
  Vec2 point(std::string_view key);
  /// A list of [x, y] pairs.
  std::vector<Vec2> points(std::string_view key);
  std::vector<std::string> names(std::string_view key);
  std::vector<double> numbers(std::string_view key);
  /// The value of `key` as an index into `choices`; a message lists them.
  int choice(std::string_view key, const std::vector<std::string>& choices, int fallback);
  int choice(std::string_view key, const std::vector<std::string>& choices);
  /// The sub-tables of `key` in the order they stand in the file, then those that the command line made, in the order of
  /// its options; `key` itself may be missing.
  std::vector<std::pair<std::string, Section>> children(std::string_view key);
  /// The table `key`, or an empty one.
  Section child(std::string_view key);

  /// Throws about a key that nobody read. `kind` says whose keys they are ("a revolute joint").
  void done(const std::string& kind) const;
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;
  /// Notes a key that is read and has no effect here.
  void idle(std::string_view key, const std::string& why) const {
    source_->idle.push_back(full(key) + " " + why);
  }
  const std::string& path() const { return path_; }

 private:
  const toml::node* take(std::string_view key);
  const toml::node& require(std::string_view key);
  double to_number(const toml::node& node, std::string_view key, Range range) const;
  void require_sense(const toml::node& node, std::string_view key, double x, bool greater_than_zero) const;
  Vec2 to_point(const toml::node& node, std::string_view key) const;
  int to_choice(const std::string& value, std::string_view key,
                const std::vector<std::string>& choices) const;
  std::string full(std::string_view key) const;

  const toml::table& table_;
  std::string path_, pattern_;
  const SceneSource* source_;
  std::set<std::string, std::less<>> read_;
};

}  // namespace freeplay

// Comparison of a document with the schema before it is read.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "io/scene/schema.hpp"
#include "io/scene/section.hpp"
#include "io/scene/spelling.hpp"

namespace freeplay {
namespace {

/// A key that is not in the schema.
struct Unknown {
  const toml::node* node;
  std::string path, table, name;
};

/// Keys of options are reported before those of the file, since the user has just typed them.
bool before(const Unknown& a, const Unknown& b) { return a.node->source().begin < b.node->source().begin; }

/// The first unknown key of `table` and its subtables. `path` is the table's dotted key.
std::optional<Unknown> first_unknown(const Schema& schema, const toml::table& table, const std::string& path,
                                     std::string_view pattern) {
  const auto& known = schema.keys_of(pattern);
  const bool names = std::ranges::find(known, "*") != known.end();
  std::optional<Unknown> first;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const auto own = path.empty() ? name : fmt::format("{}.{}", path, name);
    const auto below = pattern.empty() ? name : fmt::format("{}.{}", pattern, names ? "*" : name);
    std::optional<Unknown> found;
    if (!names && std::ranges::find(known, name) == known.end())
      found = Unknown{&node, own, std::string(pattern), name};
    else if (const auto* sub = node.as_table(); sub && !schema.find(below))
      found = first_unknown(schema, *sub, own, below);
    if (found && (!first || before(*found, *first))) first = std::move(found);
  }
  return first;
}

/// Suggestion for an unknown key: a similar key of the table, else the table to which the key
/// belongs, else the list of known keys.
std::string remedy(const Schema& schema, const Unknown& unknown) {
  const auto& known = schema.keys_of(unknown.table);
  if (unknown.table == "study" && unknown.name == "study")
    return "; keys of a study are at the root: [axes.NAME], without study";
  if (const auto near = nearest_word(unknown.name, known); !near.empty())
    return fmt::format("; did you mean {}?", near);
  for (const auto& key : schema.keys())
    if (!unknown.node->is_table() && key.path.ends_with("." + unknown.name))
      return fmt::format("; it belongs to {}", key.path.substr(0, key.path.rfind('.')));
  return listed("there are", known);
}

/// Refuses a scene in place of a study and vice versa, before its first key is reported as
/// misspelt.
void refuse_mistaken(const toml::table& document, std::string_view pattern, const SceneSource& source) {
  const bool scene = document.contains("bodies") || document.contains("joints"),
             study = document.contains("scene");
  if (scene == study) return;
  if (pattern == "study" && scene)
    throw SceneError(
        fmt::format("{}: is a scene; a study refers to one by scene = \"{}\": docs/reference/study.md",
                    source.name, std::filesystem::path(source.name).filename().string()));
  if (pattern.empty() && study)
    throw SceneError(fmt::format(
        "{}: is a study, for freeplay sweep, bifurcation or basin; its key scene gives the scene file",
        source.name));
}

}  // namespace

void refuse_unknown_keys(const toml::table& document, std::string_view pattern, const SceneSource& source) {
  refuse_mistaken(document, pattern, source);
  if (const auto unknown = first_unknown(*source.schema, document, "", pattern))
    source.fail(unknown->node, unknown->path,
                fmt::format("is not a key of {}{}", source.schema->what_is(unknown->table),
                            remedy(*source.schema, *unknown)));
}

}  // namespace freeplay

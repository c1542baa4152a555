#include "study/store/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace freeplay {
namespace {

using namespace std::string_view_literals;

// Tables of sweeps (also without blobs), attractors and ensembles.
constexpr std::array tables{
    "runs"sv,    "turn_rows"sv,      "flight_rows"sv, "impact_rows"sv, "measure_rows"sv, "cost_rows"sv,
    "work"sv,    "spectrum_blobs"sv, "trace_blobs"sv, "sweeps"sv,      "derived"sv,      "turns"sv,
    "flights"sv, "impacts"sv,        "measures"sv,    "spectra"sv,     "traces"sv,       "costs"sv,
    "points"sv,  "ends"sv,           "numbers"sv,     "exponents"sv};
constexpr std::array views{"named"sv,    "turns"sv,   "flights"sv, "impacts"sv,
                           "measures"sv, "spectra"sv, "traces"sv,  "costs"sv};
constexpr std::array rows_of_runs{"turn_rows"sv, "flight_rows"sv,    "impact_rows"sv, "measure_rows"sv,
                                  "cost_rows"sv, "spectrum_blobs"sv, "trace_blobs"sv};
constexpr std::array types{"TEXT"sv, "REAL"sv, "INTEGER"sv, "BLOB"sv};
// Longer ones precede those that are their beginnings.
constexpr std::array constraints{" PRIMARY KEY REFERENCES runs(run) ON DELETE CASCADE"sv,
                                 " PRIMARY KEY REFERENCES runs(\"run id\") ON DELETE CASCADE"sv,
                                 " REFERENCES runs(run) ON DELETE CASCADE"sv,
                                 " REFERENCES runs(\"run id\") ON DELETE CASCADE"sv,
                                 " PRIMARY KEY"sv,
                                 " UNIQUE"sv};

bool is_word(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  return !text.empty() && letter(text[0]) &&
         std::ranges::all_of(text, [&](char c) { return letter(c) || (c >= '0' && c <= '9'); });
}

/// Parses a definition from its beginning, and composes the accepted pieces into the definition's
/// text.
class Parser {
 public:
  explicit Parser(std::string_view text) : rest_(text) {}
  bool take(std::string_view expected) {
    if (!rest_.starts_with(expected)) return false;
    rest_.remove_prefix(expected.size());
    composed_ += expected;
    return true;
  }
  template <class Words>
  bool take_one_of(const Words& words) {
    return std::ranges::any_of(words, [this](std::string_view word) { return take(word); });
  }
  /// Parses a name, or a quoted name; "" if there is none.
  std::string take_name() {
    std::size_t size = 0;
    if (rest_.starts_with('"')) {
      const auto end = rest_.find('"', 1);
      const auto inner = rest_.substr(1, end == rest_.npos ? 0 : end - 1);
      if (!inner.empty() &&
          std::ranges::none_of(inner, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        size = inner.size() + 2;
    } else {
      while (size < rest_.size() && is_word(rest_.substr(0, size + 1))) ++size;
    }
    const std::string name(rest_.substr(0, size));
    take(name);
    return name;
  }
  bool ended() const { return rest_.empty(); }
  const std::string& composed() const { return composed_; }

 private:
  std::string_view rest_;
  std::string composed_;
};

std::optional<Definition> own_table(const SchemaObject& object) {
  if (std::ranges::find(tables, object.name) == tables.end() || object.table != object.name) return {};
  Parser p(object.sql);
  if (!p.take(fmt::format("CREATE TABLE {} (", object.name))) return {};
  Definition made;
  do {
    made.columns.push_back(p.take_name());
    if (made.columns.back().empty() || !p.take(" ") || !p.take_one_of(types)) return {};
    p.take_one_of(constraints);
  } while (p.take(", "));
  if (!p.take(")")) return {};
  p.take(" WITHOUT ROWID");
  if (!p.ended()) return {};
  made.text = p.composed();
  return made;
}

std::optional<Definition> own_index(const SchemaObject& object) {
  constexpr std::array columns{"run"sv, "id"sv, "state"sv};
  if (std::ranges::find(tables, object.table) == tables.end()) return {};
  for (const auto column : columns)
    if (auto text = fmt::format("CREATE INDEX {0}_{1} ON {0}({1})", object.table, column);
        object.sql == text && object.name == fmt::format("{}_{}", object.table, column))
      return Definition{std::move(text), {}};
  return {};
}

std::optional<Definition> own_view(const SchemaObject& object) {
  if (std::ranges::find(views, object.name) == views.end() || object.table != object.name) return {};
  Parser p(object.sql);
  if (!p.take(fmt::format("CREATE VIEW {} AS SELECT ", object.name))) return {};
  do {
    if (p.take("runs.*")) continue;
    if (!p.take_one_of(std::array{"runs."sv, "many."sv, "derived."sv}) || p.take_name().empty()) return {};
    p.take(" AS run");
  } while (p.take(", "));
  if (!p.take(" FROM runs")) return {};
  if (p.take(" JOIN ")) {
    if (!p.take_one_of(rows_of_runs) || !p.take(" AS many ON many.id = runs.\"run id\"")) return {};
  } else {
    p.take(" LEFT JOIN derived ON derived.run = runs.run");
    p.take(" WHERE runs.run NOT IN (SELECT run FROM work WHERE state = 'kept')");
  }
  if (!p.ended()) return {};
  return Definition{p.composed(), {}};
}

}  // namespace

std::optional<Definition> own_definition(const SchemaObject& object) {
  if (object.type == "table") return own_table(object);
  if (object.type == "index") return own_index(object);
  if (object.type == "view") return own_view(object);
  return {};
}

}  // namespace freeplay

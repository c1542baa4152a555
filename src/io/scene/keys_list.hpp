// KeysList: the visitor that lists the keys of a document (mechanism/keys.hpp). It makes one row for
// each key, with type, unit, default and meaning; rows of kinds that share a key are merged.
// scene_schema(), study_schema() and style_schema() run it over all kinds of tables to make a
// schema. It owns the rows until schema().
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/scene/schema.hpp"
#include "mechanism/beam.hpp"
#include "mechanism/body.hpp"
#include "mechanism/configuration.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements.hpp"
#include "mechanism/group.hpp"
#include "mechanism/keys.hpp"
#include "mechanism/options.hpp"
#include "mechanism/surface.hpp"
#include "mechanism/tolerance.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// Visitor of the `keys()` functions that records each key; never reads or writes a value.
class KeysList {
 public:
  /// Begins a table, such as "bodies.*", with its description. `kinds`: the values of `type` that
  /// share the table.
  void open(std::string table, std::string what, std::vector<std::string> kinds = {}) {
    tables_.emplace_back(table, std::move(what));
    table_ = std::move(table);
    kinds_ = std::move(kinds);
    kind_.clear();
  }
  /// Lists a table that has one kind.
  template <class X>
  void facts(std::string table, std::string what) {
    open(std::move(table), std::move(what));
    X x;
    X::keys(*this, x);
    close();
  }
  void kind(std::string_view word) { kind_ = word; }
  /// Adds the key that selects a kind, as the first row of its table.
  template <class E>
  void kind_row(const char* fallback, const E& all) {
    plain({"type", "", ""}, "text", fallback, words_of(all));
  }
  /// Adds a row that is not merged with others.
  void plain(const Key& key, std::string type, std::string fallback, std::string meaning);
  /// Ends the keys that a group switches on; called after the last key of a kind.
  void leave_group() { group_.clear(); }
  /// Merges the rows that kinds of the open table share.
  void close();
  /// The schema of all rows. Their paths begin with `root`.
  Schema schema(std::string root) { return {std::move(root), std::move(rows_), std::move(tables_)}; }

  void need(const Key& key, auto& x, const Range& = any_number) {
    if constexpr (std::is_enum_v<std::decay_t<decltype(x)>>)
      add(key, "text", "required", std::string(key.meaning) + words_of(choices(x)));
    else
      add(key, type_of(x), "required");
  }
  void take(const Key& key, auto& x, const Range& = any_number) { add(key, type_of(x), shown(x)); }
  template <class E>
  void choose(const Key& key, E& x) {
    add(key, "text", fmt::format("\"{}\"", text_of(x)), std::string(key.meaning) + words_of(choices(x)));
  }
  template <class E>
  void choose(const Key& key, std::optional<E>&) {
    add(key, "text", "–", std::string(key.meaning) + words_of(choices(E{})));
  }
  void number_or(std::string_view word, const Key& key, std::optional<double>&, const Range&) {
    add(key, "number or text", fmt::format("\"{}\"", word));
  }
  void flag(const Key& key, bool& x) { take(key, x); }
  void deviation(const Key& key, double& x, const std::string&) { need(key, x); }
  void deviation(const Key& key, std::optional<double>& x, const std::string&) { take(key, x); }
  void choose_other(const Key& key, auto& x) { choose(key, x); }
  void choose_listed(const Key& key, auto& x) { add(key, "text", fmt::format("\"{}\"", text_of(x))); }
  void choose_some(const Key& key, auto&, const auto&) { add(key, "text", "–"); }
  auto* group(std::string_view name, auto& x) {
    group_ = name;
    return &x.emplace();
  }
  auto* given(std::string_view, auto& x) { return &x.emplace(); }
  /// Lists a subtable, or subtables with names of the author, between the rows of their table.
  template <class X>
  void part(const char* name, const char* what, std::optional<X>&) {
    inside<X>(fmt::format("{}.{}", table_, name), what);
  }
  template <class X>
  void tables(const char* name, const char* what, std::vector<X>&) {
    inside<X>(fmt::format("{}.{}.*", table_, name), what);
  }
  bool when(bool) const { return true; }
  bool when(bool, std::initializer_list<std::string_view>, const char*) const { return true; }
  /// Appends the choices that read the key to its meaning.
  template <class O>
  bool own(std::string_view name, const O& o) {
    const auto& row = own_key(o, name);
    only_ = fmt::format("; read with {}", row.belongs);
    return true;
  }
  bool when_given(std::string_view) const { return true; }
  void check(bool, std::string_view, const auto&...) const {}
  void names(const Key& key, std::vector<std::string>&) { add(key, "names", "[]"); }
  void rows(const Key& key, const auto&, auto&) { add(key, "numbers", "–"); }
  void texts(const Key& key, auto&) { add(key, "table", "–"); }
  void axis_of(const Key& key, std::size_t&, std::size_t) { add(key, "text", "required"); }
  void together(std::initializer_list<TypedKey> keys, auto&, const auto&) {
    for (const auto& [key, type] : keys) add(key, type, "–");
  }
  void other(const Key& key, const char* type, auto&, const auto&) { add(key, type, "–"); }
  void either(const Key& other, const Range&, double (*)(double), const Key& own, const Range&, auto&) {
    add(other, "number", "–");
    add(own, "number", "–");
  }
  void table(const Key& constant, const Key& points, TorqueDrive::Table&) {
    add(constant, "number", "–");
    add(points, "points or file", "–");
  }
  void samples(const Key& points, const Key& file, const Key& columns, Curve::Points&) {
    add(points, "points", "–");
    add(file, "text", "–");
    add(columns, "names", "the first two");
  }
  void curve(const Key& key, int&, Curve::Use = Curve::Use::value) { add(key, "text", "required"); }
  void maybe_curve(const Key& key, int&, Curve::Use = Curve::Use::value) { add(key, "text", "–"); }
  void moving_joint(const Key& key, int&) { add(key, "text", "required"); }
  void maybe_joint(const Key& key, int&) { add(key, "text", "–"); }
  template <class J>
  void maybe_joint_of(const Key& key, int&) {
    add(key, "text", "–");
  }
  void joint_place(const Key& key, double&, int) { add(key, "number", std::string(key.fallback)); }
  void number_or_curve(const Key& key, CurveOr&, const Range& = any_number, Curve::Use = Curve::Use::value) {
    add(key, "number or text", "required");
  }
  void pairs(const Key& key, TorqueDrive::Table&) { add(key, "points or file", "–"); }
  void places(const Key& list, const Key& grid, const Key& origin, const Key& spacing, const Key& stagger,
              std::vector<Vec2>&) {
    add(list, "points or file", "–");
    add(grid, "point", "–");
    add(origin, "point", "[0, 0]");
    add(spacing, "point", "required");
    add(stagger, "number", "0");
  }
  void way(const Key& key, std::vector<Vec2>&) { add(key, "points", "–"); }
  void groups(const Key& key, std::vector<int>&) { add(key, "name or names", "–"); }
  void maybe_surface(const Key& key, std::optional<int>&) { add(key, "text", std::string(key.fallback)); }
  void length(const Key& turns, const Key& seconds, double&) {
    add(turns, "number", "–");
    add(seconds, "number", "–");
  }
  void part_of_length(const Key& key, double&) { add(key, "number", "0"); }
  void between(std::string_view meaning, std::array<int, 2>&, bool = false) {
    add({"between", "", meaning}, "names", "required");
  }
  void ends(std::string_view meaning, std::array<Vec2, 2>&) {
    add({"at", "m", meaning}, "points or names", "[[0, 0], [0, 0]]");
  }
  void beam_length(const Key& key, Beam&) { add(key, "number", std::string(key.fallback)); }
  void points(const Key& key, std::string_view, std::vector<NamedPoint>&) { add(key, "table", "–"); }
  void point_of(const Key& key, int, Vec2& at) { add(key, "point or name", shown(at)); }
  void angles(const Key& key, std::vector<JointAngle>&) { add(key, "names", "–"); }
  void axis(std::string_view meaning, Vec2&) { add({"axis", "", meaning}, "point", "[1, 0]"); }
  void radii(const Key& key, std::array<double, 2>&) { add(key, "point", "required"); }
  void body(const Key& key, int&) { add(key, "text", "required"); }
  const Surface* surface(const Key& key, int&) {
    add(key, "text", "required");
    return nullptr;
  }
  void lubricant(const Key& key, int&, double, const std::optional<double>&) { add(key, "text", "–"); }
  void profile(const Key& key, int&) { add(key, "text", "–"); }
  void drive(const Key& key, std::string&) { add(key, "text", "required"); }
  template <class J>
  const J* joint(const Key& key, int&) {
    add(key, "text", "required");
    return nullptr;
  }
  template <class... Kinds>
  const Joint* joint_of(const Key& key, int&) {
    add(key, "text", "required");
    return nullptr;
  }
  void from_bodies(const Key& key, const std::optional<double>&) {
    add(key, "number", std::string(key.fallback));
  }
  void gauge(const Key& beam, const Key& place, const auto&) {
    add(beam, "text", "required");
    add(place, "number", "required");
  }
  void any_joint(const Key& key, int&, std::array<int, 2>&) { add(key, "text", "required"); }
  void ratio_offset(const Key& key, double&, int, int, double) {
    add(key, "number", std::string(key.fallback));
  }
  void coupled(int, int, const std::array<int, 2>&) const {}
  void grounded(int, int) const {}
  void joint_angle(const Key& key, double&, int) { add(key, "number", std::string(key.fallback)); }

 private:
  struct Entry {
    std::string name, type, unit, fallback, meaning, kind;
  };
  void add(const Key& key, std::string type, std::string fallback, std::string meaning = {});
  template <class X>
  void inside(std::string table, const char* what) {
    close();
    const auto outer = std::exchange(table_, {});
    facts<X>(std::move(table), what);
    table_ = outer;
  }

  static std::string type_of(double) { return "number"; }
  static std::string type_of(const std::optional<double>&) { return "number"; }
  static std::string type_of(const std::optional<Vec2>&) { return "point"; }
  static std::string type_of(std::integral auto) { return "number"; }
  static std::string type_of(const std::string&) { return "text"; }
  static std::string type_of(const std::filesystem::path&) { return "text"; }
  static std::string type_of(bool) { return "true or false"; }
  static std::string type_of(const Vec2&) { return "point"; }
  static std::string shown(double x);
  static std::string shown(const std::optional<double>&) { return "–"; }
  static std::string shown(const std::optional<Vec2>&) { return "–"; }
  static std::string shown(std::integral auto x) { return fmt::format("{}", x); }
  static std::string shown(const std::string& x) { return fmt::format("\"{}\"", x); }
  static std::string shown(const std::filesystem::path&) { return "–"; }
  static std::string shown(bool x) { return x ? "true" : "false"; }
  static std::string shown(const Vec2& x) { return fmt::format("[{}, {}]", x.x(), x.y()); }
  template <class Choices>
  static std::string words_of(const Choices& all) {
    std::string list;
    std::size_t i = 0;
    for (const auto& choice : all) {
      list += i == 0 ? "" : i + 1 == all.size() ? " or " : ", ";
      list += fmt::format("\"{}\"", choice.text);
      if (!choice.meaning.empty()) list += fmt::format(" ({})", choice.meaning);
      ++i;
    }
    return list;
  }

  std::string table_, kind_, group_, only_;
  std::vector<std::string> kinds_;
  std::vector<Entry> entries_;
  std::size_t begin_ = 0;  // first entry of the open table
  std::vector<SchemaKey> rows_;
  Schema::Tables tables_;
};

}  // namespace freeplay

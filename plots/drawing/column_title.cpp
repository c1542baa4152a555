#include "plots/drawing/column_title.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "io/scene/quantity.hpp"

namespace freeplay::plots {
namespace {

Script words_of(const ColumnQuantity& q) {
  Script script;
  script.add("'{}{}", q.mean ? Word("mean ") : Word(""), q.name);
  return script.add("{}{}'", *q.symbol.text() ? Word(" ") : Word(""), q.symbol);
}

std::size_t length_of(const ColumnQuantity& q) {
  return (q.mean ? 5 : 0) + letters(q.name.text()) + (*q.symbol.text() ? 1 + letters(q.symbol.text()) : 0);
}

/// What values of different columns with one unit have in common.
AxisTitle common_title(const std::string& si, const std::string& unit) {
  struct Common {
    std::string_view si;
    Word name;
  };
  constexpr Common quantities[] = {{"N", "force"},
                                   {"m", "length"},
                                   {"m/s", "velocity"},
                                   {"m/s2", "acceleration"},
                                   {"s", "time"},
                                   {"rad", "angle"},
                                   {"rad/s", "angular velocity"},
                                   {"rad/s2", "angular acceleration"},
                                   {"W", "power"},
                                   {"N m", "moment"},
                                   {"N s", "impulse"}};
  for (const auto& [of, name] : quantities)
    if (si == of || same_quantity(si, of)) return AxisTitle::of(name, unit);
  return {Script().add("''"), 0, unit};
}

/// Title of an axis of an expression: the magnitude of a vector by its symbol, others as written,
/// with a point for the product.
AxisTitle title_of_expression(const std::string& text, const std::string& unit) {
  struct Magnitude {
    std::string_view x, y;
    Word quantity;
  };
  constexpr Magnitude known[] = {{".fx", ".fy", {"force |F|", "force $|F|$"}},
                                 {".ex", ".ey", {"eccentricity e", "eccentricity $e$"}},
                                 {".vx", ".vy", {"speed v", "speed $v$"}},
                                 {".ax", ".ay", {"acceleration |a|", "acceleration $|a|$"}}};
  std::string plain;
  for (const char c : text)
    if (c != ' ') plain += c;
  for (const auto& [x, y, quantity] : known) {
    const auto end = plain.find(x);
    if (!plain.starts_with("hypot(") || end == plain.npos) continue;
    const auto element = plain.substr(6, end - 6);
    if (plain == fmt::format("hypot({0}{1},{0}{2})", element, x, y))
      return AxisTitle::of(element, Script().add("'{}'", quantity), letters(quantity.text()), unit);
  }
  std::string shown;
  for (const char c : plain) {
    if (c == '*')
      shown += " · ";
    else if (c == ',')
      shown += ", ";
    else
      shown += c;
  }
  return AxisTitle::plain(shown, unit);
}

}  // namespace

AxisTitle title_of(const std::vector<ColumnFormula>& formulas, const std::string& unit) {
  const auto& first = formulas.front();
  if (formulas.size() == 1 && first.expression) return title_of_expression(first.text, unit);
  const auto same = [&](auto key) {
    return std::ranges::all_of(formulas, [&](const ColumnFormula& f) {
      return !f.expression && key(f.columns[0].quantity) == key(first.columns[0].quantity);
    });
  };
  const auto name = [](const ColumnQuantity& q) { return std::string_view(q.name.text()); };
  const auto symbol = [](const ColumnQuantity& q) { return std::string_view(q.symbol.text()); };
  if (first.expression || !same(name)) return common_title(first.unit, unit);
  auto q = first.columns[0].quantity;
  if (!same(symbol)) q.symbol = "";
  if (name(q).empty()) return AxisTitle::plain(first.text, unit);
  const auto element = first.columns[0].element();
  if (formulas.size() > 1 || element.empty()) return {words_of(q), length_of(q), unit};
  return AxisTitle::of(element, words_of(q), length_of(q), unit);
}

AxisTitle title_of_column(const std::string& column, const std::string& unit) {
  return title_of(
      {{.text = column, .unit = "", .columns = {{column, "", "", "", quantity_of_column(column, unit)}}}},
      unit);
}

AxisTitle title_of_number(const std::string& path, const std::string& unit) {
  if (*quantity_of_column(path).name.text()) return title_of_column(path, unit);
  const auto number = number_of_run(path);
  return AxisTitle::plain((number.element.empty() ? "" : number.element + ": ") + number.words, unit);
}

}  // namespace freeplay::plots

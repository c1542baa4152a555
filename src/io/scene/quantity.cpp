#include "io/scene/quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "io/files/escaping.hpp"
#include "io/scene/toml_text.hpp"

namespace freeplay {
namespace {

constexpr double pi = std::numbers::pi;

constexpr NamedUnit units[] = {
    {"m", "", 0, 1, 1, true},
    {"g", "", -3, 1, 1, true},  // the base unit is kg
    {"s", "", 0, 1, 1, true},
    {"rad", "", 0, 1, 1, true},
    {"A", "", 0, 1, 1, true},
    {"N", "kg m/s2", 0, 1, 1, true},
    {"Pa", "N/m2", 0, 1, 1, true},
    {"J", "N m", 0, 1, 1, true},
    {"W", "J/s", 0, 1, 1, true},
    {"Nm", "N m", 0, 1, 1, true},
    {"Nmm", "N mm"},
    {"Ns", "N s"},
    {"Hz", "1/s", 0, 1, 1, true},
    {"V", "W/A", 0, 1, 1, true},
    {"ohm", "V/A", 0, 1, 1, true},
    {"Ω", "V/A", 0, 1, 1, true},
    {"H", "V s/A", 0, 1, 1, true},
    {"%", "1", -2},
    {"deg", "rad", 0, pi, 180},
    {"°", "rad", 0, pi, 180},
    {"degree", "rad", 0, pi, 180},
    {"degrees", "rad", 0, pi, 180},
    {"rev", "rad", 0, 2 * pi},
    {"turn", "rad", 0, 2 * pi},
    {"turns", "rad", 0, 2 * pi},
    {"rpm", "rad/s", 0, 2 * pi, 60},
    {"RPM", "rad/s", 0, 2 * pi, 60},
    {"rps", "rad/s", 0, 2 * pi},
    {"min", "s", 0, 60},
    {"h", "s", 2, 36},
    {"t", "kg", 3},
    {"bar", "Pa", 5, 1, 1, true},
    {"P", "Pa s", -1, 1, 1, true},
    {"micron", "m", -6},
    {"in", "m", -4, 254},
    {"inch", "m", -4, 254},
    {"mil", "m", -7, 254},
    {"thou", "m", -7, 254},
    {"ft", "m", -4, 3048},
    {"lb", "kg", -8, 45359237},
    {"lbm", "kg", -8, 45359237},
    {"oz", "kg", -8, 45359237, 16},
    {"lbf", "N", -13, 44482216152605},
    {"slug", "lbf s2/ft"},
    {"psi", "lbf/in2"},
    {"kgf", "N", -5, 980665},
};

/// Names of dimensions in messages, by unit.
constexpr std::pair<std::string_view, std::string_view> quantities[] = {
    {"", "a pure number"},
    {"m", "a length"},
    {"m2", "an area"},
    {"m3", "a volume"},
    {"m4", "a second moment of area"},
    {"kg", "a mass"},
    {"kg/m3", "a density"},
    {"s", "a time"},
    {"rad", "an angle"},
    {"1/s", "a frequency"},
    {"m/s", "a speed"},
    {"m/s2", "an acceleration"},
    {"rad/s", "an angular velocity"},
    {"rad/s2", "an angular acceleration"},
    {"kg m2", "a moment of inertia"},
    {"kg m/s", "an impulse"},
    {"N", "a force"},
    {"N m", "a torque or an energy"},
    {"N m2", "a bending stiffness"},
    {"W", "a power"},
    {"N/m", "a stiffness"},
    {"N m/rad", "a torsional stiffness"},
    {"N s/m", "a damping"},
    {"N m s/rad", "a torsional damping"},
    {"Pa", "a pressure"},
    {"Pa s", "a viscosity"},
    {"s/m", "the inverse of a speed"},
    {"1/m", "the inverse of a length"},
    {"m/rad", "a length per radian"},
    {"m2/N", "a wear coefficient"},
    {"A", "a current"},
    {"V", "a voltage"},
    {"ohm", "a resistance"},
    {"H", "an inductance"},
    {"N m/A", "a torque per current"},
    {"V s/rad", "a voltage per angular velocity"},
};

constexpr std::pair<std::string_view, int> prefixes[] = {{"p", -12}, {"n", -9}, {"µ", -6}, {"μ", -6},
                                                         {"u", -6},  {"m", -3}, {"c", -2}, {"d", -1},
                                                         {"k", 3},   {"M", 6},  {"G", 9},  {"T", 12}};

/// A unit: kg^p0 m^p1 s^p2 rad^p3 A^p4 · 10^decimal · a/b.
struct Unit {
  std::array<int, 5> powers{};
  int decimal = 0;
  double a = 1, b = 1;

  void times(const Unit& other, int power) {
    for (std::size_t i = 0; i < powers.size(); ++i) powers[i] += power * other.powers[i];
    decimal += power * other.decimal;
    for (int i = 0; i < std::abs(power); ++i) {
      a *= power > 0 ? other.a : other.b;
      b *= power > 0 ? other.b : other.a;
    }
  }
};

std::optional<Unit> parse(std::string_view text, std::string& unknown);
int power(std::string_view& text);

/// Index of a base unit in Unit::powers.
std::size_t base_of(std::string_view symbol) {
  constexpr std::string_view symbols[] = {"g", "m", "s", "rad", "A"};
  return static_cast<std::size_t>(std::ranges::find(symbols, symbol) - std::begin(symbols));
}

std::optional<Unit> factor(std::string_view symbol) {
  Unit u;
  std::string unknown;
  for (const auto& named : units) {
    int shift = 0;
    const bool prefixed = named.prefixes && symbol.ends_with(named.symbol) &&
                          std::ranges::any_of(prefixes, [&](const auto& prefix) {
                            shift = prefix.second;
                            return symbol.substr(0, symbol.size() - named.symbol.size()) == prefix.first;
                          });
    if (named.symbol != symbol && !prefixed) continue;
    if (named.means.empty())
      u.powers[base_of(named.symbol)] = 1;
    else
      u = *parse(named.means, unknown);
    u.decimal += named.decimal + (prefixed ? shift : 0);
    u.a *= named.a;
    u.b *= named.b;
    return u;
  }
  return std::nullopt;
}

constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ%";

/// Removes `piece` from the beginning of the text; false if the text does not begin with it.
bool take(std::string_view& text, std::string_view piece) {
  if (!text.starts_with(piece)) return false;
  text.remove_prefix(piece.size());
  return true;
}

/// Whether a hyphen at the beginning of the text joins two symbols, as in N-m; in s-1 it is a sign.
bool joins(std::string_view text) {
  return text.size() > 1 && text.front() == '-' && letters.find(text[1]) != letters.npos;
}

/// In units with a hyphen such as lb-in and ft-lb, pounds and ounces are forces; with a power, as in lb-in2,
/// they are masses. Returns the force and removes these symbols, or returns nothing.
std::optional<Unit> take_hyphenated_force(std::string_view& text) {
  for (const std::string_view mass : {"lb", "oz"})
    for (const std::string_view length : {"in", "inch", "ft"})
      for (const bool mass_first : {true, false}) {
        auto rest = text;
        if (!take(rest, mass_first ? mass : length) || !take(rest, "-") ||
            !take(rest, mass_first ? length : mass))
          continue;
        auto after = rest;
        const bool ends = rest.empty() || letters.find(rest.front()) == letters.npos;
        if (!ends || (mass_first && power(after) != 1)) continue;
        text = rest;
        Unit force = *factor(mass);
        force.times(*factor("lbf"), 1);
        force.times(*factor("lb"), -1);
        force.times(*factor(length), 1);
        return force;
      }
  return std::nullopt;
}

/// Reads the power after a symbol: 2, ^2, ², -1, ⁻¹. 1 if there is none, 0 if it is invalid.
int power(std::string_view& text) {
  if (joins(text)) return 1;
  constexpr std::pair<std::string_view, int> digits[] = {{"1", 1}, {"2", 2}, {"3", 3}, {"4", 4},
                                                         {"¹", 1}, {"²", 2}, {"³", 3}, {"⁴", 4}};
  const bool caret = take(text, "^");
  const bool negative = take(text, "-") || take(text, "−") || take(text, "⁻");
  for (const auto& [digit, value] : digits)
    if (take(text, digit)) return negative ? -value : value;
  return caret || negative ? 0 : 1;
}

std::optional<Unit> parse(std::string_view text, std::string& unknown) {
  Unit unit;
  const auto bad = [&](std::string_view what) {
    unknown = what;
    return std::nullopt;
  };
  if (take(text, "1") && !text.empty() && text.front() != '/' && text.front() != ' ') return bad("1");
  bool divides = false, wanting = false, any = false;
  while (!text.empty()) {
    if (take(text, " ") || take(text, "·") || take(text, "*")) continue;
    if (take(text, "/")) {
      if (divides) return bad("/");
      divides = wanting = true;
      continue;
    }
    if (any && !wanting && joins(text)) text.remove_prefix(1);
    any = true;
    if (const auto force = take_hyphenated_force(text)) {
      unit.times(*force, divides ? -1 : 1);
      divides = wanting = false;
      continue;
    }
    std::size_t end = 0;
    while (end < text.size()) {
      const auto rest = text.substr(end);
      if (letters.find(rest.front()) != letters.npos)
        ++end;
      else if (rest.starts_with("µ") || rest.starts_with("μ") || rest.starts_with("°") ||
               rest.starts_with("Ω"))
        end += 2;
      else
        break;
    }
    const auto symbol = text.substr(0, end);
    const auto one = factor(symbol);
    if (symbol.empty() || !one) return bad(symbol.empty() ? text : symbol);
    text.remove_prefix(end);
    const int p = power(text);
    if (p == 0) return bad(symbol);
    unit.times(*one, divides ? -p : p);
    divides = wanting = false;
  }
  if (wanting) return bad("/");
  for (const int p : unit.powers)
    if (std::abs(p) > 12) return bad("power");
  return unit;
}

/// Length of the number at the beginning of a text: sign, digits with a point, exponent.
std::size_t number_length(std::string_view text) {
  std::size_t i = 0, digits = 0;
  const auto run = [&] {
    while (i < text.size() && text[i] >= '0' && text[i] <= '9') ++i, ++digits;
  };
  if (i < text.size() && (text[i] == '-' || text[i] == '+')) ++i;
  run();
  if (i < text.size() && text[i] == '.') ++i, run();
  if (digits == 0) return 0;
  if (i + 1 < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    auto j = i + 1;
    if (text[j] == '-' || text[j] == '+') ++j;
    if (j < text.size() && text[j] >= '0' && text[j] <= '9') {
      while (j < text.size() && text[j] >= '0' && text[j] <= '9') ++j;
      i = j;
    }
  }
  return i;
}

/// The number times 10^shift, rounded once. Exponents beyond the range of a double are limited, so
/// that an int does not overflow.
double shifted(std::string_view number, int shift) {
  const auto e = number.find_first_of("eE");
  const std::string mantissa(number.substr(0, e));
  long exponent = e == number.npos ? 0 : std::strtol(std::string(number.substr(e + 1)).c_str(), nullptr, 10);
  exponent = std::clamp(exponent, -100000L, 100000L) + shift;
  return std::strtod(fmt::format("{}e{}", mantissa, exponent).c_str(), nullptr);
}

/// Text of a unit in base units, "kg m^2".
std::string spelt_of(const Unit& unit) {
  std::string spelt;
  constexpr std::string_view base[] = {"kg", "m", "s", "rad", "A"};
  for (std::size_t i = 0; i < unit.powers.size(); ++i)
    if (const int p = unit.powers[i]; p != 0)
      spelt += fmt::format("{}{}{}", spelt.empty() ? "" : " ", base[i], p == 1 ? "" : fmt::format("^{}", p));
  return spelt;
}

std::string name_of(const Unit& unit) {
  std::string unknown;
  for (const auto& [symbol, name] : quantities)
    if (parse(symbol, unknown)->powers == unit.powers) return std::string(name);
  return "a quantity in " + spelt_of(unit);
}

}  // namespace

std::span<const NamedUnit> named_units() { return units; }

std::string row_of(const NamedUnit& unit) {
  std::string unknown;
  const auto u = *factor(unit.symbol);
  const auto base = std::ranges::find_if(
      quantities, [&](const auto& q) { return parse(q.first, unknown)->powers == u.powers; });
  const auto in = base == std::end(quantities) ? std::string_view("") : base->first;
  return fmt::format("| {} | {} | {:.10g} {} | {} |\n", unit.symbol, name_of(u),
                     u.a / u.b * std::pow(10.0, u.decimal), in, unit.prefixes ? "yes" : "");
}

bool begins_with_number(std::string_view text) { return number_length(text) > 0; }

std::string quantity_name(std::string_view unit) {
  std::string unknown;
  const auto u = parse(unit, unknown);
  return u ? name_of(*u) : "";
}

bool same_quantity(std::string_view a, std::string_view b) {
  std::string unknown;
  const auto one = parse(a, unknown), other = parse(b, unknown);
  return one && other && one->powers == other->powers;
}

std::optional<Dimension> dimension_of(std::string_view unit) {
  std::string unknown;
  const auto u = parse(unit, unknown);
  if (!u) return std::nullopt;
  Dimension dimension;
  std::ranges::copy(u->powers, dimension.begin());
  return dimension;
}

std::string si_unit(const Dimension& dimension) {
  for (const auto& [symbol, name] : quantities)
    if (dimension_of(symbol) == dimension) return std::string(symbol);
  std::string spelt;
  constexpr std::string_view base[] = {"kg", "m", "s", "rad", "A"};
  for (std::size_t i = 0; i < dimension.size(); ++i)
    if (const double p = dimension[i]; p != 0)
      spelt +=
          fmt::format("{}{}{}", spelt.empty() ? "" : " ", base[i], p == 1 ? "" : fmt::format("^{:g}", p));
  return spelt;
}

std::string name_of(const Dimension& dimension) {
  const auto unit = si_unit(dimension);
  for (const auto& [symbol, name] : quantities)
    if (symbol == unit) return unit.empty() ? std::string(name) : fmt::format("{} ({})", name, unit);
  return "a quantity in " + unit;
}

Quantity read_any_quantity(std::string_view text) {
  auto own = text.substr(number_length(text));
  while (own.starts_with(' ')) own.remove_prefix(1);
  std::string unknown;
  const auto given = parse(own, unknown);
  if (own.empty() || !given)
    return {0, fmt::format("{}: {}", toml_quoted(visible_brief(text, 60)),
                           own.empty() ? "has no unit; remove the quotes"
                                       : toml_quoted(visible_brief(unknown, 40)) + " is not a known unit")};
  auto quantity = read_quantity(text, spelt_of(*given));
  quantity.unit = spelt_of(*given);
  return quantity;
}

Quantity read_quantity(std::string_view text, std::string_view unit) {
  const auto length = number_length(text);
  const auto number = text.substr(0, length);
  auto own = text.substr(length);
  while (own.starts_with(' ')) own.remove_prefix(1);
  std::string unknown;
  const auto quoted = toml_quoted(visible_brief(text, 60));
  const auto wanted = parse(unit, unknown);
  if (!wanted) return {0, fmt::format("{}: must be a number without a unit here (in {})", quoted, unit)};
  const auto want = fmt::format("must be {}{}", name_of(*wanted),
                                unit.empty() ? "" : fmt::format(" (a number without a unit is in {})", unit));
  if (own.empty() && !unit.empty())
    return {0, fmt::format("must be a number, is a text: {} has no unit; {}", quoted, want)};
  if (own.empty()) return {0, fmt::format("must be a number, is a text: {}; remove the quotes", quoted)};
  const auto given = parse(own, unknown);
  if (!given)
    return {0, fmt::format("{}: {} is not a known unit; {}", quoted, toml_quoted(visible_brief(unknown, 40)),
                           want)};
  if (given->powers != wanted->powers) return {0, fmt::format("{} is {}, {}", quoted, name_of(*given), want)};
  const int shift = given->decimal - wanted->decimal;
  if (given->a == wanted->a && given->b == wanted->b) return {shifted(number, shift)};
  double x = shifted(number, 0);
  if (given->a != 1) x *= given->a;
  if (given->b != 1) x /= given->b;
  if (wanted->b != 1) x *= wanted->b;
  if (wanted->a != 1) x /= wanted->a;
  const double power = std::pow(10.0, std::abs(shift));  // exact to 10^22
  return {shift < 0 ? x / power : x * power};
}

}  // namespace freeplay

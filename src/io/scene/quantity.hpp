// Numbers with a unit as text, "0.1 mm" or "5 kg cm2", read in the unit of a key:
//
//     x [U] = x · 10^d · (a/b) [K],     d, a, b from U over K,
//
// with the power of ten put into the digits before they are read, so that "0.1 mm" is the double 1e-4 and not a product
// that rounds to its neighbour. A unit is made of factors with powers, N m, kg·cm², m/s2, rad s^-1; a / governs the one
// factor behind it. SI prefixes p to T stand before those units that take them. A radian counts as a dimension of its own:
// a torsional stiffness in N m is refused, and so is a speed of turning in Hz.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace freeplay {

/// A unit that a text may use.
struct NamedUnit {
  std::string_view symbol;
  std::string_view means;  ///< in units that stand before it, or "" for a base unit
  int decimal = 0;         ///< it is a/b · 10^decimal of `means`
  double a = 1, b = 1;
  bool prefixes = false;  ///< whether k, m, µ … may stand before it
};
std::span<const NamedUnit> named_units();
/// As docs/reference/scene.md shows it.
std::string row_of(const NamedUnit& unit);

struct Quantity {
  double value = 0;
  /// Why there is no value: `"0.1 kg" is a mass, a length is wanted (m)`. Empty when there is one.
  std::string wrong = {};
  /// Of read_any_quantity: what the value is in, of base units, "kg m s^-2".
  std::string unit = {};
};
/// What `text` amounts to in `unit`, as keys spell it.
Quantity read_quantity(std::string_view text, std::string_view unit);

/// What it amounts to in SI, whatever it is.
Quantity read_any_quantity(std::string_view text);
/// Whether two units are of the same dimension.
bool same_quantity(std::string_view a, std::string_view b);

/// Whether a text begins as a number does.
bool begins_with_number(std::string_view text);

/// "a length" for "m"; empty for what is no unit.
std::string quantity_name(std::string_view unit);

}  // namespace freeplay

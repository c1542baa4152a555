// Numbers with a unit in text, such as "0.1 mm" or "5 kg cm2", converted to the unit of a key:
//
//     x [U] = x · 10^d · (a/b) [K],     d, a, b from U over K.
//
// The power of ten is merged into the digits before they are read, so that "0.1 mm" is the double
// nearest to 1e-4; a product could round to its neighbour. A unit is a product of symbols with
// powers: N m, kg·cm², m/s2, rad s^-1; a "/" applies to the next symbol only. Symbols that permit
// it take the SI prefixes p to T. The radian is a dimension of its own, so a torsional stiffness in
// N m is refused, and so is an angular velocity in Hz. The functions keep no state.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace freeplay {

// Dimensions of units as powers of kg, m, s, rad and A, for arithmetic with quantities. The radian
// is a base unit here, as in scenes.

/// Powers of kg, m, s, rad and A. A root makes fractions.
using Dimension = std::array<double, 5>;

/// Dimension of a unit in the spelling of scenes; empty for an unknown unit.
std::optional<Dimension> dimension_of(std::string_view unit);
/// SI unit of a dimension as it is usually written, "N" for kg m s^-2; "" for a pure number.
std::string si_unit(const Dimension& dimension);
/// Name of a dimension for messages, "a force (N)".
std::string name_of(const Dimension& dimension);

/// A unit symbol that a text may use.
struct NamedUnit {
  std::string_view symbol;
  std::string_view means;  ///< value in units that precede it in the list; "" for a base unit
  int decimal = 0;         ///< the unit is a/b · 10^decimal of `means`
  double a = 1, b = 1;
  bool prefixes = false;  ///< whether a prefix (k, m, µ …) is permitted
};
/// All unit symbols.
std::span<const NamedUnit> named_units();
/// The row of a unit in docs/reference/scene.md.
std::string row_of(const NamedUnit& unit);

/// Result of reading a number with a unit.
struct Quantity {
  double value = 0;
  /// Why there is no value: `"0.1 kg" is a mass, must be a length (m)`. Empty when there is one.
  std::string wrong = {};
  /// Set by read_any_quantity: SI unit of the value in base units, such as "kg m s^-2".
  std::string unit = {};
};
/// Reads `text` and converts it to `unit`, a unit in the spelling of keys.
Quantity read_quantity(std::string_view text, std::string_view unit);

/// Reads `text` and converts it to SI, whatever its dimension.
Quantity read_any_quantity(std::string_view text);
/// Whether two units have the same dimension.
bool same_quantity(std::string_view a, std::string_view b);

/// Whether a text begins like a number.
bool begins_with_number(std::string_view text);

/// Name of a unit's dimension for messages, "a length" for "m"; empty for an invalid unit.
std::string quantity_name(std::string_view unit);

}  // namespace freeplay

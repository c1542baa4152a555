// Bounds on numbers by unit. The reader refuses numbers outside them, because results would be
// meaningless: sums lose small terms to rounding, squares overflow, files grow without limit.
// Numbers within the bounds are checked for plausibility in mechanism/plausibility.hpp.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mechanism/keys.hpp"

namespace freeplay {

struct Magnitude {
  /// As spelt in keys; "": a pure number, or one in another channel's unit.
  std::string_view unit;
  double least = 0;        ///< lower bound of numbers that must be positive
  double greatest = 0;     ///< upper bound of |x|
  std::string_view why{};  ///< reason of the bounds
};

/// Of what follows from masses, lengths and times, in whatever units those are thought of.
inline constexpr std::string_view beyond = "products of larger numbers leave the range of a double";

inline constexpr std::array magnitudes{
    Magnitude{"", 0, 1e15, "the digits of a double end there"},
    Magnitude{
        "m", 1e-18, 1e9,
        "a thousandth of an atom's nucleus; at 1e9 m a coordinate is rounded to 1e-7 m, which no clearance "
        "bears"},
    Magnitude{"rad", 0, 1e9, "there an angle is rounded to 1e-7 rad"},
    Magnitude{"m or rad", 0, 1e9, "as lengths and angles"},
    Magnitude{"degrees", 0, 1e9, "as angles in rad"},
    Magnitude{"s", 1e-18, 1e9,
              "light crosses less than 1e-9 m in 1e-18 s; in 1e9 s, 30 years, time is rounded to 1e-7 s"},
    Magnitude{"Hz", 1e-9, 1e9, "once in 30 years; in 1e-9 s sound in steel goes 6e-6 m"},
    Magnitude{"1/s", 0, 1e15, "faster than atoms move"},
    Magnitude{"m/s", 0, 299792458, "the speed of light"},
    Magnitude{"rad/s", 0, 1e12, "a point at 0.3 mm would pass light"},
    Magnitude{"rpm", 0, 1e13, "a point at 0.3 mm would pass light"},
    Magnitude{"m/s²", 0, 1e16, "a neutron star's gravity is 2e12 m/s²"},
    Magnitude{"kg", 1e-40, 1e40, beyond},
    Magnitude{"kg m²", 1e-76, 1e58, "the least mass and length, and the greatest"},
    Magnitude{"m²", 1e-36, 1e18, "the least length and the greatest"},
    Magnitude{"m²/N", 0, 1, "sliding for 1 m under 1 Pa would wear 1 m"},
    Magnitude{"m⁴", 1e-72, 1e36, "the least length and the greatest"},
    Magnitude{"kg/m³", 1e-30, 1e20, "a neutron star has 1e18 kg/m³"},
    Magnitude{"N m²", 0, 1e45, beyond},
    Magnitude{"N", 0, 1e45, beyond},
    Magnitude{"N m", 0, 1e45, beyond},
    Magnitude{"N/m", 0, 1e45, beyond},
    Magnitude{"N/m or N m/rad", 0, 1e45, beyond},
    Magnitude{"N s/m", 0, 1e45, beyond},
    Magnitude{"N s/m or N m s/rad", 0, 1e45, beyond},
    Magnitude{"Pa", 1e-45, 1e45, beyond},
    Magnitude{"Pa s", 1e-45, 1e45, beyond},
    Magnitude{"s/m", 0, 1e15, "friction that changes within 1e-15 m/s"},
    Magnitude{"1/m", 0, 1e18, "bristles shorter than a thousandth of an atom's nucleus"},
    Magnitude{"s or rad, N m", 0, 1e45, "as torques"},
    Magnitude{"V", 0, 1e45, beyond},
    Magnitude{"ohm", 1e-30, 1e30, beyond},
    Magnitude{"H", 1e-30, 1e30, beyond},
    Magnitude{"N m/A", 1e-30, 1e30, beyond},
    Magnitude{"V s/rad", 1e-30, 1e30, beyond},
    Magnitude{"N m s/rad", 0, 1e45, beyond},
    Magnitude{"N m/rad", 0, 1e45, beyond},
    Magnitude{"N m s/rad or N m/rad or N/m", 0, 1e45, beyond},
    Magnitude{"N m/rad or N m/rad s or N/m s", 0, 1e45, beyond},
    Magnitude{"N m s/rad or N s/m", 0, 1e45, beyond},
    Magnitude{"rad or m", 0, 1e9, "as angles and lengths"},
    Magnitude{"rad/rad or m/rad", 0, 1e9, "as angles and lengths"},
    Magnitude{"of x", 0, 1e15, "as times, angles and speeds"},
    Magnitude{"of y", 0, 1e45, beyond},
    Magnitude{"x and y", 0, 1e45, beyond},
    Magnitude{"m, N", 0, 1e45, "as forces"},
    Magnitude{"rad, N m", 0, 1e45, "as torques"},
    Magnitude{"m/s, N or rad/s, N m", 0, 1e45, "as forces"},
    Magnitude{"m/s or rad/s", 0, 299792458, "as speeds"},
    Magnitude{"m/s, –", 0, 299792458, "as speeds"},
    Magnitude{"N or N m", 0, 1e45, beyond},
    Magnitude{"N/m³ or N m/rad³", 0, 1e45, beyond},
    Magnitude{"rad, m", 0, 1e9, "as angles"},
    Magnitude{"as the length", 0, 1e15, "as the length of the run"},
    Magnitude{"of the channel", 0, 1e45, beyond},
};

/// The row of a unit, or nullptr.
constexpr const Magnitude* magnitude_of(std::string_view unit) {
  for (const auto& m : magnitudes)
    if (m.unit == unit) return &m;
  return nullptr;
}

/// Why a number is outside the bounds, for messages; empty if it is inside. `bounds` may be null.
std::string beyond_bounds(const Magnitude* bounds, double x, bool greater_than_zero,
                          const std::string& stated = "");
/// Why a number is not finite, not in its range or outside the bounds; empty if it is valid. `stated`:
/// the number as the author wrote it, with its unit; empty: in SI.
std::string wrong_number(double x, const Range& range, const Magnitude* bounds,
                         const std::string& stated = "");

/// The row of docs/reference/scene.md.
std::string row_of(const Magnitude& m);

}  // namespace freeplay

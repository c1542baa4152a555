// What a number of each unit may amount to. Far beyond, a result says nothing of a mechanism: sums lose what they are
// made of to rounding, squares overflow, a file grows without end. Questions within these bounds are asked in
// model/sense.hpp.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace freeplay {

struct Magnitude {
  std::string_view unit;   ///< as keys spell it; "": a pure number, or one of another channel's unit
  double least = 0;        ///< of what must be greater than 0
  double greatest = 0;     ///< of |x|
  std::string_view why{};  ///< the reason of the bounds
};

inline constexpr std::array magnitudes{
    Magnitude{"", 0, 1e15, "the digits of a double end there"},
    Magnitude{
        "m", 1e-18, 1e9,
        "a thousandth of an atom's nucleus; at 1e9 m a coordinate is rounded to 1e-7 m, which no clearance bears"},
    Magnitude{"rad", 0, 1e9, "there an angle is rounded to 1e-7 rad"},
    Magnitude{"degrees", 0, 1e9, "as angles in rad"},
    Magnitude{"s", 1e-18, 1e9,
              "light crosses less than 1e-9 m in 1e-18 s; in 1e9 s, 30 years, time is rounded to 1e-7 s"},
    Magnitude{"Hz", 1e-9, 1e9, "once in 30 years; in 1e-9 s sound in steel goes 6e-6 m"},
    Magnitude{"1/s", 0, 1e15, "faster than atoms move"},
    Magnitude{"m/s", 0, 299792458, "the speed of light"},
    Magnitude{"rad/s", 0, 1e12, "a point at 0.3 mm would pass light"},
    Magnitude{"rpm", 0, 1e13, "a point at 0.3 mm would pass light"},
    Magnitude{"m/s²", 0, 1e16, "a neutron star's gravity is 2e12 m/s²"},
    Magnitude{"kg", 1e-30, 1e30, "an electron; half the sun"},
    Magnitude{"kg m²", 1e-66, 1e48, "the least mass and length, and the greatest"},
    Magnitude{"N", 0, 1e21, "the earth and the moon pull each other by 2e20 N"},
    Magnitude{"N m", 0, 1e24, "the greatest force on an arm of 1 km"},
    Magnitude{"N/m", 0, 1e30, "the greatest force over 1 nm"},
    Magnitude{"N/m or N m/rad", 0, 1e30, "the greatest force over 1 nm"},
    Magnitude{"N s/m", 0, 1e30, "the greatest force at 1 nm/s"},
    Magnitude{"N s/m or N m s/rad", 0, 1e30, "the greatest force at 1 nm/s"},
    Magnitude{"Pa", 1e-30, 1e30,
              "diamond has 1.2e12 Pa; stiffer than 1e30 a contact is rigid to the digits of a double"},
    Magnitude{"Pa s", 1e-30, 1e18, "air has 2e-5 Pa s; thicker than 1e18 is a solid"},
    Magnitude{"s/m", 0, 1e15, "friction that changes within 1e-15 m/s"},
    Magnitude{"1/m", 0, 1e18, "bristles shorter than a thousandth of an atom's nucleus"},
    Magnitude{"s or rad, N m", 0, 1e24, "as torques"},
    Magnitude{"as the length", 0, 1e15, "as the length of the run"},
    Magnitude{"of the channel", 0, 1e24, "beyond every quantity that a channel shows"},
};

/// The row of a unit, or nullptr.
constexpr const Magnitude* magnitude_of(std::string_view unit) {
  for (const auto& m : magnitudes)
    if (m.unit == unit) return &m;
  return nullptr;
}

/// As docs/scene.md shows it.
std::string row_of(const Magnitude& m);

}  // namespace freeplay

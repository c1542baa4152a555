// A beam: a flexible link between two bodies, declared once by material, section and ends.
//
// It is divided into equal pieces of length l. Each is a body NAME-1, NAME-2, … of mass ρAl and moment of inertia
// ρAl³/12 + ρIl at its middle; beam elements (elements/beam_element.hpp) NAME-1, NAME-2, … connect the middles, and half
// elements the outer ones with the ends on both bodies. A free end has no element: the outer half of its piece is rigid.
// Stiffness of small deflections is therefore exact for forces and couples at fastened ends and middles, masses are
// those of the midpoint rule: errors of frequencies are of second order in l. The bodies at the ends keep their mass.
//
// With `modes` the beam is reduced (Craig and Bampton, AIAA Journal 6 (1968) 1313): one element connects its ends, and
// the pieces lie on its static deflection and that many modes of the beam clamped at both ends (dynamics/
// beam_reduction.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mechanism/body.hpp"
#include "mechanism/elements/beam_element.hpp"

namespace freeplay {

/// In place of a body: an end of a beam that is fastened to nothing.
inline constexpr int free_end = -2;

/// Numbers of pieces of a beam.
inline constexpr Range beam_pieces{[](double n) { return n >= 1 && n <= 1000 && n == static_cast<int>(n); },
                                   "a whole number from 1 to 1000"};

/// Greatest number of pieces of a reduced beam: its constraint rows are dense.
inline constexpr int most_reduced = 64;

/// A flexible link between two bodies.
struct Beam {
  /// Shape of the section. `given`: area and second moment are stated.
  enum class Section { given, rectangle, circle, tube };
  static constexpr std::string_view what = "a beam";

  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, ground or free_end
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, its end on each body, in the body's frame
  Vec2 angles{0, 0};                               ///< rad, of its tangents in the frames of the bodies
  double length = 0;                               ///< m, unloaded, along the beam
  int elements = 8;                                ///< number of pieces
  double young = 0;                                ///< Pa
  double density = 0;                              ///< kg/m³
  Section section = Section::given;                ///< shape
  double area = 0;                                 ///< m², if given
  double second_moment = 0;                        ///< m⁴, if given
  double width = 0;     ///< m, of a rectangle, perpendicular to the plane of motion
  double height = 0;    ///< m, of a rectangle, in the plane of motion
  double diameter = 0;  ///< m, of a circle or a tube, outside
  double wall = 0;      ///< m, of a tube
  /// in place of these sizes: where a section begins, as a share of the length, and its sizes in their order
  std::vector<std::vector<double>> sections = {};
  double shear_modulus = 0;       ///< Pa; 0: rigid in shear (Euler–Bernoulli)
  double shear_factor = 5.0 / 6;  ///< shear area over area
  double curvature = 0;           ///< 1/m, unloaded
  double damping = 0;             ///< s, stiffness-proportional
  std::optional<int> modes = {};  ///< number of modes that a reduced beam keeps
  int first = 0;                  ///< index of its first body

  /// m, length of a piece.
  double piece() const { return length / elements; }
  /// Whether the pieces keep the static deflection and `modes` alone.
  bool is_reduced() const { return modes.has_value(); }
  /// Whether an end, 0 or 1, is fastened to nothing.
  bool is_free(std::size_t end) const { return between[end] == free_end; }
  /// Sizes of the section at a share of the length, in the order of its keys.
  std::array<double, 2> sizes(double share) const {
    for (auto row = sections.rbegin(); row != sections.rend(); ++row)
      if ((*row)[0] <= share) return {(*row)[1], row->back()};
    switch (section) {
      case Section::rectangle:
        return {width, height};
      case Section::circle:
      case Section::tube:
        return {diameter, wall};
      default:
        return {area, second_moment};
    }
  }
  /// m², at a share of the length.
  double section_area(double share = 0) const {
    const auto [a, b] = sizes(share);
    switch (section) {
      case Section::rectangle:
        return a * b;
      case Section::circle:
        return std::numbers::pi / 4 * a * a;
      case Section::tube:
        return std::numbers::pi * b * (a - b);
      default:
        return a;
    }
  }
  /// m⁴, second moment of area at a share of the length.
  double section_moment(double share = 0) const {
    const auto disc = [](double d) { return std::numbers::pi / 64 * d * d * d * d; };
    const auto [a, b] = sizes(share);
    switch (section) {
      case Section::rectangle:
        return a * b * b * b / 12;
      case Section::circle:
        return disc(a);
      case Section::tube:
        return disc(a) - disc(a - 2 * b);
      default:
        return b;
    }
  }
  /// Share of the length at the middle of piece n, counted from 0.
  double middle(int n) const { return (n + 0.5) / elements; }
  /// s²/m⁴, greatest ρA/EI along the beam: a bending wave of the angular frequency ω has the wave number
  /// k = (ω² ρA/EI)^¼. Rigid pieces lower its frequency by (k l)²/24 of its value.
  double wave_factor() const {
    double most = density * section_area() / (young * section_moment());
    for (const auto& row : sections)
      most = std::max(most, density * section_area(row[0]) / (young * section_moment(row[0])));
    return most;
  }
  /// (k l)² of an error of 1 %.
  static constexpr double resolved_square = 0.24;
  /// rad/s, up to which bending waves have an error of at most 1 %.
  double resolved() const { return resolved_square / (piece() * piece() * std::sqrt(wave_factor())); }
  /// Number of pieces that resolve bending waves up to an angular frequency (rad/s) so.
  double pieces_for(double omega) const {
    return std::ceil(length * std::sqrt(omega * std::sqrt(wave_factor()) / resolved_square));
  }
  /// rad/s, highest frequency of axial vibration, 2c/l: neighbouring pieces move against each other.
  double highest() const { return 2 * std::sqrt(young / density) / piece(); }
  /// Name of piece n, counted from 1.
  std::string piece_name(int n) const { return name + "-" + std::to_string(n); }
  /// Piece n as a body, counted from 0.
  Body body(int n) const {
    Body b;
    b.name = piece_name(n + 1);
    const double l = piece(), mass = density * section_area(middle(n)) * l;
    b.mass = mass;
    b.inertia = mass * l * l / 12 + density * section_moment(middle(n)) * l;
    b.made = true;
    return b;
  }
  /// Element n of `elements` + 1 of a full beam, counted from 0. There is no first or last one at a free end.
  BeamElement element(int n) const {
    BeamElement x;
    x.name = piece_name(n + 1);
    const bool begins = n == 0, ends = n == elements;
    x.between = {begins ? between[0] : first + n - 1, ends ? between[1] : first + n};
    x.at = {begins ? at[0] : Vec2{}, ends ? at[1] : Vec2{}};
    x.angles = {begins ? angles.x() : 0, ends ? angles.y() : 0};
    x.length = (begins || ends ? 0.5 : 1) * piece();
    // Of a constant section with the mean compliance of both halves.
    const double a = middle(std::max(n - 1, 0)), b = middle(std::min(n, elements - 1));
    const auto mean = [](double p, double q) { return 2 * p / (1 + p / q); };
    const double effective = mean(section_area(a), section_area(b));
    x.axial = young * effective;
    x.bending = young * mean(section_moment(a), section_moment(b));
    x.shear = shear_modulus * shear_factor * effective;
    x.curvature = curvature;
    x.damping = damping;
    x.section = begins ? -0.5 : ends ? 0.5 : 0;
    x.made = true;
    return x;
  }
  /// The element of a reduced beam, from end to end.
  BeamElement only_element() const {
    BeamElement x = element(0);
    x.between = between, x.at = at, x.angles = angles;
    x.length = length;
    x.section = 0;
    return x;
  }

  static void keys(auto& k, auto& x) {
    k.between("two of bodies, \"ground\" and, at one end, \"free\": fastened to nothing", x.between, true);
    k.ends("the ends of the beam", x.at);
    k.take({"angles", "rad",
            "of the beam's tangent from its first to its second end, in the frame of each body"},
           x.angles);
    for (const std::size_t end : {0, 1}) {
      const double angle = end == 0 ? x.angles.x() : x.angles.y();
      k.check(!x.is_free(end) || x.at[end].is_zero(), "at",
              "must be [0, 0] at the free end, which is on no body");
      k.check(!x.is_free(end) || angle == 0, "angles", "must be 0 at the free end, which is on no body");
    }
    k.take({"curvature", "1/m", "of the unloaded beam, positive if it bends to the left"}, x.curvature);
    k.beam_length({"length", "m", "unloaded, along the beam, > 0", "from the stated positions of its ends"},
                  x);
    k.take({"elements", "", "number of pieces; or frequency_range"}, x.elements, beam_pieces);
    k.need({"young", "Pa", "Young's modulus, > 0"}, x.young, positive);
    k.need({"density", "kg/m³", "> 0"}, x.density, positive);
    k.choose({"section", "", ""}, x.section);
    k.rows(
        {"sections", "",
         "in place of one section: rows [from, ...] of the share of the length where a section begins, the first 0, "
         "and its area and second_moment, width and height, diameter, or diameter and wall"},
        x.section_units(), x.sections);
    const auto wrong = x.wrong_sections();
    k.check(wrong.empty(), "sections", wrong);
    const bool one = x.sections.empty();
    if (k.when(one && x.section == Beam::Section::given, {"area", "second_moment"},
               "needs section = \"given\" without sections")) {
      k.need({"area", "m²", "of the section, > 0"}, x.area, positive);
      k.need({"second_moment", "m⁴", "second moment of area of the section, > 0"}, x.second_moment, positive);
    }
    if (k.when(one && x.section == Beam::Section::rectangle, {"width", "height"},
               "needs section = \"rectangle\" without sections")) {
      k.need({"width", "m", "rectangle: perpendicular to the plane of motion, > 0"}, x.width, positive);
      k.need({"height", "m", "rectangle: in the plane of motion, > 0"}, x.height, positive);
    }
    if (k.when(one && (x.section == Beam::Section::circle || x.section == Beam::Section::tube), {"diameter"},
               "needs section = \"circle\" or \"tube\" without sections"))
      k.need({"diameter", "m", "circle or tube: outside, > 0"}, x.diameter, positive);
    if (k.when(one && x.section == Beam::Section::tube, {"wall"},
               "needs section = \"tube\" without sections")) {
      k.need({"wall", "m", "tube: thickness, > 0"}, x.wall, positive);
      k.check(2 * x.wall <= x.diameter, "wall", "must be at most half of the diameter");
    }
    k.take({"shear_modulus", "Pa", "for the deflection by shear (Timoshenko)", "rigid in shear"},
           x.shear_modulus, non_negative);
    k.take({"shear_factor", "", "shear area over area"}, x.shear_factor, positive);
    k.take({"damping", "s", "stiffness-proportional: the factor of the strain rates, ≥ 0; or damping_ratio"},
           x.damping, non_negative);
    k.together(
        {{{"damping_ratio", "",
           "in place of damping: of vibration at damping_frequency; it increases with the frequency, ≥ 0"},
          "number"},
         {{"damping_frequency", "Hz", "at which damping_ratio holds, > 0"}, "number"}},
        x, [](auto& s, auto& beam) { beam.read_damping_ratio(s); });
    k.take(
        {"modes", "",
         "reduction: number of modes, clamped at both ends, that its pieces keep besides the static deflection; "
         "at most elements",
         "none: the full beam"},
        x.modes, whole);
    k.together(
        {{{"frequency_range", "Hz",
           "in place of elements: as many as give bending waves up to it an error of at most 1 % of their "
           "frequency, > 0"},
          "number"}},
        x, [](auto& s, auto& beam) { beam.read_frequency_range(s); });
    if (!x.is_reduced()) return;
    k.check(*x.modes <= x.elements, "modes", "must be at most the number of elements");
    k.check(x.elements <= most_reduced, "modes", "needs at most 64 elements");
    k.check(!x.is_free(0) && !x.is_free(1), "modes", "needs a body or the ground at both ends");
    k.check(x.curvature == 0, "modes", "needs a straight beam, without curvature");
    k.check(x.sections.empty(), "modes", "needs one section along the length");
  }

 private:
  /// Units of a row of `sections`.
  std::vector<std::string_view> section_units() const {
    if (section == Section::given) return {"", "m²", "m⁴"};
    if (section == Section::circle) return {"", "m"};
    return {"", "m", "m"};
  }
  /// Why `sections` are invalid; empty if they are valid.
  std::string wrong_sections() const {
    double last = -1;
    for (const auto& row : sections) {
      if (row.size() != section_units().size())
        return "must have rows of the share of the length and all sizes";
      if (last < 0 ? row[0] != 0 : !(row[0] > last && row[0] < 1))
        return "must begin at ascending shares of the length, the first 0, the others less than 1";
      if (!(row[1] > 0 && row.back() > 0)) return "must have sizes greater than 0";
      if (section == Section::tube && 2 * row[2] > row[1])
        return "must have walls of at most half of the diameter";
      last = row[0];
    }
    return "";
  }
  /// τ = 2ζ/ω
  void read_damping_ratio(auto& section) {
    constexpr const char *key = "damping_ratio", *other = "damping_frequency";
    if (!section.has(key) && !section.has(other)) return;
    if (section.has("damping"))
      section.fail("damping", "is determined by damping_ratio; remove one of the two keys");
    const double ratio = section.number(key, non_negative);
    damping = ratio / (std::numbers::pi * section.number(other, positive));
  }
  void read_frequency_range(auto& section) {
    constexpr const char* key = "frequency_range";
    if (!section.has(key)) return;
    if (section.has("elements")) section.fail(key, "determines elements; remove one of the two keys");
    const double pieces = pieces_for(2 * std::numbers::pi * section.number(key, positive));
    if (!beam_pieces.holds(pieces)) section.fail(key, "needs more than 1000 elements");
    elements = static_cast<int>(pieces);
  }
};

inline constexpr auto beam_section_names =
    complete<Beam::Section>({{Beam::Section::given, "given", "by area and second_moment"},
                             {Beam::Section::rectangle, "rectangle", "by width and height"},
                             {Beam::Section::circle, "circle", "by diameter"},
                             {Beam::Section::tube, "tube", "by diameter and wall"}});
/// Words of the shapes in a scene.
constexpr const auto& choices(Beam::Section) { return beam_section_names; }

}  // namespace freeplay

// Axes: their unit, range and tics, such that the labels of the tics are short and do not touch.
//
// The width of a text on paper is estimated from its number of letters. `letter_width` is the mean
// advance of the digits of DejaVu Sans; gnuplot measures its keys by the same mean, and the fonts of
// journals are narrower.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "plots/drawing/gnuplot.hpp"

namespace freeplay::plots {

inline constexpr double letter_width = 0.157;  ///< cm, of a text of Style::usual_font_size
inline constexpr double line_height = 0.36;    ///< cm, likewise

/// Number of letters of a UTF-8 text.
std::size_t letters(std::string_view text);
/// The text, or its beginning and end with "…" between them, of at most `most` letters.
std::string shortened(const std::string& text, std::size_t most);

/// A unit in which values are shown. `size`: SI units in it.
struct ShownUnit {
  std::string name;
  double size = 1;
};
/// The unit with a prefix (mm, kN), or with a power of ten (10³ m/s²), for values up to `greatest`
/// in the SI unit.
ShownUnit fitting_unit(std::string_view si, double greatest);
/// A unit by its name, as a user writes it. Throws SceneError if it is unknown or its dimension is
/// not that of `si`.
ShownUnit unit_named(const std::string& name, std::string_view si);
/// A unit as it is printed: m/s² for m/s2, ° for deg.
std::string printed(std::string_view unit);

/// The title of an axis: its text is an expression of gnuplot, with markup.
struct AxisTitle {
  Script text;
  std::size_t length = 0;  ///< letters of the text
  std::string unit;        ///< printed

  /// A constant of the source, such as F_x.
  static AxisTitle of(Word quantity, std::string unit);
  /// Text of a file or a user, printed as it is.
  static AxisTitle plain(const std::string& text, std::string unit);
  /// "NAME: quantity".
  static AxisTitle of(const std::string& name, const Script& quantity, std::size_t length, std::string unit);
  /// Expression of gnuplot: the text with the unit in parentheses, on a second line if the first
  /// has no room for both. `most`: letters of a line.
  Script label(std::size_t most) const;
  /// Whether the text and the unit fit in one line of this many letters.
  bool fits(std::size_t most) const;
};

/// Least and greatest of some values; values that are not finite are omitted.
struct Limits {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  Limits() = default;
  explicit Limits(const std::vector<double>& values) {
    for (const double v : values) hold(v);
  }
  void hold(double v) {
    if (!std::isfinite(v)) return;
    least = std::min(least, v), most = std::max(most, v);
  }
  double range() const { return most - least; }
  double size() const { return std::max(std::abs(least), std::abs(most)); }  ///< of a value
};

/// A tic at a value with its label.
struct Tic {
  double at;
  std::string label;
};

/// The range of an axis and the distance of its tics.
struct Axis {
  double low = 0, high = 1;
  double step = 0;  ///< 0: chosen by tics_of
  bool logarithmic = false;
  bool turn = false;   ///< degrees: tics at parts of a turn
  bool whole = false;  ///< tics at whole numbers only
  /// In increasing order, instead of tics at equal distances; with_tics() removes those that touch.
  std::vector<Tic> tics = {};
};
/// The nearest 1, 2 or 5 times a power of ten, at least 1: a magnification.
double round_factor(double x);

/// A linear axis over values, with a margin. A constant gets a range about it that rounding does
/// not fill: values that differ by less than 1e-4 of their size need no more than five digits.
Axis axis_of(double least, double greatest);
/// A logarithmic axis of whole decades.
Axis decades_of(double least, double greatest);

/// The axis with tics at most `most` in number; along a horizontal axis `width` (letters) limits
/// the labels.
Axis with_tics(Axis axis, double most, double width = 0);
/// Letters of the longest label of the tics.
std::size_t longest_label(const Axis& axis);
/// Commands for an axis ("x" or "y").
Script commands(const Axis& axis, Word name);

}  // namespace freeplay::plots

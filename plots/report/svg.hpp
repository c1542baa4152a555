// A drawing as SVG 1.1 text, in pixels from the upper left corner. Texts are escaped, so that they
// contain no markup, and hidden characters are made visible.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "values/vec2.hpp"

namespace freeplay::report {

struct Pen {
  std::string_view stroke = "none";
  double width = 1;
  std::string_view fill = "none";
  double opacity = 1;
  bool dashed = false;
};

class Svg {
 public:
  enum class Anchor { start, middle };

  Svg(int width, int height);
  /// Until close_panel(), drawing is clipped to the panel and coordinates are relative to its
  /// corner.
  void open_panel(const Vec2& corner, double width, double height);
  void close_panel();
  void line(std::span<const Vec2> points, const Pen& with, bool closed = false);
  void circle(const Vec2& middle, double radius, const Pen& with);
  void arrow(const Vec2& from, const Vec2& by, const Pen& with);
  /// Writes at most `longest` characters of the text.
  void text(const Vec2& at, std::string_view words, double size, std::string_view colour,
            Anchor anchor = Anchor::start, std::size_t longest = 100);
  /// Returns the complete document and clears the drawing.
  std::string finish();

 private:
  void pen(const Pen& pen);
  std::string text_;
};

}  // namespace freeplay::report

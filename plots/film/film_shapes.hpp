// Draws the shapes of a mechanism in a film.
#pragma once

#include <functional>
#include <string_view>

#include "plots/film/film_run.hpp"
#include "plots/report/svg.hpp"

namespace freeplay::report {

/// Colours of the report page in its light theme (page/page.css).
inline constexpr std::string_view ink = "#1b1f24", soft = "#5b6570", accent = "#0b62b5",
                                  force_colour = "#c0162c";
std::string_view run_colour(std::size_t r);
std::string_view body_colour(int body);

struct ShapePainter {
  Svg& svg;
  const FilmRun& run;
  At at;
  std::function<Vec2(const Vec2&)> pixel;  ///< maps a point in the world frame (m)
  double scale;                            ///< px per m
  std::string_view colour = {};            ///< for the whole run; empty: one colour per body
  double opacity = 1;
  bool names = true;
  double width;  ///< px, width of the panel

  /// Draws all shapes, from back to front.
  void paint() const;
  /// Position of a shape (px).
  Vec2 place(const FilmShape& shape) const;

 private:
  void paint(const FilmShape& shape) const;
  void paint_slider(const FilmShape& shape) const;
  void paint_spring(const FilmShape& shape) const;
  void hatch(const Vec2& middle, const Vec2& along, double length, double size) const;
  std::string_view of(int body) const;
};

}  // namespace freeplay::report

// One frame of a film: the mechanism of each run, magnified joints with clearance beside it, time
// and crank angle below.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plots/film/film_run.hpp"
#include "plots/report/svg.hpp"

namespace freeplay::report {

// Draws the shapes of a mechanism in a film.

/// Colours of the report page in its light theme (page/page.css).
inline constexpr std::string_view ink = "#1b1f24", soft = "#5b6570", accent = "#0b62b5",
                                  force_colour = "#c0162c";
std::string_view run_colour(std::size_t r);

struct ShapePainter {
  Svg& svg;
  const FilmRun& run;
  At at;
  std::function<Vec2(const Vec2&)> pixel;  ///< maps a point in the world frame (m)
  double scale;                            ///< px per m
  std::string_view colour = {};            ///< for the whole run; empty: one colour per body
  double opacity = 1;
  bool names = true;
  double width;        ///< px, width of the panel
  double magnify = 1;  ///< factor of the deflection of beams, of clearance and deviations of surfaces

  /// Draws all shapes, from back to front.
  void paint() const;
  /// Position of a shape (px).
  Vec2 place(const FilmShape& shape) const;

 private:
  void paint(const FilmShape& shape) const;
  void paint(const BeamLine& beam) const;
  void name(const Vec2& at, std::string_view name) const;
  void paint_slider(const FilmShape& shape) const;
  void paint_spring(const FilmShape& shape) const;
  void hatch(const Vec2& middle, const Vec2& along, double length, double size) const;
  std::string_view of(int body) const;
};

struct FilmLook {
  std::string title;
  int width = 960;     ///< px; the height follows from the content
  bool over = false;   ///< all runs in one panel instead of side by side
  double magnify = 1;  ///< factor of the deflection of beams, of clearance and deviations of surfaces
};

class FilmDrawing {
 public:
  /// Keeps a reference to `runs`, which must not change.
  FilmDrawing(const std::vector<FilmRun>& runs, FilmLook look);

  int width() const { return look_.width; }
  int height() const { return height_; }  ///< px, even, as video codecs require
  /// SVG of the frame at time t (s). Impacts within `reach` (s) of t are marked by a ring.
  std::string frame(double t, double reach) const;

  /// Position in a frame (px) of a point of run r in the world frame (m), and of the centre of its
  /// journal k.
  Vec2 place(std::size_t r, const Vec2& point) const;
  Vec2 journal(std::size_t r, std::size_t k, double t) const;

 private:
  struct Panel {
    Vec2 corner;
    double width, height;
    std::vector<std::size_t> runs;
  };
  Vec2 in_panel(const Vec2& point) const;
  void draw_mechanism(Svg& svg, const Panel& panel, double t, double reach) const;
  void draw_loose(Svg& svg, std::size_t k, double t) const;
  void draw_scale(Svg& svg, const Panel& panel) const;
  Vec2 clearance_middle(std::size_t k) const;

  const std::vector<FilmRun>& runs_;
  FilmLook look_;
  std::vector<Panel> panels_;
  std::vector<std::string> names_;  // of the magnified joints
  std::size_t hidden_ = 0;          // number of joints without room
  double scale_ = 1;                // px per m
  Vec2 middle_;                     // m, shown in the middle of a panel
  int height_ = 0;
};

}  // namespace freeplay::report

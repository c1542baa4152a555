#include "plots/report/svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "io/files/escaping.hpp"
#include "plots/report/page.hpp"

namespace freeplay::report {

Svg::Svg(int width, int height) {
  text_ = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"DejaVu Sans, sans-serif\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
      width, height);
}

void Svg::open_panel(const Vec2& corner, double width, double height) {
  fmt::format_to(std::back_inserter(text_),
                 "<svg x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\">\n", corner.x(),
                 corner.y(), width, height);
}

void Svg::close_panel() { text_ += "</svg>\n"; }

void Svg::pen(const Pen& pen) {
  fmt::format_to(std::back_inserter(text_), " fill=\"{}\"", pen.fill);
  if (pen.stroke != "none")
    fmt::format_to(std::back_inserter(text_), " stroke=\"{}\" stroke-width=\"{}\"", pen.stroke, pen.width);
  if (pen.opacity < 1) fmt::format_to(std::back_inserter(text_), " opacity=\"{}\"", pen.opacity);
  if (pen.dashed) text_ += " stroke-dasharray=\"4 3\"";
  text_ += "/>\n";
}

void Svg::line(std::span<const Vec2> points, const Pen& with, bool closed) {
  const auto drawable = [](const Vec2& p) { return std::isfinite(p.x()) && std::isfinite(p.y()); };
  if (points.empty() || !std::ranges::all_of(points, drawable)) return;
  text_ += closed ? "<polygon points=\"" : "<polyline points=\"";
  for (const auto& p : points) fmt::format_to(std::back_inserter(text_), "{:.2f},{:.2f} ", p.x(), p.y());
  text_.back() = '"';
  pen(with);
}

void Svg::circle(const Vec2& middle, double radius, const Pen& with) {
  if (!std::isfinite(middle.x() + middle.y() + radius)) return;
  fmt::format_to(std::back_inserter(text_), "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\"", middle.x(),
                 middle.y(), radius);
  pen(with);
}

void Svg::arrow(const Vec2& from, const Vec2& by, const Pen& with) {
  const double length = by.norm();
  if (!(length >= 2)) return;  // shorter than its head, or not finite
  const Vec2 u = by.direction(), n{-u.y(), u.x()}, tip = from + by;
  const double head = std::min(8.0, 0.5 * length);
  line(std::array{from, tip}, with);
  line(std::array{tip - head * u + 0.6 * head * n, tip, tip - head * u - 0.6 * head * n}, with);
}

void Svg::text(const Vec2& at, std::string_view words, double size, std::string_view colour, Anchor anchor,
               std::size_t longest) {
  fmt::format_to(std::back_inserter(text_),
                 "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{}\" fill=\"{}\"{}>{}</text>\n", at.x(), at.y(),
                 size, colour, anchor == Anchor::middle ? " text-anchor=\"middle\"" : "",
                 html_text(visible_brief(words, longest)));
}

std::string Svg::finish() {
  text_ += "</svg>\n";
  return std::move(text_);
}

}  // namespace freeplay::report

// The shapes of a mechanism at one pose as curves of a figure, to scale: links through their joints, each body in
// its own colour, beams as bent lines, joints, supports, guides, walls, discs and springs (io/scene/pose_file.hpp defines the shapes).
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "plots/drawing/figure.hpp"

namespace freeplay::plots {

struct Shape {
  std::string kind, name;
  double x, y, a, b;
};

/// The shapes of a table with the columns shape, name, x, y, a and b.
std::vector<Shape> shapes_in(const std::filesystem::path& file);
/// The same shapes with the deflection of beams, and clearance and deviations of surfaces, magnified.
std::vector<Shape> magnified(std::vector<Shape> shapes, double factor);

/// Bounding box of shapes.
struct Frame {
  double left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY;
  void hold(double x, double y, double r);
  double size() const { return std::max({right - left, high - low, 1e-12}); }
};
Frame frame_of(const std::vector<Shape>& shapes);

/// Rows x, y in m, with their style: with lines …
struct ShapeCurve {
  Block block;
  Script style;
};
/// The curves of shapes, from the back. `u`: size of the symbols, `wall`: length of the walls (m).
std::vector<ShapeCurve> pose_curves(const std::vector<Shape>& shapes, double u, double wall);

}  // namespace freeplay::plots

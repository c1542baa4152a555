// Cubic splines with continuous second derivative, by their slopes m_i at knots x_i with values
// y_i. Within an interval of width h, s = (x − x_i)/h,
//
//     y = y_i + h m_i s + (3 d − h (2 m_i + m_{i+1})) s² + (h (m_i + m_{i+1}) − 2 d) s³,
//     d = y_{i+1} − y_i
//
// and m solves
//
//     m_{i−1}/h_{i−1} + 2 (1/h_{i−1} + 1/h_i) m_i + m_{i+1}/h_i = 3 (d_{i−1}/h_{i−1}² + d_i/h_i²)
//
// (de Boor, A Practical Guide to Splines, ch. IV).
#pragma once

#include <utility>
#include <vector>

namespace freeplay {

enum class SplineEnds {
  natural,  ///< second derivative 0
  flat,     ///< first derivative 0
  periodic  ///< derivatives are periodic; the values may differ by a constant for each period
};

/// Slopes at the knots: at least two, x increasing.
std::vector<double> spline_slopes(const std::vector<std::pair<double, double>>& knots, SplineEnds ends);

}  // namespace freeplay

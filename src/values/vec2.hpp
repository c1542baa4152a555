// A vector of the plane, for facts and results and for the evaluation of a System, where T may
// carry derivatives.
#pragma once

#include <cmath>

namespace freeplay {

/// A vector in the plane.
template <class T>
class Vec2Of {
 public:
  constexpr Vec2Of() = default;
  /// From its components.
  constexpr Vec2Of(const T& x, const T& y) : x_(x), y_(y) {}
  /// First component.
  constexpr const T& x() const { return x_; }
  /// Second component.
  constexpr const T& y() const { return y_; }
  /// First component.
  constexpr T& x() { return x_; }
  /// Second component.
  constexpr T& y() { return y_; }
  /// Squared length.
  constexpr T squared_norm() const { return x_ * x_ + y_ * y_; }
  /// Length.
  T norm() const {
    using std::sqrt;
    return sqrt(squared_norm());
  }
  /// Whether both components are 0.
  constexpr bool is_zero() const { return x_ == 0 && y_ == 0; }
  /// The unit vector; valid also if squares would overflow or vanish.
  Vec2Of direction() const {
    const T greatest = std::fmax(std::abs(x_), std::abs(y_));
    const Vec2Of scaled{x_ / greatest, y_ / greatest};
    const T length = std::sqrt(scaled.x_ * scaled.x_ + scaled.y_ * scaled.y_) * greatest;
    return {x_ / length, y_ / length};
  }

  /// Adds a vector.
  constexpr Vec2Of& operator+=(const Vec2Of& b) {
    x_ += b.x_;
    y_ += b.y_;
    return *this;
  }
  /// Subtracts a vector.
  constexpr Vec2Of& operator-=(const Vec2Of& b) {
    x_ -= b.x_;
    y_ -= b.y_;
    return *this;
  }
  /// Sum.
  friend constexpr Vec2Of operator+(Vec2Of a, const Vec2Of& b) { return a += b; }
  /// Difference.
  friend constexpr Vec2Of operator-(Vec2Of a, const Vec2Of& b) { return a -= b; }
  /// Opposite vector.
  friend constexpr Vec2Of operator-(const Vec2Of& a) { return {-a.x_, -a.y_}; }
  /// Multiple.
  friend constexpr Vec2Of operator*(const T& s, const Vec2Of& a) { return {s * a.x_, s * a.y_}; }
  /// Multiple.
  friend constexpr Vec2Of operator*(const Vec2Of& a, const T& s) { return s * a; }
  /// Quotient.
  friend constexpr Vec2Of operator/(const Vec2Of& a, const T& s) { return {a.x_ / s, a.y_ / s}; }
  /// Whether both components are equal.
  friend bool operator==(const Vec2Of&, const Vec2Of&) = default;

  /// Rotated by +90°.
  friend constexpr Vec2Of perp(const Vec2Of& r) { return {-r.y_, r.x_}; }
  /// Scalar product.
  friend constexpr T dot(const Vec2Of& a, const Vec2Of& b) { return a.x_ * b.x_ + a.y_ * b.y_; }
  /// x_a y_b − y_a x_b
  friend constexpr T cross(const Vec2Of& a, const Vec2Of& b) { return a.x_ * b.y_ - a.y_ * b.x_; }

 private:
  T x_{}, y_{};
};
/// A vector of numbers.
using Vec2 = Vec2Of<double>;

/// A number without its derivatives.
inline double value_of(double x) { return x; }

}  // namespace freeplay

// A vector of the plane, for facts and results and for the evaluation of a System, where T may
// carry derivatives.
#pragma once

#include <cmath>

namespace freeplay {

template <class T>
class Vec2Of {
 public:
  constexpr Vec2Of() = default;
  constexpr Vec2Of(const T& x, const T& y) : x_(x), y_(y) {}
  constexpr const T& x() const { return x_; }
  constexpr const T& y() const { return y_; }
  constexpr T& x() { return x_; }
  constexpr T& y() { return y_; }
  constexpr T squared_norm() const { return x_ * x_ + y_ * y_; }
  T norm() const {
    using std::sqrt;
    return sqrt(squared_norm());
  }
  constexpr bool is_zero() const { return x_ == 0 && y_ == 0; }
  /// The unit vector; valid also if squares would overflow or vanish.
  Vec2Of direction() const {
    const T greatest = std::fmax(std::abs(x_), std::abs(y_));
    const Vec2Of scaled{x_ / greatest, y_ / greatest};
    const T length = std::sqrt(scaled.x_ * scaled.x_ + scaled.y_ * scaled.y_) * greatest;
    return {x_ / length, y_ / length};
  }

  constexpr Vec2Of& operator+=(const Vec2Of& b) {
    x_ += b.x_;
    y_ += b.y_;
    return *this;
  }
  constexpr Vec2Of& operator-=(const Vec2Of& b) {
    x_ -= b.x_;
    y_ -= b.y_;
    return *this;
  }
  friend constexpr Vec2Of operator+(Vec2Of a, const Vec2Of& b) { return a += b; }
  friend constexpr Vec2Of operator-(Vec2Of a, const Vec2Of& b) { return a -= b; }
  friend constexpr Vec2Of operator-(const Vec2Of& a) { return {-a.x_, -a.y_}; }
  friend constexpr Vec2Of operator*(const T& s, const Vec2Of& a) { return {s * a.x_, s * a.y_}; }
  friend constexpr Vec2Of operator*(const Vec2Of& a, const T& s) { return s * a; }
  friend constexpr Vec2Of operator/(const Vec2Of& a, const T& s) { return {a.x_ / s, a.y_ / s}; }
  friend bool operator==(const Vec2Of&, const Vec2Of&) = default;

  /// Rotated by +90°.
  friend constexpr Vec2Of perp(const Vec2Of& r) { return {-r.y_, r.x_}; }
  friend constexpr T dot(const Vec2Of& a, const Vec2Of& b) { return a.x_ * b.x_ + a.y_ * b.y_; }
  friend constexpr T cross(const Vec2Of& a, const Vec2Of& b) { return a.x_ * b.y_ - a.y_ * b.x_; }

 private:
  T x_{}, y_{};
};
using Vec2 = Vec2Of<double>;

/// A number without its derivatives.
inline double value_of(double x) { return x; }

}  // namespace freeplay

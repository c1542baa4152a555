// A vector of the plane, for facts and results: what a user of the library sees of geometry.
#pragma once

#include <cmath>

namespace freeplay {

class Vec2 {
 public:
  constexpr Vec2() = default;
  constexpr Vec2(double x, double y) : x_(x), y_(y) {}
  constexpr double x() const { return x_; }
  constexpr double y() const { return y_; }
  constexpr double& x() { return x_; }
  constexpr double& y() { return y_; }
  double norm() const { return std::sqrt(x_ * x_ + y_ * y_); }
  constexpr bool is_zero() const { return x_ == 0 && y_ == 0; }
  /// The same direction with length 1, also where squares would overflow or vanish.
  Vec2 direction() const {
    const double greatest = std::fmax(std::abs(x_), std::abs(y_));
    const Vec2 scaled{x_ / greatest, y_ / greatest};
    const double length = std::sqrt(scaled.x_ * scaled.x_ + scaled.y_ * scaled.y_) * greatest;
    return {x_ / length, y_ / length};
  }

  constexpr Vec2& operator+=(const Vec2& b) { return *this = {x_ + b.x_, y_ + b.y_}; }
  constexpr Vec2& operator-=(const Vec2& b) { return *this = {x_ - b.x_, y_ - b.y_}; }
  friend constexpr Vec2 operator+(Vec2 a, const Vec2& b) { return a += b; }
  friend constexpr Vec2 operator-(Vec2 a, const Vec2& b) { return a -= b; }
  friend constexpr Vec2 operator-(const Vec2& a) { return {-a.x_, -a.y_}; }
  friend constexpr Vec2 operator*(double s, const Vec2& a) { return {s * a.x_, s * a.y_}; }
  friend constexpr Vec2 operator*(const Vec2& a, double s) { return s * a; }
  friend constexpr bool operator==(const Vec2&, const Vec2&) = default;

 private:
  double x_ = 0, y_ = 0;
};

}  // namespace freeplay

// Lift h of a cam against the angle φ on it, over one turn, in pieces with 0 ≤ φ − a < width:
//
//     h(u) = Σ c_k u^k + A cos(w u) + B sin(w u),    u = φ − a
//
// Standard laws of a rise by L over β with s = u/β (a return is a reversed rise; Norton, Cam Design
// and Manufacturing Handbook, ch. 2 and 3):
//
//     harmonic      h = L/2 (1 − cos πs)              cycloidal   h = L (s − sin(2πs)/2π)
//     polynomial    h = L (10 s³ − 15 s⁴ + 6 s⁵)
//
// Lifts of a table are joined by the periodic cubic spline, whose second derivative is continuous.
#pragma once

#include <utility>
#include <vector>

#include "mechanism/keys.hpp"
#include "numerics/traced.hpp"

namespace freeplay {

/// Law of rise and return of a standard cam.
enum class CamLaw { cycloidal, polynomial, harmonic };
inline constexpr auto cam_law_names =
    complete<CamLaw>({{CamLaw::cycloidal, "cycloidal"},
                      {CamLaw::polynomial, "polynomial", "3-4-5"},
                      {CamLaw::harmonic, "harmonic",
                       "rise and return of π each are an eccentric disc; else its second derivative jumps"}});
constexpr std::span<const Choice<CamLaw>> choices(CamLaw) { return cam_law_names; }

/// Lift of a cam over its angle, periodic in 2π.
class CamProfile {
 public:
  /// rad, a full turn
  static constexpr double turn = 6.283185307179586;
  /// h (m) and its derivatives with respect to φ (m/rad, ...).
  struct Value {
    /// lift and derivatives, as above
    double h = 0, d1 = 0, d2 = 0, d3 = 0;
  };
  /// Upper bounds of |h′| and |h″| over a turn, valid between samples too.
  struct Bounds {
    /// m/rad, m/rad²
    double d1 = 0, d2 = 0;
  };

  CamProfile() = default;
  /// Rise, dwell and return from the angle `start` on, then zero lift.
  static CamProfile standard(CamLaw law, double lift, double start, double rise, double dwell, double fall);
  /// Through points (angle, lift): at least three, increasing, within one turn.
  static CamProfile through(const std::vector<std::pair<double, double>>& points);

  /// Lift and derivatives at an angle (rad).
  Value at(double phi) const;
  /// Bounds over the turn.
  const Bounds& bounds() const { return bounds_; }
  /// rad, width of the narrowest piece with varying lift.
  double narrowest() const { return narrowest_; }
  /// Calls f(φ, Value) at closely spaced angles over the turn, at least 16 for each piece.
  template <class F>
  void each(F f) const {
    for (const auto& p : pieces_) {
      const int n = samples();
      for (int i = 0; i <= n; ++i) f(p.begin + p.width * i / n, value(p, p.width * i / n));
    }
  }

 private:
  struct Piece {
    double begin = 0, width = 0;
    double c[6] = {0, 0, 0, 0, 0, 0};
    double A = 0, B = 0, w = 0;
  };
  static Value value(const Piece& p, double u);
  static Piece ramp(CamLaw law, double lift, double begin, double width, bool down);
  int samples() const { return pieces_.size() > 64 ? 16 : 1024; }
  void finish();

  std::vector<Piece> pieces_;  // adjacent, from pieces_[0].begin over one turn
  Bounds bounds_;
  double narrowest_ = turn;
};

/// f(x) for a number that may carry derivatives, from the values of f and f′.
inline double lifted(double, double f, double) { return f; }
/// A function value f with derivative df at x, as a value of type T.
template <class T>
T lifted(const T& x, double f, double df) {
  return x.chain(f, df);
}
/// A profile is looked up by a value, so it cannot be traced: throws NotTraceable.
inline Traced lifted(const Traced& x, double f, double) { return f + value_of(x); }

}  // namespace freeplay

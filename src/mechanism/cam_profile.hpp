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

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "mechanism/keys.hpp"
#include "numerics/choice.hpp"
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
  template <class P>
  struct ValueOf {
    /// lift and derivatives, as above
    P h = 0, d1 = 0, d2 = 0, d3 = 0;
  };
  /// Of a number.
  using Value = ValueOf<double>;
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
  Value at(double phi) const { return at_place(phi); }
  /// The same in a trace.
  ValueOf<Traced> at(const Traced& phi) const { return at_place(phi); }
  /// Bounds over the turn.
  const Bounds& bounds() const { return bounds_; }
  /// rad, width of the narrowest piece with varying lift.
  double narrowest() const { return narrowest_; }
  /// m/rad³, of a table: the greatest |h‴| from a to b (rad), a ≤ b.
  double greatest_third(double a, double b) const;
  /// Calls f(φ, Value) at closely spaced angles over the turn, at least 16 for each piece.
  template <class F>
  void each(F f) const {
    for (const auto& p : pieces_) {
      const int n = samples();
      for (int i = 0; i <= n; ++i) f(p.begin + p.width * i / n, value(p, p.width * i / n));
    }
  }

 private:
  /// P: double, or the traced entries of a table of pieces.
  template <class P>
  struct PieceOf {
    P begin = 0, width = 0;
    P c[6] = {0, 0, 0, 0, 0, 0};
    P A = 0, B = 0, w = 0;
  };
  using Piece = PieceOf<double>;
  template <class P>
  static ValueOf<P> value(const PieceOf<P>& p, const P& u) {
    using std::cos, std::sin;
    ValueOf<P> y;
    const auto* c = p.c;
    y.h = c[0] + u * (c[1] + u * (c[2] + u * (c[3] + u * (c[4] + u * c[5]))));
    y.d1 = c[1] + u * (2 * c[2] + u * (3 * c[3] + u * (4 * c[4] + u * 5 * c[5])));
    y.d2 = 2 * c[2] + u * (6 * c[3] + u * (12 * c[4] + u * 20 * c[5]));
    y.d3 = 6 * c[3] + u * (24 * c[4] + u * 60 * c[5]);
    if (vanishes(p.w)) return y;
    const P angle = p.w * u, co = cos(angle), si = sin(angle);
    const P w = p.w, even = p.A * co + p.B * si, odd = p.B * co - p.A * si;
    y.h += even;
    y.d1 += w * odd;
    y.d2 -= w * w * even;
    y.d3 -= w * w * w * odd;
    return y;
  }
  const Piece& piece(std::size_t i) const { return pieces_[i]; }
  PieceOf<Traced> piece(const Traced& i) const;
  template <class P>
  ValueOf<P> at_place(const P& phi) const {
    const double first = pieces_.front().begin;
    const P x = phi - turn * floor_of((phi - first) / turn);
    const auto& p =
        piece(interval_of(pieces_.size() - 1, x, [&](std::size_t k) { return pieces_[k + 1].begin; }));
    // std::clamp(x - begin, 0, width)
    const P from = x - p.begin;
    const P u = choose(
        is_below(from, 0), [] { return P(0); },
        [&] {
          return choose(
              is_below(p.width, from), [&] { return P(p.width); }, [&] { return from; });
        });
    return value<P>(p, u);
  }
  /// The piece at an angle from that of the first one on.
  std::size_t index_at(double x) const {
    return interval_of(pieces_.size() - 1, x, [&](std::size_t k) { return pieces_[k + 1].begin; });
  }
  static Piece ramp(CamLaw law, double lift, double begin, double width, bool down);
  int samples() const { return pieces_.size() > 64 ? 16 : 1024; }
  void finish();

  std::vector<Piece> pieces_;  // adjacent, from pieces_[0].begin over one turn
  // m/rad³, of a table: greatest |h‴| of 2^level pieces from each one on
  std::vector<std::vector<double>> thirds_;
  Bounds bounds_;
  double narrowest_ = turn;
};

}  // namespace freeplay

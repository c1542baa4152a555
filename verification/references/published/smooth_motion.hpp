// Equations of motion in minimal coordinates by virtual work, and their integration in long double.
// Used by the references of published cases without contact. A body with the velocity v = Σ_j J_j
// q̇_j and the angular velocity ω = Σ_j w_j q̇_j has the acceleration Σ_j J_j q̈_j + b and the
// angular acceleration Σ_j w_j q̈_j + c. The principle of d'Alembert,
//
//     Σ_bodies [J_i · (m a − F) + w_i (I α − T)] = 0        for each coordinate i,
//
// gives linear equations for q̈. They are integrated in equal steps of the method of order 8 of
// Cooper and Verner; a run with twice the steps shows the error. Vectors are complex numbers.
// Units: m, kg, s, rad. Source: derived by hand.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

using Plane = std::complex<long double>;
inline constexpr Plane perpendicular{0, 1};

inline Plane direction(long double angle) { return std::polar(1.0L, angle); }
inline long double dot(Plane a, Plane b) { return a.real() * b.real() + a.imag() * b.imag(); }

template <std::size_t N>
class VirtualWork {
 public:
  using Reals = std::array<long double, N>;

  /// A mass with the Jacobian `j`, the acceleration `bias` at q̈ = 0 and the force on it.
  void mass(long double m, const std::array<Plane, N>& j, Plane bias, Plane force) {
    for (std::size_t r = 0; r < N; ++r) {
      for (std::size_t c = 0; c < N; ++c) matrix_[r][c] += m * dot(j[r], j[c]);
      right_[r] += dot(j[r], force - m * bias);
    }
  }
  /// The rotation of a body with the moment of inertia `inertia` and the torque on it.
  void rotation(long double inertia, const Reals& w, long double bias, long double torque) {
    for (std::size_t r = 0; r < N; ++r) {
      for (std::size_t c = 0; c < N; ++c) matrix_[r][c] += inertia * w[r] * w[c];
      right_[r] += w[r] * (torque - inertia * bias);
    }
  }
  /// A force on a coordinate.
  void force(std::size_t coordinate, long double value) { right_[coordinate] += value; }

  /// q̈, by Gaussian elimination; the matrix is symmetric and positive definite.
  Reals accelerations() const {
    auto a = matrix_;
    Reals b = right_;
    eliminate(a, b, Pivots::none);
    return b;
  }

 private:
  std::array<Reals, N> matrix_{};
  Reals right_{};
};

/// The state at `end` of ẏ = f(t, y) with y at t = 0.
template <std::size_t N, class Rate>
std::array<long double, N> smooth_motion(const Rate& f, std::array<long double, N> y, long double end,
                                         int steps) {
  static const CooperVerner<long double> method;
  const long double h = end / steps;
  for (int i = 0; i < steps; ++i) y = method.step(f, static_cast<long double>(i) * h, y, h);
  return y;
}

/// Real p and q with a p + b q = v.
inline std::pair<long double, long double> components(Plane a, Plane b, Plane v) {
  const long double det = a.real() * b.imag() - a.imag() * b.real();
  return {(v.real() * b.imag() - v.imag() * b.real()) / det,
          (a.real() * v.imag() - a.imag() * v.real()) / det};
}

}  // namespace freeplay::reference

// FiniteFilm: Reynolds' equation of a journal bearing of finite length, as ratios to the short bearing.
//
// With h = c H, H = 1 − ε cos θ, ζ = z/R, ℓ = L/D, p = (12μR²/c³) P and the velocity w of film.hpp,
//
//     ∂/∂θ(H³ ∂P/∂θ) + H³ ∂²P/∂ζ² = −(w_r cos θ + w_t sin θ),     P = 0 at ζ = ±ℓ.
//
// H depends on θ alone, so that the modes cos λ_m ζ, λ_m = (2m − 1)π/(2ℓ), separate it into
//
//     (H³ P_m′)′ − λ_m² H³ P_m = −cos θ  and  −sin θ
//     1 = Σ c_m cos λ_m ζ,   c_m = 4(−1)^{m+1}/((2m − 1)π)
//
// solved by finite volumes on 385 points of half the circle, graded towards the narrowest gap. The sum is
// that of the differences P_m − cos θ/(λ_m² H³), which vanish for great λ_m, and of the short bearing's
// pressure. Then G = ∫∫ n P dθ dζ; the integrals of a cavitated film cover P > 0 (Gümbel), with the ends of
// this region located between points. Force: F = −(12μR⁴/c³) G.
//
// Tables, interpolated by cubic splines, with α the direction of w:
//
//     full        G_r/G_r,short and G_t/G_t,short at ε
//     cavitated   G_r/|G_short| and G_t/(|G_short| sin α) at ε and cos α
//
// over u = ln(1 − ln(1 − ε)/2), and asinh(cos α/δ)/asinh(1/δ) with δ = √(2(1 − ε)): at the narrowest gap,
// whose length is δ, the force changes within angles δ of a purely tangential w. For ε ≤ 0.99 the errors of
// tables and grid are below 3e-4 of the force, in openings (w_r < 0) below 1e-3; beyond, below 5e-3.
#pragma once

#include <array>
#include <memory>
#include <vector>

namespace freeplay {

class FiniteFilm {
 public:
  /// Ranges of L/D, and of the least film thickness over the clearance.
  static constexpr double least_length = 0.05, greatest_length = 4, least_thickness = 1e-3;

  /// `length`: L/D, within its range.
  explicit FiniteFilm(double length);
  /// @name Ratios of (G_r, G_t), as above, for 0 ≤ ε ≤ 1 − least_thickness; T is double or Dual<4>
  ///@{
  template <class T>
  std::array<T, 2> full(const T& epsilon) const;
  template <class T>
  std::array<T, 2> cavitated(const T& epsilon, const T& cosine) const;
  ///@}

 private:
  static constexpr int ratios = 33, directions = 61;
  /// Coefficients of a spline through points over u, and over u and directions.
  std::array<std::vector<double>, 2> full_, cavitated_;
};

/// The tables of L/D. They are kept for the next film of this length; several threads may ask at once.
std::shared_ptr<const FiniteFilm> finite_film(double length);

}  // namespace freeplay

// Film: force of a lubricant film between bearing and journal (laminar, isoviscous, without
// inertia). With h(θ) = c(1 − ε cos θ), θ measured from the line of centres, ω̄ = (ω_i + ω_j)/2 and
// the velocity w = ė − ω̄ × e of the journal's centre in a frame that rotates with the mean surface
// speed, the right-hand side of Reynolds' equation is 12μ q, q = −n(θ)·w. Rotation and squeeze
// therefore act only through w = (w_r, w_t), and the force of the film on the journal opposes w.
//
// Short bearing (Ocvirk):  p̄ = ∫ p dz = μ L³ (n·w)/h³,   F = −μ L³ R ∫ n (n·w)/h³ dθ
//
//     full film     F_r = −μ R L³/c³ π(1 + 2ε²)/(1 − ε²)^(5/2) w_r
//                   F_t = −μ R L³/c³ π/(1 − ε²)^(3/2) w_t
//     cavitated     the integral over the half circle n·w > 0 (Gümbel), in closed form by
//                   Sommerfeld's substitution
//
// Long bearing (Sommerfeld), p = 0 at the widest gap:
//
//     p = 12μ R²/c³ { w_r/(2ε) [(1 − ε cos θ)^(−2) − (1 + ε)^(−2)]
//                     + w_t sin θ (2 − ε cos θ)/[(2 + ε²)(1 − ε cos θ)²] }
//     full film     F_r = −12π μ L R³/c³ w_r/(1 − ε²)^(3/2)
//                   F_t = −24π μ L R³/c³ w_t/[(2 + ε²)(1 − ε²)^(1/2)]
//     cavitated     the integral of the positive part of p, which is one interval that ends at the
//                   widest gap
//
// Finite length: Reynolds' equation over the length L, as ratios to the short bearing (finite_film.hpp).
//
// Sources: Ocvirk, NACA TN 2808 (1952); Sommerfeld, Z. Math. Phys. 50 (1904) 97; Gümbel, Mbl.
// Berlin. Bez. VDI (1914); Booker, J. Basic Eng. 87 (1965) 537, for w. The formulas are derived
// here and tested against quadrature of the pressure.
#pragma once

#include <memory>
#include <optional>
#include <type_traits>

#include "dynamics/evaluation.hpp"
#include "formulations/contact/finite_film.hpp"
#include "numerics/dual.hpp"

namespace freeplay {

struct Film {
  using Kind = Lubricant::Film;
  Kind kind = Kind::short_bearing;
  bool cavitated = true;
  double viscosity = 0;  ///< μ, Pa s
  double length = 0;     ///< L, m
  double radius = 0;     ///< R, m
  double clearance = 0;  ///< c, m
  double hand_over = 0;  ///< m, film thickness below which dry contact takes over gradually
  std::shared_ptr<const FiniteFilm> finite = {};  ///< of finite length

  template <class T>
  struct Force {
    T radial = 0;      ///< N, on the journal along n (away from the bearing's centre)
    T tangential = 0;  ///< N, on the journal along t
  };
  /// Force at the eccentricity ratio 0 ≤ ε < 1 and velocity w (m/s); T is double or Dual<4>.
  template <class T>
  Force<T> force(const T& epsilon, const std::type_identity_t<T>& w_r,
                 const std::type_identity_t<T>& w_t) const;
  /// Weight of the film at a gap g (m): 1 down to the hand-over thickness, then decreasing smoothly
  /// to 0 at dry contact. Below that thickness, force() is evaluated at that thickness, so that it
  /// stays bounded.
  template <class T>
  T share(const T& gap) const {
    if (gap >= hand_over) return 1;
    const T s = gap > 0 ? T(gap / hand_over) : T(0);
    return s * s * (3 - 2 * s);
  }
  /// The ε at which force() is evaluated for a gap.
  template <class T>
  T ratio(const T& gap) const {
    return 1 - (gap > hand_over ? gap : T(hand_over)) / clearance;
  }
  /// Resisting torque on the journal per relative rotation rate of journal and bearing (N m s):
  /// Petroff's shear of a full film, 2π μ R³ L/(c √(1 − ε²)).
  template <class T>
  T shear(const T& epsilon) const;
};

// Film force of a lubricated joint, in the form that all formulations use: forces along the
// contact's normal and film rows and a couple along its spin row (src/dynamics/evaluation.hpp),
// from the rates y = (ġ, w_t, ω_j − ω_i) of these rows,
//
//     (F_N, F_T, T) = s(g) (−F_r(ε, w), F_t(ε, w), −shear(ε) (ω_j − ω_i)),     w = (−ġ, w_t),
//
// where s is the weight of the film at the gap g (Film): 1 down to the hand-over thickness, 0
// where dry contact begins.

/// Forces and couple of a film, and the power that it dissipates (W).
template <class T>
struct FilmAction {
  T normal, tangential, torque, loss;
};

/// Returns nothing at gaps with dry contact only.
template <class T>
std::optional<FilmAction<T>> film_action(const Film& film, const T& gap, const T& normal_rate,
                                         const T& film_rate, const T& spin) {
  const T share = film.share(gap);
  if (share == 0) return std::nullopt;
  const T w_r = -normal_rate, ratio = film.ratio(gap);
  const auto F = film.force(ratio, w_r, film_rate);
  const T torque = share * film.shear(ratio) * spin;
  return FilmAction<T>{-share * F.radial, share * F.tangential, -torque,
                       torque * spin - share * (F.radial * w_r + F.tangential * film_rate)};
}

template <class T>
std::optional<FilmAction<T>> film_action(const Film& film, const T* v, const ContactRowOf<T>& row) {
  return film_action<T>(film, row.gap, row.normal.dot(v), row.film.dot(v), row.spin.dot(v));
}

/// The same with its derivatives by the gap and by the rates of the normal, film and spin rows.
using FilmSlopes = FilmAction<Dual<4>>;
inline std::optional<FilmSlopes> film_slopes(const Film& film, const double* v, const ContactRow& row) {
  const auto y = directions_of<4>({row.gap, row.normal.dot(v), row.film.dot(v), row.spin.dot(v)});
  return film_action(film, y[0], y[1], y[2], y[3]);
}

/// The film of a contact that has a lubricant. Throws ModelError outside the range of finite films.
std::optional<Film> make_film(const ContactFacts& facts);

}  // namespace freeplay

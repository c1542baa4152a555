#include "formulations/contact/film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mechanism/error.hpp"
#include "numerics/bracketed_root.hpp"
#include "numerics/dual.hpp"

namespace freeplay {
namespace {

constexpr double pi = std::numbers::pi;

/// Sommerfeld's γ of θ ∈ [−2π, 2π], continuous and increasing: cos γ = (cos θ − ε)/(1 − ε cos θ).
template <class T>
T sommerfeld(double theta, const T& epsilon) {
  using std::atan2, std::sqrt;
  const double turns = std::round(theta / (2 * pi)), x = theta - 2 * pi * turns;
  return 2 * pi * turns + atan2(T(sqrt(1 - epsilon * epsilon) * std::sin(x)), T(std::cos(x) - epsilon));
}

/// Integrals over θ from a to b of cos²θ, cos θ sin θ and sin²θ over (1 − ε cos θ)³.
template <class T>
struct ShortIntegrals {
  T cc, cs, ss;
};
template <class T>
ShortIntegrals<T> short_integrals(double a, double b, const T& epsilon) {
  using std::cos, std::sin, std::sqrt;
  const T s2 = 1 - epsilon * epsilon, s = sqrt(s2);
  const auto at = [&](const T& g) {
    const T sg = sin(g), cg = cos(g);
    return ShortIntegrals<T>{(g / 2 + sg * cg / 2 + 2 * epsilon * sg + epsilon * epsilon * g) / (s2 * s2 * s),
                             (sg * sg / 2 - epsilon * cg) / (s2 * s2), (g / 2 - sg * cg / 2) / (s2 * s)};
  };
  const auto A = at(sommerfeld(a, epsilon)), B = at(sommerfeld(b, epsilon));
  return {B.cc - A.cc, B.cs - A.cs, B.ss - A.ss};
}

/// ∫ p cos θ dθ and ∫ p sin θ dθ of the pressure of the long bearing (in units of 12μR²/c³) from a
/// to b.
template <class T>
struct LongIntegrals {
  T cosine, sine;
};
template <class T>
LongIntegrals<T> long_integrals(double a, double b, const T& epsilon, const T& w_r, const T& w_t) {
  using std::sin, std::sqrt;
  // With x = 1 − ε cos θ: squeeze and wedge terms by Sommerfeld's substitution, sine terms by the
  // primitive in x. These primitives have a removable singularity at ε = 0; below 1e-4 a series
  // replaces them.
  const T s2 = 1 - epsilon * epsilon, s = sqrt(s2), wedge = w_t / (2 + epsilon * epsilon);
  if (epsilon < 1e-4) {
    // p ≈ w_r (1 + cos θ) + w_t sin θ to zeroth order in ε; the next order is below 3ε relative.
    const auto at = [&](double t) {
      const double c = std::cos(t), sn = std::sin(t);
      return LongIntegrals<T>{w_r * (sn + t / 2 + sn * c / 2) + w_t * sn * sn / 2,
                              w_r * (-c + sn * sn / 2) + w_t * (t / 2 - sn * c / 2)};
    };
    const auto A = at(a), B = at(b);
    return {B.cosine - A.cosine, B.sine - A.sine};
  }
  const T far = 1 / ((1 + epsilon) * (1 + epsilon)), squeeze = w_r / (2 * epsilon);
  const auto at = [&](double theta) {
    const T g = sommerfeld(theta, epsilon), sg = sin(g);
    const T x = 1 - epsilon * std::cos(theta);
    // ∫ cos θ x^(−2) dθ = ∫ (cos γ + ε) dγ / s³
    const T c2 = (sg + epsilon * g) / (s2 * s);
    // ∫ sin θ x^(−2) dθ = −1/(ε x)
    const T s2x = -1 / (epsilon * x);
    // ∫ sin²θ (2 − ε cos θ) x^(−2) dθ = ∫ sin²θ/x² dθ + ∫ sin²θ/x dθ, as 2 − ε cos θ = 1 + x:
    //   ∫ sin²θ/x dθ = [θ + ε sin θ − s γ]/ε²
    const T i1 = (theta + epsilon * std::sin(theta) - s * g) / (epsilon * epsilon);
    //   ∫ sin²θ/x² dθ = −sin θ/(ε x) + (1/ε) ∫ cos θ/x dθ,   ∫ cos θ/x dθ = (γ/s − θ)/ε
    const T i2 = -std::sin(theta) / (epsilon * x) + (g / s - theta) / (epsilon * epsilon);
    // ∫ sin θ cos θ (1 + x) x^(−2) dθ with u = x, cos θ = (1 − u)/ε, sin θ dθ = du/ε:
    //   ∫ (1 − u)(1 + u)/u² du / ε² = (−1/u − u)/ε²
    const T sc = (-1 / x - x) / (epsilon * epsilon);
    return LongIntegrals<T>{squeeze * (c2 - far * std::sin(theta)) + wedge * sc,
                            squeeze * (s2x + far * std::cos(theta)) + wedge * (i1 + i2)};
  };
  const auto A = at(a), B = at(b);
  return {B.cosine - A.cosine, B.sine - A.sine};
}

}  // namespace

template <class T>
Film::Force<T> Film::force(const T& epsilon, const std::type_identity_t<T>& w_r,
                           const std::type_identity_t<T>& w_t) const {
  // The ends of the film need no derivatives: the pressure vanishes there, so that moving them has
  // no first-order effect.
  const double ratio = value_of(epsilon), radial = value_of(w_r), tangential = value_of(w_t);
  if (radial == 0 && tangential == 0) return {};
  const double c3 = clearance * clearance * clearance;
  if (kind != Kind::long_bearing) {
    const double unit = viscosity * radius * length * length * length / c3;
    const double middle = std::atan2(tangential, radial), half = cavitated ? pi / 2 : pi;
    const auto I = short_integrals(middle - half, middle + half, epsilon);
    if (kind == Kind::short_bearing)
      return {-unit * (I.cc * w_r + I.cs * w_t), -unit * (I.cs * w_r + I.ss * w_t)};
    using std::sqrt;
    if (!cavitated) {
      const auto ratio_of = finite->full(epsilon);
      return {-unit * ratio_of[0] * I.cc * w_r, -unit * ratio_of[1] * I.ss * w_t};
    }
    const T g_r = I.cc * w_r + I.cs * w_t, g_t = I.cs * w_r + I.ss * w_t;
    const T size = unit * sqrt(g_r * g_r + g_t * g_t), speed = sqrt(w_r * w_r + w_t * w_t);
    const auto ratio_of = finite->cavitated(epsilon, T(w_r / speed));
    return {-size * ratio_of[0], -size * ratio_of[1] * w_t / speed};
  }
  const double unit = 12 * viscosity * length * radius * radius * radius / c3;
  double a = -pi, b = pi;
  if (cavitated) {
    // p (1 − ε cos θ)²/(1 + cos θ) = w_r (2 + ε − ε cos θ)/(2(1 + ε)²) + w_t tan(θ/2)(2 − ε cos
    // θ)/(2 + ε²) has one zero.
    const auto sign = [&](double theta) {
      const double ct = std::cos(theta);
      return std::cos(theta / 2) * radial * (2 + ratio - ratio * ct) / (2 * (1 + ratio) * (1 + ratio)) +
             std::sin(theta / 2) * tangential * (2 - ratio * ct) / (2 + ratio * ratio);
    };
    if (tangential == 0) {
      if (radial < 0) return {};
    } else {
      (tangential > 0 ? a : b) = bracketed_root(sign, -pi, pi, {50, 100});
    }
  }
  const auto I = long_integrals(a, b, epsilon, w_r, w_t);
  return {-unit * I.cosine, -unit * I.sine};
}

template <class T>
T Film::shear(const T& epsilon) const {
  using std::sqrt;
  return 2 * pi * viscosity * radius * radius * radius * length / (clearance * sqrt(1 - epsilon * epsilon));
}

std::optional<Film> make_film(const ContactFacts& facts) {
  if (!facts.lubricant) return std::nullopt;
  const auto& oil = *facts.lubricant;
  Film film{oil.film,
            oil.cavitation == Lubricant::Cavitation::half_sommerfeld,
            oil.viscosity,
            *facts.bearing_length,
            facts.radius_bearing,
            facts.clearance,
            oil.hand_over.value_or(0.01 * facts.clearance)};
  if (film.kind != Film::Kind::finite_length) return film;
  const double length = film.length / (2 * film.radius);
  if (!(length >= FiniteFilm::least_length && length <= FiniteFilm::greatest_length))
    throw ModelError(fmt::format("joints.{}.bearing_length", facts.name),
                     fmt::format("gives L/D = {:.4g}; film = \"finite\" is for L/D from {} to {}, use {}",
                                 length, FiniteFilm::least_length, FiniteFilm::greatest_length,
                                 length < 1 ? "\"short\"" : "\"long\""));
  if (!(film.hand_over >= FiniteFilm::least_thickness * film.clearance * (1 - 1e-9)))
    throw ModelError(
        fmt::format("lubricants.{}.hand_over", oil.name),
        fmt::format("is {:.4g} m; film = \"finite\" needs at least clearance/1000, {:.4g} m in {}",
                    film.hand_over, FiniteFilm::least_thickness * film.clearance, facts.name));
  film.finite = finite_film(length);
  return film;
}

template Film::Force<double> Film::force(const double&, const double&, const double&) const;
template Film::Force<Dual<4>> Film::force(const Dual<4>&, const Dual<4>&, const Dual<4>&) const;
template double Film::shear(const double&) const;
template Dual<4> Film::shear(const Dual<4>&) const;

}  // namespace freeplay

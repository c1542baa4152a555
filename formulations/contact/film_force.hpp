// Film force of a lubricated joint, in the form that all formulations use: forces along the
// contact's normal and film rows and a couple along its spin row (src/dynamics/evaluation.hpp),
// from the rates y = (ġ, w_t, ω_j − ω_i) of these rows,
//
//     (F_N, F_T, T) = s(g) (−F_r(ε, w), F_t(ε, w), −shear(ε) (ω_j − ω_i)),     w = (−ġ, w_t),
//
// where s is the weight of the film at the gap g (film.hpp): 1 down to the hand-over thickness, 0
// where dry contact begins.
#pragma once

#include <optional>

#include "dynamics/evaluation.hpp"
#include "formulations/contact/film.hpp"

namespace freeplay {

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

/// The film of a contact that has a lubricant.
inline std::optional<Film> make_film(const ContactFacts& facts) {
  if (!facts.lubricant) return std::nullopt;
  const auto& oil = *facts.lubricant;
  return Film{
      oil.film == Lubricant::Film::short_bearing ? Film::Kind::short_bearing : Film::Kind::long_bearing,
      oil.cavitation == Lubricant::Cavitation::half_sommerfeld,
      oil.viscosity,
      *facts.bearing_length,
      facts.radius_bearing,
      facts.clearance,
      oil.hand_over.value_or(0.01 * facts.clearance)};
}

}  // namespace freeplay

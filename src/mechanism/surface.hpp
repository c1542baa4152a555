// Material pairs of contacts, and lubricants of clearances.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/keys.hpp"

namespace freeplay {

/// A pair of equal materials in contact. An absent property is not modelled: without `friction` the
/// contact has no tangential row, without `young` the penalty formulation refuses it.
struct Surface {
  static constexpr std::string_view what = "a surface";
  /// by which the scene refers to it
  std::string name;
  std::optional<double> young = {};        ///< Pa, > 0
  std::optional<double> poisson = {};      ///< in [0, 0.5]
  std::optional<double> restitution = {};  ///< coefficient of restitution, in [0, 1]
  std::optional<double> friction = {};     ///< Coulomb's μ, ≥ 0; empty: frictionless
  double tangential_restitution = 0;       ///< e_T in [0, 1], read by impact laws
  /// κ > 0, tangential over normal stiffness of a contact; read by the laws "mindlin" and
  /// "compliant"
  std::optional<double> stiffness_ratio = {};

  static void keys(auto& k, auto& s) {
    k.take({"young", "Pa", "Young's modulus, > 0; the penalty formulation needs it"}, s.young, positive);
    k.take({"poisson", "", "Poisson's ratio, 0 to 0.5; goes with young"}, s.poisson, zero_to_half);
    k.take({"restitution", "", "input coefficient of restitution, 0 to 1"}, s.restitution, zero_to_one);
    k.take({"friction", "", "Coulomb's coefficient, ≥ 0; if absent: frictionless"}, s.friction, non_negative);
    k.take(
        {"tangential_restitution", "", "e_T of impact laws, 0 to 1: Coulomb's law acts on v_T⁺ + e_T v_T⁻"},
        s.tangential_restitution, zero_to_one);
    k.take({"stiffness_ratio", "",
            "κ, tangential over normal stiffness, > 0, for friction \"mindlin\" and impact_law \"compliant\"",
            "2(1 − ν)/(2 − ν) of poisson"},
           s.stiffness_ratio, positive);
    k.check(s.young.has_value() == s.poisson.has_value(), s.young ? "young" : "poisson",
            "young and poisson go together; one of them is missing");
  }
};

/// A lubricant that fills a clearance.
struct Lubricant {
  /// Solution of Reynolds' equation.
  enum class Film { short_bearing, long_bearing };
  /// Treatment of negative film pressures.
  enum class Cavitation { half_sommerfeld, none };
  static constexpr std::string_view what = "a lubricant";
  /// by which the scene refers to it
  std::string name;
  double viscosity = 0;  ///< Pa s, > 0
  /// solution of Reynolds' equation
  Film film = Film::short_bearing;
  /// treatment of negative film pressures
  Cavitation cavitation = Cavitation::half_sommerfeld;
  /// m, film thickness below which dry contact takes over; default 0.01 clearance
  std::optional<double> hand_over = {};

  static void keys(auto& k, auto& l) {
    k.need({"viscosity", "Pa s", "dynamic viscosity, > 0"}, l.viscosity, positive);
    k.choose({"film", "", "journal bearing: "}, l.film);
    k.choose({"cavitation", "", ""}, l.cavitation);
    k.take(
        {"hand_over", "m", "film thickness below which the film is replaced by dry contact", "clearance/100"},
        l.hand_over, positive);
  }
};

inline constexpr auto film_names =
    complete<Lubricant::Film>({{Lubricant::Film::short_bearing, "short", "Ocvirk"},
                               {Lubricant::Film::long_bearing, "long", "Sommerfeld"}});
inline constexpr auto cavitation_names = complete<Lubricant::Cavitation>(
    {{Lubricant::Cavitation::half_sommerfeld, "half-sommerfeld", "no tension in the film"},
     {Lubricant::Cavitation::none, "none", "full film"}});
constexpr std::span<const Choice<Lubricant::Film>> choices(Lubricant::Film) { return film_names; }
constexpr std::span<const Choice<Lubricant::Cavitation>> choices(Lubricant::Cavitation) {
  return cavitation_names;
}

}  // namespace freeplay

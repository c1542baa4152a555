// Material pairs of contacts, and lubricants of clearances.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mechanism/keys.hpp"
#include "mechanism/static_friction.hpp"

namespace freeplay {

/// A pair of equal materials in contact. An absent property is not modelled: without `friction` the
/// contact has no tangential row, without `young` the penalty formulation refuses it.
///
/// The coefficient of restitution e is a constant, or depends on the approach speed v of a contact:
///
///     yield_speed         e = restitution · min(1, (v/yield_speed)^(−1/4))
///     restitution_table   linear between its points, constant outside
///
/// The first is the decay of fully plastic impacts, by K. L. Johnson, Contact Mechanics (1985), section
/// 11.5, from the speed v_y at which the material yields.
///
/// The coefficient of friction is a constant, or falls from a static value with the sliding speed
/// (mechanism/static_friction.hpp).
struct Surface {
  static constexpr std::string_view what = "a surface";
  /// by which the scene refers to it
  std::string name;
  std::optional<double> young = {};        ///< Pa, > 0
  std::optional<double> poisson = {};      ///< in [0, 0.5]
  std::optional<double> restitution = {};  ///< coefficient of restitution, in [0, 1]
  std::optional<double> friction = {};     ///< Coulomb's μ of sliding, ≥ 0; empty: frictionless
  double tangential_restitution = 0;       ///< e_T in [0, 1], read by impact laws
  /// κ > 0, tangential over normal stiffness of a contact; read by the laws "mindlin" and
  /// "compliant"
  std::optional<double> stiffness_ratio = {};
  std::optional<double> yield_speed = {};  ///< v_y, m/s, > 0; empty: constant restitution
  /// (approach speed in m/s, e) with increasing speeds; in place of `restitution`
  std::vector<std::pair<double, double>> restitution_table = {};
  /// Elastic layer of a bearing: Pa, > 0; in [0, 0.5); m, > 0. Read by the contact law "elastic-foundation"
  /// and by wear. All three or none.
  std::optional<double> layer_modulus = {}, layer_poisson = {}, layer_thickness = {};
  StaticFriction peak = {};  ///< of `friction`

  static void keys(auto& k, auto& s) {
    k.take({"young", "Pa", "Young's modulus, > 0; the penalty formulation needs it"}, s.young, positive);
    k.take({"poisson", "", "Poisson's ratio, 0 to 0.5; goes with young"}, s.poisson, zero_to_half);
    k.pairs(
        {"restitution_table", "m/s, –",
         "[[approach speed, restitution], ...] in place of restitution: linear between, constant outside"},
        s.restitution_table);
    const bool listed = !s.restitution_table.empty();
    k.check(s.restitution_table.size() != 1, "restitution_table", "must have two points or more, has 1");
    for (const auto& [speed, e] : s.restitution_table) {
      k.check(speed >= 0, "restitution_table", "must have approach speeds of 0 or greater, has ", speed);
      k.check(e >= 0 && e <= 1, "restitution_table", "must have restitutions between 0 and 1, has ", e);
    }
    if (k.when(!listed, {"restitution", "yield_speed"}, "cannot be combined with restitution_table")) {
      k.take({"restitution", "", "input coefficient of restitution, 0 to 1"}, s.restitution, zero_to_one);
      k.take({"yield_speed", "m/s",
              "approach speed > 0 above which restitution decreases as its power −1/4 (Johnson)",
              "constant restitution"},
             s.yield_speed, positive);
      k.check(listed || !s.yield_speed || s.restitution, "yield_speed",
              "needs restitution, the coefficient below this speed");
    }
    k.take({"friction", "", "Coulomb's coefficient, ≥ 0; if absent: frictionless"}, s.friction, non_negative);
    StaticFriction::keys(k, s.peak, s.friction.value_or(0));
    k.check(s.friction || !s.peak.static_friction, "static_friction", "goes with friction, which is missing");
    k.take(
        {"tangential_restitution", "", "e_T of impact laws, 0 to 1: Coulomb's law acts on v_T⁺ + e_T v_T⁻"},
        s.tangential_restitution, zero_to_one);
    k.take({"stiffness_ratio", "",
            "κ, tangential over normal stiffness, > 0, for friction \"mindlin\" and impact_law \"compliant\"",
            "2(1 − ν)/(2 − ν) of poisson"},
           s.stiffness_ratio, positive);
    k.check(s.young.has_value() == s.poisson.has_value(), s.young ? "young" : "poisson",
            "young and poisson go together; one of them is missing");
    k.take(
        {"layer_modulus", "Pa",
         "Young's modulus of the elastic layer of a bearing, > 0, for contact \"elastic-foundation\" and for "
         "wear; goes with the next two keys"},
        s.layer_modulus, positive);
    k.take({"layer_poisson", "", "Poisson's ratio of the layer, at least 0 and less than 0.5"},
           s.layer_poisson, zero_to_half);
    k.check(!s.layer_poisson || *s.layer_poisson < 0.5, "layer_poisson",
            "must be less than 0.5: a thin incompressible layer does not yield");
    k.take({"layer_thickness", "m", "thickness of the layer, > 0"}, s.layer_thickness, positive);
    k.check(s.layer_modulus.has_value() == s.layer_poisson.has_value() &&
                s.layer_modulus.has_value() == s.layer_thickness.has_value(),
            s.layer_modulus   ? "layer_modulus"
            : s.layer_poisson ? "layer_poisson"
                              : "layer_thickness",
            "layer_modulus, layer_poisson and layer_thickness go together; one of them is missing");
  }

  /// Whether μ depends on the sliding speed.
  bool friction_by_speed() const {
    return friction && peak.static_friction && *peak.static_friction > *friction;
  }
  /// μ at a sliding speed (m/s); the surface has friction.
  double friction_at(double slide) const {
    return friction_by_speed() ? peak.curve(*friction).coefficient(slide) : *friction;
  }
  /// The greatest friction of a sticking contact over its normal force; the surface has friction.
  double friction_at_rest() const { return friction_by_speed() ? *peak.static_friction : *friction; }
  /// dμ/du (s/m) at a sliding speed.
  double friction_slope(double slide) const {
    return friction_by_speed() ? peak.curve(*friction).coefficient_slope(slide) : 0;
  }
  /// Whether e depends on the approach speed.
  bool restitution_by_speed() const { return yield_speed || !restitution_table.empty(); }
  /// e at vanishing approach speed; empty: the surface has no restitution.
  std::optional<double> slow_restitution() const {
    return restitution_table.empty() ? restitution : restitution_table.front().second;
  }
  /// e of an impact with an approach speed (m/s); the surface has a restitution.
  double restitution_at(double approach) const;
  /// de/dv (s/m) there; at a kink from above.
  double restitution_slope(double approach) const;

 private:
  /// The end of the piece of the table that has a speed within it.
  auto piece_end(double approach) const {
    return std::ranges::upper_bound(restitution_table, approach, {}, [](const auto& p) { return p.first; });
  }
};

inline double Surface::restitution_at(double approach) const {
  if (restitution_table.empty())
    return !yield_speed || !(approach > *yield_speed)
               ? *restitution
               : *restitution / std::sqrt(std::sqrt(approach / *yield_speed));
  const auto to = piece_end(approach);
  if (to == restitution_table.begin()) return to->second;
  const auto from = std::prev(to);
  if (to == restitution_table.end()) return from->second;
  return std::lerp(from->second, to->second, (approach - from->first) / (to->first - from->first));
}

inline double Surface::restitution_slope(double approach) const {
  if (restitution_table.empty())
    return !yield_speed || approach < *yield_speed ? 0 : -restitution_at(approach) / (4 * approach);
  const auto to = piece_end(approach);
  if (to == restitution_table.begin() || to == restitution_table.end()) return 0;
  const auto from = std::prev(to);
  return (to->second - from->second) / (to->first - from->first);
}

/// A lubricant that fills a clearance.
struct Lubricant {
  /// Solution of Reynolds' equation.
  enum class Film { short_bearing, long_bearing, finite_length };
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
                               {Lubricant::Film::long_bearing, "long", "Sommerfeld"},
                               {Lubricant::Film::finite_length, "finite", "L/D from 0.05 to 4"}});
inline constexpr auto cavitation_names = complete<Lubricant::Cavitation>(
    {{Lubricant::Cavitation::half_sommerfeld, "half-sommerfeld", "no tension in the film"},
     {Lubricant::Cavitation::none, "none", "full film"}});
constexpr std::span<const Choice<Lubricant::Film>> choices(Lubricant::Film) { return film_names; }
constexpr std::span<const Choice<Lubricant::Cavitation>> choices(Lubricant::Cavitation) {
  return cavitation_names;
}

}  // namespace freeplay

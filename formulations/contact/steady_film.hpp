// SteadyFilm: a film in steady running, and its linear stiffness and damping. The journal turns at
// ω in a bearing at rest under a constant load W. At equilibrium ė = 0, hence w = (0, −½ω|e|), and
// the film force balances the load:
//
//     W = |F(ε)|,   attitude angle φ: from the load to the line of centres (from the bearing's
//                   centre to the journal's), positive in the direction of rotation
//     Sommerfeld number S = μ N L D/W (R/c)²,   N = ω/(2π),  D = 2R
//
// S is that of Raimondi and Boyd, ASLE Trans. 1 (1958) 159, in SI units. Linear coefficients, with
// x along the load and y at 90° from x in the direction of rotation:
//
//     K_ij = −∂F_i/∂x_j,   C_ij = −∂F_i/∂ẋ_j,   i, j = x, y;   dimensionless K c/W and C cω/W
//
// (Lund, J. Tribology 109 (1987) 37). The derivatives are exact, from dual numbers. A rigid rotor
// with the mass m per bearing is stable below the critical mass m_c, at which M s² + C s + K has a
// root s = iν (Routh–Hurwitz criterion):
//
//     k = (K_xx C_yy + K_yy C_xx − K_xy C_yx − K_yx C_xy)/(C_xx + C_yy)
//     ν² = [(k − K_xx)(k − K_yy) − K_xy K_yx]/(C_xx C_yy − C_xy C_yx),   m_c = k/ν²
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "formulations/contact/film.hpp"
#include "simulation/film_statistics.hpp"

namespace freeplay {

struct Scene;

struct SteadyFilm {
  /// [i][j], i and j: x along the load, y at 90° in the direction of rotation
  using Matrix = std::array<std::array<double, 2>, 2>;

  double load = 0;        ///< W, N
  double speed = 0;       ///< ω, rad/s, > 0
  double ratio = 0;       ///< ε
  double attitude = 0;    ///< φ, rad
  double sommerfeld = 0;  ///< S
  double thickness = 0;   ///< m, least film thickness c(1 − ε)
  double loss = 0;        ///< W, power that drives the journal
  Matrix stiffness{};     ///< N/m
  Matrix damping{};       ///< N s/m
  /// m_c (kg) of a rigid rotor, per bearing; 0: unstable at any mass; empty: stable at any mass
  std::optional<double> critical_mass;
  double whirl_ratio = 0;  ///< ν/ω at the critical mass; 0 if there is none

  /// Stiffness times c/W.
  Matrix scaled_stiffness(double clearance) const;
  /// Damping times cω/W.
  Matrix scaled_damping(double clearance) const;
};

/// S of a load (N) and a speed (rad/s), both > 0.
double sommerfeld_number(const Film& film, double load, double speed);

/// Steady running at the eccentricity ratio 0 < ε ≤ film.ratio(0). Below ε = 1e-4 the coefficients of
/// the long film have their leading order only.
SteadyFilm steady_film(const Film& film, double ratio, double speed);

/// ε at which the film carries a load; empty if the load exceeds the capacity at the hand-over
/// thickness, where dry contact begins to carry.
std::optional<double> steady_ratio(const Film& film, double load, double speed);

/// The note `film_length` on a short or long film outside its range of L/D; empty within.
std::optional<std::string> range_note(const std::string& joint, const Film& film);

/// The lubricant films of a scene at any state, for FilmStatistics.
std::unique_ptr<FilmProbe> film_probe(const Scene& scene);

}  // namespace freeplay

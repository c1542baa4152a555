// Journal bearings in closed form. Symbols: μ viscosity, ω the journal's speed in a bearing at
// rest, R, L, c radius, length and radial clearance, ε = e/c, W the load (N), φ the attitude angle
// from the load to the line of centres.
//
// Steady running, ė = 0:
//     long, full film (Sommerfeld 1904)    W = 12π μωLR³ ε/(c² (2 + ε²) √(1 − ε²)),  φ = π/2
//     long, half-Sommerfeld                W_r = 12 μωLR³ ε²/(c² (2 + ε²)(1 − ε²)),
//                                          W_t = half the full film's
//     short, full film                     W = π μωRL³ ε/(2c² (1 − ε²)^(3/2)),  φ = π/2
//     short, half-Sommerfeld (Ocvirk 1952) W_r = μωRL³ ε²/(c² (1 − ε²)²),
//                                          W_t = half the full film's
// so that tan φ = W_t/W_r is π√(1 − ε²)/(2ε) of the long and π√(1 − ε²)/(4ε) of the short one.
//
// Squeezing by a constant load, ω = 0, full film: with K f′(ε) ε̇ the film's resistance, the
// momentum is
//     m v + K f(ε) = W t + const,   short  K = π μRL³/c², f = ε/(1 − ε²)^(3/2),
//                                 long   K = 12π μLR³/c², f = ε/√(1 − ε²).
//
// An unloaded journal of mass m near the centre of a full film, z = e_x + i e_y, C its resistance
// there:
//     m z̈ + C (ż − ½iω z) = 0,   z = z₀ e^(st),   s = [−C + √(C² + 2imCω)]/(2m):
//     half the speed, and slowly outwards.
//
// Petroff (1883): a concentric journal is braked by 2π μωR³L/c.
// Sources as in Cameron, The Principles of Lubrication (1966), and Pinkus and Sternlicht, Theory of
// Hydrodynamic Lubrication (1961).
#pragma once

#include <cmath>
#include <complex>

#include "verification/references/bisection.hpp"

namespace freeplay::reference {

struct JournalBearing {
  bool is_short = true, cavitated = true;
  double viscosity = 0, radius = 0, length = 0, clearance = 0;  // Pa s, m

  struct Load {
    double radial, tangential;
  };
  /// Load capacity of the film at an eccentricity and speed (rad/s).
  Load load(double e, double omega) const {
    const double pi = 3.14159265358979323846, s2 = 1 - e * e, share = cavitated ? 0.5 : 1;
    const double c2 = clearance * clearance;
    if (is_short) {
      const double unit = viscosity * omega * radius * std::pow(length, 3) / c2;
      return {cavitated ? unit * e * e / (s2 * s2) : 0, share * unit * pi * e / (2 * std::pow(s2, 1.5))};
    }
    const double unit = 12 * viscosity * omega * length * std::pow(radius, 3) / c2;
    return {cavitated ? unit * e * e / ((2 + e * e) * s2) : 0,
            share * unit * pi * e / ((2 + e * e) * std::sqrt(s2))};
  }
  /// Magnitude of the load (N).
  double capacity(double e, double omega) const {
    const auto found = load(e, omega);
    return std::hypot(found.radial, found.tangential);
  }
  /// ε that carries W, by bisection: the load increases with ε.
  double eccentricity(double W, double omega) const {
    double low = 0, high = 1 - 1e-12;
    bisect(low, high, 200, [&](double e) { return capacity(e, omega) < W; });
    return 0.5 * (low + high);
  }
  double attitude(double e, double omega) const {
    const auto found = load(e, omega);
    return std::atan2(found.tangential, found.radial);
  }
  /// N s, of the squeezing.
  double K() const {
    const double pi = 3.14159265358979323846, c2 = clearance * clearance;
    return is_short ? pi * viscosity * radius * std::pow(length, 3) / c2
                    : 12 * pi * viscosity * length * std::pow(radius, 3) / c2;
  }
  double f(double e) const { return is_short ? e / std::pow(1 - e * e, 1.5) : e / std::sqrt(1 - e * e); }
  /// N s/m, resistance of the full film at the centre.
  double centre() const { return K() / clearance; }
  /// N m s, Petroff's friction torque over ω.
  double petroff() const {
    return 2 * 3.14159265358979323846 * viscosity * std::pow(radius, 3) * length / clearance;
  }
};

/// The exponent of a light journal's whirl (1/s).
inline std::complex<double> whirl(double mass, double resistance, double omega) {
  const std::complex<double> i(0, 1);
  return (-resistance + std::sqrt(resistance * resistance + 2.0 * i * mass * resistance * omega)) /
         (2.0 * mass);
}

}  // namespace freeplay::reference

// Lyapunov exponents of billiards by the curvature of wave fronts. A front with curvature κ that flies the
// length τ becomes κ/(1 + κτ), its width grows by 1 + κτ, and a reflection at a disc of radius a with the
// angle of incidence φ adds 2/(a cos φ); a straight wall adds nothing. At unit speed the exponent is the
// mean of ln(1 + κτ) over that of τ. No tangent vector is integrated. Source: Sinai, Russ. Math. Surveys 25
// (1970) 137; Gaspard, Chaos, Scattering and Statistical Mechanics (1998), section 5.
#pragma once

#include <cmath>
#include <random>
#include <utility>
#include <vector>

namespace freeplay::reference {

/// Growth of a perturbation at each reflection of a periodic path whose flights have equal lengths τ and
/// equal angles of incidence. In κ = κ/(1 + κτ) + c with c = 2/(a cos φ) the root κ > 0 gives 1 + κτ.
inline long double stretching(long double flight, long double radius, long double cosine) {
  const long double c = 2 / (radius * cosine);
  return 1 + flight * (c + std::sqrt(c * c + 4 * c / flight)) / 2;
}

/// Discs of radius a whose centres are R apart. The path between two of them has flights R − 2a and no
/// angle of incidence: R/a − 1 + √((R/a)(R/a − 2)).
inline long double two_discs(long double radius, long double distance) {
  return stretching(distance - 2 * radius, radius, 1);
}
/// The path round three of them: it meets each at 30° on the line to the centre, with flights of R − √3 a.
inline long double flight_round_three_discs(long double radius, long double distance) {
  return distance - std::sqrt(3.0L) * radius;
}
inline long double three_discs(long double radius, long double distance) {
  return stretching(flight_round_three_discs(radius, distance), radius, std::sqrt(3.0L) / 2);
}

/// A point of unit speed in the square |x|, |y| ≤ half with a disc of radius a about the origin.
struct SinaiBilliard {
  double half, radius;
  struct Exponent {
    double value, error;  ///< 1/length, from means of 100 batches
  };
  Exponent exponent(long reflections, unsigned seed) const {
    std::mt19937_64 random(seed);
    const double direction = std::uniform_real_distribution<double>(0, 2 * std::acos(-1.0))(random);
    double x = -0.9 * half, y = 0.7 * half, u = std::cos(direction), w = std::sin(direction), curvature = 1;
    constexpr int batches = 100;
    std::vector<double> means;
    double all = 0, whole = 0;
    for (int b = -1; b < batches; ++b) {  // the first one is a transient
      double sum = 0, length = 0;
      for (long i = 0; i < reflections / batches; ++i) {
        double flight = INFINITY;
        int wall = 0;  // 1: x, 2: y, 3: disc
        const auto nearer = [&](double t, int which) {
          if (t > 1e-12 && t < flight) flight = t, wall = which;
        };
        if (u != 0) nearer((std::copysign(half, u) - x) / u, 1);
        if (w != 0) nearer((std::copysign(half, w) - y) / w, 2);
        const double along = -(x * u + y * w), off = x * w - y * u;
        if (along > 0 && std::abs(off) < radius) nearer(along - std::sqrt(radius * radius - off * off), 3);
        x += flight * u;
        y += flight * w;
        sum += std::log1p(curvature * flight);
        length += flight;
        curvature /= 1 + curvature * flight;
        if (wall == 1) u = -u;
        if (wall == 2) w = -w;
        if (wall == 3) {
          const double cosine = -(x * u + y * w) / radius;
          curvature += 2 / (radius * cosine);
          u += 2 * cosine * x / radius;
          w += 2 * cosine * y / radius;
          const double speed = std::hypot(u, w);
          u /= speed;
          w /= speed;
        }
      }
      if (b < 0) continue;
      means.push_back(sum / length);
      all += sum;
      whole += length;
    }
    double squares = 0;
    for (const double m : means) squares += (m - all / whole) * (m - all / whole);
    return {all / whole, std::sqrt(squares / (batches * (batches - 1.0)))};
  }
};

}  // namespace freeplay::reference

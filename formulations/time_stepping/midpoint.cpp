#include "formulations/time_stepping/midpoint.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

MeanVelocity::Verdict MeanVelocity::assess(int iteration, const MidpointTerms& terms, const Motion& motion,
                                           Kind kind, std::vector<double>& v_mean) {
  constexpr int damped_after = 10;  // a pulse of a table may cause oscillations
  constexpr int rounding_after = 20;
  constexpr int most = 50, most_swept = 100;
  const double h = motion.h;
  double change = 0, size = 0, place = motion.reach;
  for (int c = 0; c < terms.n; ++c) {
    double mean = 0.5 * (motion.v_old[c] + motion.v[c]);
    if (iteration >= damped_after && (kind.sweeps || kind.films)) mean = 0.5 * (mean + v_mean[c]);
    // Angular rates are multiplied by the radius of gyration.
    const double arm = c % 3 == 2 ? std::sqrt(terms.mass[c] / terms.mass[c - 1]) : 1;
    change = std::max(change, arm * std::abs(motion.v[c] - last[c]));
    // At rest, rates are the rounding errors of balanced forces.
    size =
        std::max(size, arm * std::max(std::abs(mean), 0.01 * h * std::abs(terms.force[c]) / terms.mass[c]));
    place = std::max(place, arm * std::abs(motion.q_mid[c]));
    v_mean[c] = mean;
  }
  if (kind.films) size += motion.film_change;
  if (iteration > 0 && change <= 1e-12 * size) return Verdict::met;
  // Near rest, the remaining change is the rounding error of balanced forces, each far greater than
  // their sum. It moves no body by more than the rounding error of its position.
  if (iteration >= rounding_after && (change <= 1e-9 * size || h * change <= 1e-16 * place))
    return Verdict::met;
  if (kind.films && iteration >= damped_after) {
    // contact problems are solved to this accuracy only
    if (change <= 1e-9 * size) return Verdict::met;
    if (iteration == most && kind.fixed && std::isfinite(change)) return Verdict::unsettled;
  }
  if (iteration == most_swept && kind.sweeps && std::isfinite(change)) return Verdict::unswept;
  if (iteration == (kind.sweeps ? most_swept + 1 : most) || !std::isfinite(change)) return Verdict::diverged;
  std::copy_n(motion.v, terms.n, last.begin());
  return Verdict::again;
}

}  // namespace freeplay

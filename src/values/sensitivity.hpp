// Derivatives of results of a run with respect to keys of its scene or its initial state.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace freeplay {

/// One quantity with its derivatives with respect to all requested keys.
struct Sensitivity {
  /// as requested: event.1.t, end.ball.vy, energy.dissipated_in_contacts
  std::string name;
  /// in SI units; NaN if the run does not reach it
  double value = NAN;
  /// in SI units, one for each key; NaN where there is none
  std::vector<double> derivatives;
  /// for each key, the reason why there is no derivative; empty if there is one
  std::vector<std::string> reasons;
  /// for each key, an estimate of the error of the derivative; infinite if a run with other settings has no
  /// derivative, NaN where there is no derivative or no estimate was requested
  std::vector<double> errors = {};
};

/// All results of a sensitivity run.
struct Sensitivities {
  /// keys as requested
  std::vector<std::string> keys;
  /// value of each key, SI
  std::vector<double> key_values;
  /// in the order of the request
  std::vector<Sensitivity> quantities;
  /// Cost of the variational equations as a multiple of that of the run: evaluations of the right-hand
  /// side, each direction of a derivative counted as one.
  double cost = 0;
  /// reason why the run stopped before its end; empty if it did not
  std::string stopped;
};

/// Scale of the derivative of a quantity with respect to a key: its size, or a thousandth of the change of
/// the quantity with the value of any key or of the quantity itself, over the value of this key.
inline double derivative_scale(const Sensitivities& all, const Sensitivity& q, std::size_t key) {
  double change = std::isfinite(q.value) ? std::abs(q.value) : 0;
  for (std::size_t i = 0; i < q.derivatives.size(); ++i)
    if (const double part = std::abs(q.derivatives[i] * all.key_values[i]); part > change) change = part;
  const double p = std::abs(all.key_values[key]);
  const double least = 1e-3 * change / (p > 0 ? p : 1), size = std::abs(q.derivatives[key]);
  return size > least ? size : least;
}
/// Whether the error of a derivative exceeds 1e-4 of its scale, or is unknown.
inline bool is_inexact(const Sensitivities& all, const Sensitivity& q, std::size_t key) {
  return std::isfinite(q.derivatives[key]) && key < q.errors.size() &&
         !(q.errors[key] <= 1e-4 * derivative_scale(all, q, key));
}

}  // namespace freeplay

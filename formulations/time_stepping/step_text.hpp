// The operations of a step of the midpoint rule (equations: moreau.hpp). The same text gives numbers in
// MoreauStepper and the operations of compiled steps (lane_trace.cpp): T is double or Traced.
#pragma once

#include <cstddef>

#include "dynamics/evaluation.hpp"
#include "numerics/choice.hpp"
#include "numerics/sparse.hpp"

namespace freeplay {

/// x + (h/2) v of n coordinates.
template <class T>
void half_step(std::size_t n, const T& h, const T* x, const T* v, T* out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = x[i] + 0.5 * h * v[i];
}

/// (v₀ + v)/2
template <class T>
void mean_of(std::size_t n, const T* v_old, const T* v, T* out) {
  for (std::size_t i = 0; i < n; ++i) out[i] = 0.5 * (v_old[i] + v[i]);
}

/// Equations of a step of h (s) between velocities v and v⁺, with all other quantities at its middle,
///
///     M (v⁺ − v) + GᵀΛ = h f,        G v⁺ + Φ_t = (h/2) γ    (the rate of Φ at the end of the step)
///
/// as the saddle point M v⁺ + GᵀΛ = M v + h f, G v⁺ = −Φ_t + (h/2) γ.
template <class T>
struct MidpointTermsOf {
  int n = 0, m = 0;              ///< coordinates, constraint rows
  const double* mass = nullptr;  ///< n
  const T* force = nullptr;      ///< n, f
  const T* phi_t = nullptr;      ///< m
  const T* gamma = nullptr;      ///< m

  /// The right-hand sides of the saddle point: `f` of size n, `r` of size m.
  void sides(const T& h, const T* v, T* f, T* r) const {
    for (int i = 0; i < n; ++i) f[i] = mass[i] * v[i] + h * force[i];
    for (int k = 0; k < m; ++k) r[k] = -phi_t[k] + 0.5 * h * gamma[k];
  }
};
using MidpointTerms = MidpointTermsOf<double>;

/// Gap (m) of a contact at the end of a step, from its row at the middle and its normal rate W_N v⁺.
template <class T>
T gap_at_end(const ContactRowOf<T>& row, const T& rate, const T& h) {
  return row.gap + 0.5 * h * (rate - 0.25 * h * row.gamma_n);
}

/// u⁻ − W v = W v⁺ − u⁺, from the row's γ (see contact_set.hpp).
template <class T>
T rate_bias(const T& gamma, const T& h) {
  return 0.5 * h * gamma;
}

/// x + P_N a_N + P_T a_T of n entries.
template <class T>
void push(std::size_t n, const T& P_n, const T* a_n, const T& P_t, const T* a_t, T* x) {
  for (std::size_t i = 0; i < n; ++i) x[i] = x[i] + P_n * a_n[i] + P_t * a_t[i];
}

/// Works of the impulse Λ of a constraint row on the mean velocity: `driven` of its drive, and `rest`, the
/// work of the row's error, which its sign takes from the energy.
template <class T>
struct RowWork {
  T driven, rest;
};
template <class T>
RowWork<T> row_work(const CsrPattern& G, const T* value, int k, const T* mean, const T& impulse,
                    const T& phi_t) {
  return {impulse * phi_t, impulse * (row_dot(G, value, k, mean) + phi_t)};
}

}  // namespace freeplay

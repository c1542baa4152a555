// Contact laws of K unilateral contacts in minimal coordinates, by enumeration. In
//
//     M x = f + Σ_k (n_k N_k + t_k T_k)
//
// every contact is open (N = T = 0), sticks (n x = a, t x = b) or slides one way (n x = a,
// T = ∓μ N). With x = q̈ these are the accelerations and forces between events, with x = q̇⁺ − q̇⁻
// and f = 0 the impulses of an impact. n and t are the rows of the gap rate and the sliding rate.
// All combinations are tried until one satisfies the inequalities of the laws.
// Source: Glocker, Set-Valued Force Laws (2001). No solver of the program is included.
//
// A mechanism `System` has: `coordinates`, `contacts`; mass(q), force(q, v), contact(k, q, v);
// the arrays `restitution` and `friction`. Units: those of the mechanism, s.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "verification/references/elimination.hpp"

namespace freeplay::reference {

using Long = long double;

/// One contact in a state: gap, rows of the gap rate and of the sliding rate, and the parts of the
/// accelerations of gap and sliding that do not contain q̈.
template <std::size_t N>
struct ContactRows {
  Long gap{};
  std::array<Long, N> n{}, t{};
  Long n_bias{}, t_bias{};
};

template <std::size_t N>
Long product(const std::array<Long, N>& a, const std::array<Long, N>& b) {
  Long sum = 0;
  for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
  return sum;
}

enum class ContactMode { open, sticks, slides_up, slides_down };  ///< slides_up: sliding rate > 0

template <class System>
struct ContactModes {
  static constexpr std::size_t N = System::coordinates, K = System::contacts;
  using Vector = std::array<Long, N>;
  using Values = std::array<Long, K>;
  using Modes = std::array<ContactMode, K>;
  using Rows = std::array<ContactRows<N>, K>;
  struct Answer {
    Vector x{};
    Values normal{}, sliding{};  ///< N, T
  };
  System system;

  Rows rows(const Vector& q, const Vector& v) const {
    Rows all;
    for (std::size_t k = 0; k < K; ++k) all[k] = system.contact(k, q, v);
    return all;
  }

  /// The equations above for given modes; `a`, `b`: n x and t x of closed and sticking contacts.
  std::optional<Answer> solve(const Vector& q, const Vector& f, const Rows& all, const Modes& modes,
                              const Values& a, const Values& b) const {
    const auto mass = system.mass(q);
    std::array<std::size_t, K> at_n{}, at_t{};
    std::size_t size = N;
    for (std::size_t k = 0; k < K; ++k) {
      if (modes[k] == ContactMode::open) continue;
      at_n[k] = size++;
      if (modes[k] == ContactMode::sticks && system.friction[k] > 0) at_t[k] = size++;
    }
    std::vector<std::vector<Long>> A(size, std::vector<Long>(size, 0));
    std::vector<Long> r(size, 0);
    for (std::size_t i = 0; i < N; ++i) {
      std::copy(mass[i].begin(), mass[i].end(), A[i].begin());
      r[i] = f[i];
      for (std::size_t k = 0; k < K; ++k) {
        if (at_n[k] == 0) continue;
        A[i][at_n[k]] = -all[k].n[i] - slope(k, modes[k]) * all[k].t[i];
        A[at_n[k]][i] = all[k].n[i], r[at_n[k]] = a[k];
        if (at_t[k] == 0) continue;
        A[i][at_t[k]] = -all[k].t[i];
        A[at_t[k]][i] = all[k].t[i], r[at_t[k]] = b[k];
      }
    }
    if (!eliminate(A, r)) return std::nullopt;
    Answer found;
    std::copy_n(r.begin(), N, found.x.begin());
    for (std::size_t k = 0; k < K; ++k) {
      if (at_n[k] == 0) continue;
      found.normal[k] = r[at_n[k]];
      found.sliding[k] = at_t[k] != 0 ? r[at_t[k]] : slope(k, modes[k]) * found.normal[k];
    }
    return found;
  }

  std::optional<Answer> acceleration(const Vector& q, const Vector& v, const Modes& modes) const {
    const auto all = rows(q, v);
    Values a{}, b{};
    for (std::size_t k = 0; k < K; ++k) a[k] = -all[k].n_bias, b[k] = -all[k].t_bias;
    return solve(q, system.force(q, v), all, modes, a, b);
  }

  /// Advances to the next combination of modes of the contacts in `among`; false after the last.
  bool next(Modes& modes, const std::array<bool, K>& among) const {
    for (std::size_t k = 0; k < K; ++k) {
      if (!among[k]) continue;
      const auto last = system.friction[k] > 0 ? ContactMode::slides_down : ContactMode::sticks;
      if (modes[k] != last) {
        modes[k] = ContactMode(int(modes[k]) + 1);
        return true;
      }
      modes[k] = ContactMode::open;
    }
    return false;
  }

  /// Whether a closed contact satisfies N ≥ 0 and Coulomb's law, where `slip` is its sliding rate
  /// or the rate of it; up to `small`.
  bool lawful(std::size_t k, ContactMode mode, const Answer& x, Long slip, Long small) const {
    if (x.normal[k] < -small) return false;
    if (mode == ContactMode::sticks)
      return system.friction[k] <= 0 || std::abs(x.sliding[k]) <= system.friction[k] * x.normal[k] + small;
    return mode == ContactMode::slides_up ? slip >= -small : slip <= small;
  }

 private:
  /// T/N of a sliding contact.
  Long slope(std::size_t k, ContactMode mode) const {
    if (mode == ContactMode::slides_up) return -system.friction[k];
    return mode == ContactMode::slides_down ? system.friction[k] : 0;
  }
};

}  // namespace freeplay::reference

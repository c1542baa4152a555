// Mechanisms with unilateral contacts in minimal coordinates: their contact laws, and their motion
// from event to event.
//
// Contact laws of K unilateral contacts, by enumeration. In
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
#include <stdexcept>
#include <utility>
#include <vector>

#include "verification/references/numerics.hpp"

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

// Event-driven motion of a mechanism with unilateral contacts in minimal coordinates (the
// equations and laws above). An impact follows Newton's law for all closed contacts,
//
//     0 ≤ n q̇⁺ + e n q̇⁻ ⟂ Λ_N ≥ 0,      −Λ_T ∈ μ Λ_N Sgn(t q̇⁺)
//
// (Moreau 1988; e acts on contacts that approach). Between events each step has order 8 (Cooper and
// Verner); the first violation of the present contact modes within a step is located by bisection
// to 1e-19 s. Then the impact is solved, if a contact has closed, and the modes are determined anew
// from the accelerations. Nothing is shared with Freeplay's solvers. Units: those of the mechanism.

struct PublishedImpact {
  Long t{};  ///< s
  std::size_t contact{};
  Long v_n_minus{}, v_n_plus{};  ///< rate of the gap
  Long v_t_minus{}, v_t_plus{};  ///< sliding rate
  Long impulse_n{}, impulse_t{};
};

template <class System>
class ContactEvents {
 public:
  using Laws = ContactModes<System>;
  using Vector = typename Laws::Vector;
  static constexpr std::size_t N = Laws::N, K = Laws::K;
  Long t = 0;
  Vector q{}, v{};
  std::vector<PublishedImpact> impacts;

  ContactEvents(const System& system, const Vector& q0, const Vector& v0, Long step)
      : q(q0), v(v0), laws_{system}, step_(step) {
    settle();
  }
  void run(Long until) {
    while (t < until) advance(std::min(step_, until - t));
  }
  bool closed(std::size_t k) const { return modes_[k] != ContactMode::open; }

 private:
  using Set = std::array<bool, K>;

  void impact(const Set& among) {
    const auto all = laws_.rows(q, v);
    typename Laws::Values a{}, b{};
    for (std::size_t k = 0; k < K; ++k) {
      const Long rate = product(all[k].n, v);
      a[k] = -(1 + (rate < 0 ? laws_.system.restitution[k] : 0)) * rate, b[k] = -product(all[k].t, v);
    }
    typename Laws::Modes modes{};
    do {
      const auto x = laws_.solve(q, Vector{}, all, modes, a, b);
      bool holds = x.has_value();
      for (std::size_t k = 0; holds && k < K; ++k) {
        if (!among[k]) continue;
        holds = modes[k] == ContactMode::open
                    ? product(all[k].n, x->x) >= a[k] - small
                    : laws_.lawful(k, modes[k], *x, product(all[k].t, x->x) - b[k], small);
      }
      if (!holds) continue;
      const Vector before = v;
      for (std::size_t i = 0; i < N; ++i) v[i] += x->x[i];
      for (std::size_t k = 0; k < K; ++k)
        if (among[k])
          impacts.push_back({t, k, product(all[k].n, before), product(all[k].n, v), product(all[k].t, before),
                             product(all[k].t, v), x->normal[k], x->sliding[k]});
      return;
    } while (laws_.next(modes, among));
    throw std::runtime_error("no impact satisfies the contact laws");
  }

  /// Modes of the contacts with zero gap and zero gap rate, from the accelerations.
  void settle() {
    const auto all = laws_.rows(q, v);
    Set among{};
    for (std::size_t k = 0; k < K; ++k)
      among[k] = std::abs(all[k].gap) < 1e-13L && std::abs(product(all[k].n, v)) < 1e-13L;
    typename Laws::Modes modes{};
    do {
      const auto x = laws_.acceleration(q, v, modes);
      bool holds = x.has_value();
      for (std::size_t k = 0; holds && k < K; ++k) {
        if (!among[k]) continue;
        const Long slip = product(all[k].t, v);
        const bool still = std::abs(slip) < still_rate;
        if (modes[k] == ContactMode::open)
          holds = product(all[k].n, x->x) + all[k].n_bias >= -small;
        else if (modes[k] == ContactMode::sticks && laws_.system.friction[k] > 0 && !still)
          holds = false;
        else
          holds =
              laws_.lawful(k, modes[k], *x, still ? product(all[k].t, x->x) + all[k].t_bias : slip, small);
      }
      if (!holds) continue;
      modes_ = modes;
      return;
    } while (laws_.next(modes, among));
    throw std::runtime_error("no acceleration satisfies the contact laws");
  }

  /// Whether a state violates the present modes; `closing`: open contacts that have closed.
  bool violated(const Vector& at, const Vector& rate, Set& closing) const {
    const auto all = laws_.rows(at, rate);
    const auto x = laws_.acceleration(at, rate, modes_);
    bool any = false;
    for (std::size_t k = 0; k < K; ++k) {
      const auto mode = modes_[k];
      closing[k] = mode == ContactMode::open && all[k].gap < -1e-17L && product(all[k].n, rate) < 0;
      const Long slip = product(all[k].t, rate), bound = laws_.system.friction[k] * x->normal[k];
      any = any || closing[k] || (mode != ContactMode::open && x->normal[k] < -2 * small) ||
            (mode == ContactMode::slides_up && slip < -still_rate / 10) ||
            (mode == ContactMode::slides_down && slip > still_rate / 10) ||
            (mode == ContactMode::sticks && bound > 0 && std::abs(x->sliding[k]) > bound + 2 * small);
    }
    return any;
  }

  /// One step of h, or up to the first event in it.
  void advance(Long h) {
    using State = std::array<Long, 2 * N>;
    State y;
    std::copy(q.begin(), q.end(), y.begin());
    std::copy(v.begin(), v.end(), y.begin() + N);
    const auto split = [](const State& z, Vector& at, Vector& rate) {
      std::copy_n(z.begin(), N, at.begin());
      std::copy_n(z.begin() + N, N, rate.begin());
    };
    const auto derivative = [&](Long, const State& z) {
      Vector at, rate;
      split(z, at, rate);
      const auto x = laws_.acceleration(at, rate, modes_);
      State d;
      std::copy(rate.begin(), rate.end(), d.begin());
      std::copy(x->x.begin(), x->x.end(), d.begin() + N);
      return d;
    };
    Set closing{};
    const auto event_after = [&](Long length) {
      Vector at, rate;
      split(method_.step(derivative, t, y, length), at, rate);
      return violated(at, rate, closing);
    };
    const bool event = event_after(h);
    Long low = 0;
    while (event && h - low > 1e-19L && (low + h) / 2 > low) {
      const Long middle = (low + h) / 2;
      (event_after(middle) ? h : low) = middle;
    }
    event_after(h);
    split(method_.step(derivative, t, y, h), q, v);
    t += h;
    if (!event) return;
    if (std::find(closing.begin(), closing.end(), true) != closing.end()) {
      for (std::size_t k = 0; k < K; ++k) closing[k] = closing[k] || closed(k);
      impact(closing);
    }
    settle();
  }

  /// Inequalities hold up to `small`; a mode is left at twice it, so that the modes chosen at an
  /// event differ from those before it. A contact with less than `still_rate` may stick.
  static constexpr Long small = 1e-14L, still_rate = 1e-12L;
  Laws laws_;
  Long step_;
  typename Laws::Modes modes_{};
  CooperVerner<Long> method_;
};

/// The impacts of a motion up to `until` (s).
template <class System>
std::vector<PublishedImpact> impacts_until(ContactEvents<System> motion, Long until) {
  motion.run(until);
  return motion.impacts;
}

}  // namespace freeplay::reference
